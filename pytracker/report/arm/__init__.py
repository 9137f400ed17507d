"""An arm's report: its `page`, `figures` and `overlay`."""
