"""What `labbook.toml` says."""
