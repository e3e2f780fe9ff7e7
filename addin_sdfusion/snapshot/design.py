"""A whole design."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from ..robot.finding import Finding
from ..settings import ExportSettings
from .joints import CouplingSnapshot, JointSnapshot
from .muscles import MuscleSnapshot, PointSnapshot, SurfaceSnapshot
from .parts import BodySnapshot, GroupSnapshot, OccurrenceSnapshot

DesignIntent = Literal["part", "assembly", "hybrid", "unknown"]


@dataclass(frozen=True, slots=True)
class SourceSnapshot:
    """Where a snapshot comes from.

    Attributes:
        program: The CAD system or the library, such as `Fusion` or `build123d`.
        version: Its version.
        document: The design's document, file or address there.
    """

    program: str = ""
    version: str = ""
    document: str = ""


@dataclass(frozen=True, slots=True)
class DesignSnapshot:
    """All that the export needs of a design.

    Attributes:
        name: The design's name.
        settings: How to export it.
        occurrences: Every component in every place, but the root.
        bodies: Every body in every place.
        groups: Rigid groups.
        joints: Joints and as-built joints.
        points: Via points, task points and markers.
        surfaces: Faces that muscles wrap over.
        muscles: The muscles in their order, which is that of the forces.
        intent: What the design is made for.
        findings: What could not be read.
        source: Where it comes from.
        couplings: Motions that follow others.
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
