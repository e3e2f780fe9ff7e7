"""Motions for the identification of robot parameters."""
