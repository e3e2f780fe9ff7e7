"""Files of a robot folder, and their atomic replacement."""
