"""Where guards have their zeros, and what the contact mode becomes there."""
