"""Limits for untrusted files: reading a file uses less than 1 GB and 10 s, or it is rejected.

If a few bytes can expand to much memory, the number of elements is limited as well.
"""

from __future__ import annotations

KIB, MIB = 2**10, 2**20

SETTINGS = 4 * MIB
"""Bytes of a TOML file; tomllib requires half a second per MiB."""
CODE = MIB
"""Bytes of a Python file that is parsed for its classes; each byte may require 200 in memory."""
JSON = 16 * MIB
"""Bytes of a JSON file; each byte may require 20 in memory."""

SNAPSHOT = 192 * MIB
"""Bytes of a design as JSON, mostly compressed meshes."""
SNAPSHOT_VALUES = 2_000_000
SNAPSHOT_UNPACKED = 256 * MIB
"""Bytes of the uncompressed meshes in a design."""
DESIGN = 16 * MIB
"""Bytes of a design that is a Python program, and of a table of joints or muscles."""
STEP = 1024 * MIB
"""Bytes of a STEP file, which a separate process reads."""

XML = 16 * MIB
XML_ELEMENTS = 100_000
"""Elements in all files of a robot; a large robot has a few thousand."""
MJCF_MEMORY = 1024 * MIB
"""Bytes of memory for MuJoCo's compiler, which runs in a separate process."""
MJCF_SECONDS = 10.0
"""Processor time for MuJoCo's compiler, in [s]."""
MUSCLES_WITHOUT_RANGE = 500_000
"""Link poses that are evaluated to determine length ranges missing in an MJCF."""
MATRIX = 2**22
"""Numbers in a robot's mass matrix or Jacobian: 32 MiB for each of several matrices."""
DRIVEN_COORDINATES, DRIVEN_MUSCLES = 300, 2000
"""Coordinates and muscles of the largest robot that `check` and `init` analyse."""
BODIES = 500
"""Bodies of a world that can collide; all pairs of them are checked."""
WRAPS = 1000
"""Wraps of one muscle, which are solved simultaneously."""
DESCRIPTION = 32 * MIB
DESCRIPTION_TAGS = 600_000
"""Opening and closing tags of a model description; sufficient for 100000 variables."""
XML_ATTRIBUTES = 1_500_000

TRAJECTORY = 16 * MIB
"""Bytes of all CASPR .traj files of a robot."""

COLUMNS = 100_000
"""Columns of a table, and variables of an FMU including array elements."""
VALUES = 2**25
"""Numbers in a table of results: 256 MiB, or twice that for a comparison of two tables."""
ROWS = 12_000_000
"""Rows of a table of results; a run has at most 10 million steps."""
TABLE = 512 * MIB
"""Bytes of a table as text."""
LINE = 4 * MIB
"""Bytes of a line in a table."""
ARRAYS = 128 * MIB
"""Bytes of uncompressed NumPy arrays."""
MOTION = 16 * MIB
MOTION_VALUES = 2**24
"""Numbers in a file with a recorded motion: 128 MiB."""
MOTION_ROWS = 300_000
MOTION_POSITIONS = 4_000_000
"""Number of rows of a recorded motion times the number of coordinates."""
RECORDING = 256 * MIB
RECORDS = 2_000_000
"""Messages in a recording."""
JOINT_STATES = 300_000
"""Messages with joint states in a recording; reading one requires 10 us."""

MESH = 32 * MIB
"""Bytes of a binary mesh; sufficient for 670000 STL triangles."""
MESH_TEXT = 12 * MIB
MESH_LINE = 4 * KIB
"""Bytes of a line in a text mesh; a longer line is a polygon with hundreds of vertices."""
MESH_REACH = 1e9
"""Distance of a vertex from the origin, in the unit of the mesh."""
MESH_NUMBERS = 6_000_000
"""Vertices and indices of all mesh instances in a glTF scene, or numbers in a COLLADA scene."""
MESH_NODES = 5000
"""Nodes and part instances in a glTF or COLLADA scene, and parts of an STL or OBJ file."""
MESH_DEPTH = 50
"""Nesting depth of nodes in a glTF or COLLADA scene."""

ARCHIVE = 256 * MIB
"""Bytes of a zip archive, such as an FMU, an .ssp or an experiment.zip."""
ARCHIVE_ENTRIES = 10_000
ARCHIVE_DIRECTORY = 4 * MIB
UNPACKED = 1024 * MIB
"""Bytes of an unpacked archive on disk."""
UNPACKED_IN_MEMORY = 64 * MIB
INNER_FMU = 128 * MIB
"""Bytes of an FMU in an .ssp that is searched for its experiment."""


def too_large(largest: int) -> str:
    """Return the error text for a file with more than `largest` bytes."""
    return f"is larger than {f'{largest // MIB} MiB' if largest >= MIB else f'{largest} bytes'}"


def xml_fault(data: bytes, tags: int = 3 * XML_ELEMENTS) -> str | None:
    """Return the reason why XML is too large to parse, or None."""
    if data.count(b"<") > tags:
        return f"contains more than {tags} tags"
    if data.count(b"=") > XML_ATTRIBUTES:
        return f"contains more than {XML_ATTRIBUTES} attributes"
    return None
