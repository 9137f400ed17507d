"""Many runs: the `page` of a study and its `figures`."""
