"""Helpers that know nothing of robots: archives, interrupts, files, text tables."""
