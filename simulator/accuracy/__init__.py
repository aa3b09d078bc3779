"""What accuracy costs: one scene computed by several methods at many settings, against a reference."""
