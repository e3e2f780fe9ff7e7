"""Define muscles: points picked in the design become muscles."""
