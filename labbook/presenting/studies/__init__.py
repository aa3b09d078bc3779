"""Results of studies as sentences and as data."""
