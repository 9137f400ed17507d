"""What a recording.toml in the making says: what is `known` of camera and arm, of the `subject`, of the `truth`."""
