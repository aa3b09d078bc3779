"""What `labbook stats` says and draws."""
