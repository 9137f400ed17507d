"""What other programs read: `tables` and `metadata`, `json_file` as every reader takes it, `export` as TRC or C3D."""
