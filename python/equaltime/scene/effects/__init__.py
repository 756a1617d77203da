"""Effects that a scene uses, the elements that use them, and the scene without some of them."""
