"""Sweeps: a scene simulated over a grid or a sample of its parameters, on all cores or on a cluster, to a file."""
