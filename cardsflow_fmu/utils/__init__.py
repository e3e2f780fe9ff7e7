"""Helpers independent of robots: archives, interrupts, files, text tables."""
