"""Command line; each module contains one or several commands."""
