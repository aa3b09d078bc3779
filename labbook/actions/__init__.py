"""What the commands do, one file an action; `labbook.cli` only parses and prints."""
