"""Jumps computed to thirty digits and more, by a method that shares nothing with the fast simulator."""
