"""Height logs: stances, flights, jumps and apexes, by two detectors."""
