"""How long a live picture takes from its capture to the screen."""
