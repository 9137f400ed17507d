"""File formats, one a module: text and videos to arrays in SI units, with errors that name the place."""
