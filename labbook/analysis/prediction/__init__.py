"""What simulations give for the measured conditions, and how far apart the two are."""
