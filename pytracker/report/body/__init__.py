"""A body's report: its `page`, `figures`, `overlay`, and pictures of its `evidence`."""
