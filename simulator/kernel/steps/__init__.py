"""How a step is chosen, tried, taken and read between its ends."""
