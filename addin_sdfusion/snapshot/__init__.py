"""Snapshot of a design as plain records: all data that an export needs from a CAD system.

SI units. Positions and directions are given in the design's root frame, at the
design's pose. An occurrence is named by its full path, such as `arm:1+hand:1`; the root component
has the empty path. `snapshot_file` writes and reads it;
`docs/reference/snapshot.md` describes the file.
"""

from .design import DesignIntent, DesignSnapshot, SourceSnapshot
from .joints import CouplingSnapshot, JointKind, JointSnapshot, MotionSnapshot
from .muscles import (
    COPY,
    DEFAULT_COLOR,
    F_MAX,
    F_MIN,
    HIDDEN_KEY,
    KEPT,
    Level,
    MuscleSnapshot,
    PointSnapshot,
    PointUse,
    Role,
    SurfaceSnapshot,
    SurfaceUse,
    WrapUse,
)
from .parts import (
    COLOR,
    LINK_PREFIX,
    ROOT,
    BodySnapshot,
    Color,
    GroupSnapshot,
    MassSnapshot,
    MeshSnapshot,
    OccurrenceSnapshot,
    bare_name,
)

__all__ = [
    "COLOR",
    "COPY",
    "DEFAULT_COLOR",
    "F_MAX",
    "F_MIN",
    "HIDDEN_KEY",
    "KEPT",
    "LINK_PREFIX",
    "ROOT",
    "BodySnapshot",
    "Color",
    "CouplingSnapshot",
    "DesignIntent",
    "DesignSnapshot",
    "GroupSnapshot",
    "JointKind",
    "JointSnapshot",
    "Level",
    "MassSnapshot",
    "MeshSnapshot",
    "MotionSnapshot",
    "MuscleSnapshot",
    "OccurrenceSnapshot",
    "PointSnapshot",
    "PointUse",
    "Role",
    "SourceSnapshot",
    "SurfaceSnapshot",
    "SurfaceUse",
    "WrapUse",
    "bare_name",
]
