"""Controller side of the hardware protocol."""
