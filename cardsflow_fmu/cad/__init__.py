"""Import of CAD designs as robots: snapshots, build123d assemblies and STEP files.

Each design is converted to a `DesignSnapshot`, which the exporter of the Fusion add-in writes.
"""

from .design import Design
from .import_cad import Imported, import_cad, read_design
from .step_design import Tables

__all__ = ["Design", "Imported", "Tables", "import_cad", "read_design"]
