"""Export of the design to a robot folder."""
