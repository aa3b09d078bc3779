"""What a run and a condition come to: joules, apexes, and what these are computed from."""
