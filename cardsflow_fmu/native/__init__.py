"""Native models: their files, library and loop."""
