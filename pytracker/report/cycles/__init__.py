"""Clouds of particles: `figures` of one cycle of a filter, `drawing` and what is of an `arm` or a `body` alone."""
