"""Designs of CAD systems as robots: snapshots, build123d's assemblies, STEP files.

Each becomes a `DesignSnapshot`, from which the Fusion add-in's own export continues.
"""

from .design import Design
from .import_cad import import_cad, read_design
from .step_design import Tables

__all__ = ["Design", "Tables", "import_cad", "read_design"]
