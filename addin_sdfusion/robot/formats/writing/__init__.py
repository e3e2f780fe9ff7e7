"""Shared parts of the writers. They need only the standard library."""
