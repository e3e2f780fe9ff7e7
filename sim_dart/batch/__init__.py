"""Many instances of a robot that the C core steps together."""
