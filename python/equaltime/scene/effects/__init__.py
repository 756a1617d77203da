"""Effects of a scene: features such as a lens, media or textures, each with a name.

This package finds the effects that a scene uses, names the objects that use each effect, and leaves effects out.
"""
