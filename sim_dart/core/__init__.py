"""Python side of the C core: its library, the compiled robot (blob), and frames."""
