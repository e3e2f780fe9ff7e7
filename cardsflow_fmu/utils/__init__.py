"""Utilities that do not depend on robots: archives, locks, interrupts, files and tables."""
