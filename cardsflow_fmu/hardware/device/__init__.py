"""Device side of the hardware protocol."""
