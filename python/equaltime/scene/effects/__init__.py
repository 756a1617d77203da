"""Effects: what a scene calls for, the reason for each, and the scene without some of them."""
