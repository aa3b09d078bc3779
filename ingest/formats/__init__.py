"""File formats: each with what recognises and what reads it."""
