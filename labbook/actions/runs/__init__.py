"""Runs and jumps: stating, correcting, judging and looking at them."""
