"""Effects left out of a scene: what changes without each, what it costs in time, which effects are enough."""
