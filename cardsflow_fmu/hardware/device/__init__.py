"""The device's end of the hardware protocol."""
