"""Snapshot of a design as plain records: all data that an export needs from a CAD system.

SI units. Positions and directions are given in the design's root frame, at the
design's pose. An occurrence is named by its full path, such as `arm:1+hand:1`; the root component
has the empty path. `snapshot_file` writes and reads it;
`docs/reference/snapshot.md` describes the file.
"""

from dataclasses import dataclass, field
from typing import Literal

from ..robot.finding import Finding
from ..settings import ExportSettings
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

DesignIntent = Literal["part", "assembly", "hybrid", "unknown"]
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


@dataclass(frozen=True, slots=True)
class SourceSnapshot:
    """Source of a snapshot.

    Attributes:
        program: The CAD system or the library, such as `Fusion` or `build123d`.
        version: Version of the program.
        document: Name, file or address of the document.
    """

    program: str = ""
    version: str = ""
    document: str = ""


@dataclass(frozen=True, slots=True)
class DesignSnapshot:
    """All data that the export needs from a design.

    Attributes:
        name: Name of the design.
        settings: Settings of the export.
        occurrences: Every occurrence of every component except the root component.
        bodies: Every body of every occurrence.
        groups: Rigid groups.
        joints: Joints and as-built joints.
        points: Via points, task points and markers.
        surfaces: Faces that muscles wrap over.
        muscles: The muscles, in the order of the force vector.
        intent: Intended use of the design.
        findings: Problems found while reading the design.
        source: Program and document of the design.
        couplings: Motions that follow other motions.
    """

    name: str
    settings: ExportSettings = field(default_factory=ExportSettings)
    occurrences: tuple[OccurrenceSnapshot, ...] = ()
    bodies: tuple[BodySnapshot, ...] = ()
    groups: tuple[GroupSnapshot, ...] = ()
    joints: tuple[JointSnapshot, ...] = ()
    points: tuple[PointSnapshot, ...] = ()
    surfaces: tuple[SurfaceSnapshot, ...] = ()
    muscles: tuple[MuscleSnapshot, ...] = ()
    intent: DesignIntent = "unknown"
    findings: tuple[Finding, ...] = ()
    source: SourceSnapshot = field(default_factory=SourceSnapshot)
    couplings: tuple[CouplingSnapshot, ...] = ()
