"""Distribution of a wrench over muscle forces: the bounded QP and other methods."""
