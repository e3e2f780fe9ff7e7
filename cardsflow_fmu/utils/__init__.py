"""Helpers independent of robots: archives, locks, interrupts, files, text tables."""
