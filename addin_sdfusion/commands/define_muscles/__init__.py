"""Define muscles command, which creates muscles from points picked in the design."""
