"""What each effect of a scene is worth: what changes without it, what it costs in time, which effects are enough."""
