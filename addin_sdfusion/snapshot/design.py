"""Snapshot of a complete design."""

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
