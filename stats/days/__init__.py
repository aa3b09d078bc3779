"""Values that belong to days: mixed model, exact tests of balanced designs, autocorrelation."""
