"""Files of all kinds that users specify, with random defects."""
