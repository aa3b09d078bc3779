"""What was decided before the first measurement, and what departs from it."""
