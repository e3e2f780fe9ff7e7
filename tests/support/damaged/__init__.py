"""Files with defects made at random, of every kind that a user can name."""
