"""Effects (such as lens, media or textures) that a scene uses, the elements that use them, and their removal."""
