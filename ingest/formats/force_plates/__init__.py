"""Files of force plates, one maker's export a file."""
