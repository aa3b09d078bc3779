"""Studies beside the jumps, from what was measured to what it says."""
