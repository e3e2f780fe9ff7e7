"""Version of the package; the build also reads this file."""

__version__ = "1.0.0"
