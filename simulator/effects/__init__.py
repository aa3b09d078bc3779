"""The pieces of physics a scene is composed of, one file each; `registry.EFFECTS` lists them."""
