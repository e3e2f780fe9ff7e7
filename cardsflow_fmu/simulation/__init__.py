"""Building and running of experiments and systems."""
