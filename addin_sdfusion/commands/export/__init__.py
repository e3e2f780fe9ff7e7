"""Export: the design becomes a robot folder."""
