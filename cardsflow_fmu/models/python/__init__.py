"""Controllers in Python, where C lacks something."""
