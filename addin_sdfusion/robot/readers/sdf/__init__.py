"""Reader of SDF."""
