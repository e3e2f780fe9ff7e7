"""The controller's end of the hardware protocol."""
