"""Limits of files from outside: reading any of them takes less than 1 GB and 10 s, or is rejected.

What a file may be made of is limited next to its bytes wherever a few bytes become much memory.
"""

from __future__ import annotations

KIB, MIB = 2**10, 2**20

SETTINGS = 4 * MIB
"""Bytes of a TOML file: tomllib takes half a second a MiB."""
CODE = MIB
"""Bytes of a Python file whose classes are looked for: each may become 200 in memory."""
JSON = 16 * MIB
"""Bytes of JSON, of which each may become 20 in memory."""

SNAPSHOT = 192 * MIB
"""Bytes of a design as JSON; nearly all are meshes, packed."""
SNAPSHOT_VALUES = 2_000_000
SNAPSHOT_UNPACKED = 256 * MIB
"""Bytes of the meshes in it."""
DESIGN = 16 * MIB
"""Bytes of a design that is a program, and of a table of its joints or muscles."""
STEP = 1024 * MIB
"""Bytes of a STEP file, which a process of its own reads."""

XML = 16 * MIB
XML_ELEMENTS = 100_000
"""Elements of a robot's files together; a large robot has some thousand."""
MJCF_MEMORY = 1024 * MIB
"""Bytes that MuJoCo's compiler may take for an MJCF, in a process of its own."""
MJCF_SECONDS = 10.0
"""Processor time that it may take, in [s]."""
MUSCLES_WITHOUT_RANGE = 500_000
"""Places of links by which ranges of lengths are found that an MJCF does not give."""
MATRIX = 2**22
"""Numbers in a robot's mass matrix or Jacobian: 32 MiB, and there are several."""
DRIVEN_COORDINATES, DRIVEN_MUSCLES = 300, 2000
"""Largest robot that `check` and `init` analyse."""
BODIES = 500
"""Of a world, that can touch one another: all pairs of them are looked at."""
WRAPS = 1000
"""Wraps of one muscle, whose bends are found together."""
DESCRIPTION = 32 * MIB
DESCRIPTION_TAGS = 600_000
"""Opening and closing tags of an FMU's description: 100000 variables have as many."""
XML_ATTRIBUTES = 1_500_000

TRAJECTORY = 16 * MIB
"""Bytes of all of CASPR's .traj files of a robot."""

COLUMNS = 100_000
"""Columns of a table, and variables of an FMU with the elements of its arrays."""
VALUES = 2**25
"""Numbers in a table of results: 256 MiB, twice where two are compared."""
TABLE = 512 * MIB
"""Bytes of a table as text."""
LINE = 4 * MIB
"""Bytes of a line in a table."""
ARRAYS = 128 * MIB
"""Bytes of NumPy's arrays, unpacked."""
MOTION = 16 * MIB
MOTION_VALUES = 2**24
"""Numbers in a file whose motion is followed: 128 MiB."""
MOTION_ROWS = 1_000_000
MOTION_POSITIONS = 4_000_000
"""Rows of a motion that is followed, times its coordinates."""
RECORDING = 256 * MIB
RECORDS = 2_000_000
"""Messages of any kind in a recording."""
JOINT_STATES = 500_000
"""Messages with joint states in a recording: 10 us each."""

MESH = 32 * MIB
"""Bytes of a binary mesh: 670000 triangles as STL."""
MESH_TEXT = 12 * MIB
MESH_LINE = 4 * KIB
"""Bytes of a line in a mesh as text: a longer one is a polygon of hundreds of corners."""
MESH_REACH = 1e9
"""How far a corner may be from the origin, in the mesh's own unit."""
MESH_NUMBERS = 6_000_000
"""Corners and indices of all meshes placed in a glTF scene, numbers in a COLLADA scene."""
MESH_NODES = 5000
"""Nodes and parts placed in a scene of glTF or COLLADA."""
MESH_DEPTH = 50
"""Nodes below one another there."""

ARCHIVE = 256 * MIB
"""Bytes of a zip archive: an FMU, an .ssp, an experiment.zip."""
ARCHIVE_ENTRIES = 10_000
ARCHIVE_DIRECTORY = 4 * MIB
UNPACKED = 1024 * MIB
"""Bytes that an archive unpacks to, on disk."""
UNPACKED_IN_MEMORY = 64 * MIB
INNER_FMU = 128 * MIB
"""Bytes of an FMU in an .ssp whose experiment is looked for."""


def too_large(largest: int) -> str:
    """What is wrong with a file of more bytes."""
    return f"is larger than {f'{largest // MIB} MiB' if largest >= MIB else f'{largest} bytes'}"


def xml_fault(data: bytes, tags: int = 3 * XML_ELEMENTS) -> str | None:
    """What is too much in XML, before a parser sees it; None if nothing is.

    Args:
        data: The text.
        tags: So many opening and closing tags it may have.
    """
    if data.count(b"<") > tags:
        return f"holds more than {tags} tags"
    if data.count(b"=") > XML_ATTRIBUTES:
        return f"holds more than {XML_ATTRIBUTES} attributes"
    return None
