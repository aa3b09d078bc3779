"""From what was computed to what a command shows."""
