"""Export command, which writes the robot folder of a design."""
