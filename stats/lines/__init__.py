"""Least squares: lines, polynomials, planes, and what a lab fits with them."""
