"""Experiments: their settings, readers and writers."""
