"""Shared parts of the readers. They need lxml and do not run inside Fusion."""
