"""Links of a design and their mass properties."""
