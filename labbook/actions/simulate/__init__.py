"""Scenes simulated: one, a sweep, the thesis's figures, and what accuracy costs."""
