"""Muscles of a design: their points, the faces that they wrap over, task points and markers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from ..robot.model.muscle import CableKind, CableModel
from ..robot.model.pose import Vector3
from ..robot.model.robot import Axis
from .parts import Color

Role = Literal["via", "task", "marker"]

DEFAULT_COLOR = "#d62728"
F_MIN, F_MAX = 10.0, 80.0
"""Force limits of a muscle of which nothing is known, in [N]: those of the add-in before."""


@dataclass(frozen=True, slots=True)
class MuscleSnapshot:
    """A muscle, without its points, which name it.

    Attributes:
        name: Its name.
        color: What it is drawn in.
        f_min: Smallest force that a controller may command, in [N].
        f_max: Largest force, in [N]; infinite if unknown.
        model: How force, length and stiffness belong together.
        parameters: The model's numbers by name, in SI units.
    """

    name: str
    color: Color = DEFAULT_COLOR
    f_min: float = F_MIN
    f_max: float = F_MAX
    model: CableKind = "ideal"
    parameters: Mapping[str, float] = field(default_factory=dict)

    @property
    def cable_model(self) -> CableModel:
        """The model with its parameters, as the robot's muscle has it."""
        return CableModel(self.model, tuple(self.parameters.items()))


@dataclass(frozen=True, slots=True)
class PointUse:
    """What a construction point is.

    Attributes:
        role: `via`, `task` or `marker`.
        link: Name of the link it is fixed to, or `world`; that of its occurrence if empty.
        muscle: Of a via point: name of the muscle.
        number: Of a via point: its place along the muscle.
        name: Of a task point or marker: its name.
        axes: Of a task point: which coordinates count; the position's if empty.
        occurrence: Path of the occurrence that is meant where the component is in several places.
        made: Whether the add-in made the point, and so may delete it.
        original: The name that the user gave a point that the add-in did not make.
    """

    role: Role
    link: str = ""
    muscle: str = ""
    number: int = 0
    name: str = ""
    axes: tuple[Axis, ...] = ()
    occurrence: str = ""
    made: bool = False
    original: str = ""


@dataclass(frozen=True, slots=True)
class WrapUse:
    """A muscle that wraps over a surface.

    Attributes:
        muscle: Name of the muscle.
        after: Number of the via point before the surface.
        side: 1 or -1 for a chosen sense of turning about the axis, 0 for the shorter path.
        turns: Whole turns about it.
        inside: Whether it is led through the surface; then it has no side and no turns.
    """

    muscle: str
    after: int
    side: Literal[-1, 0, 1] = 0
    turns: int = 0
    inside: bool = False


@dataclass(frozen=True, slots=True)
class SurfaceUse:
    """What a face is.

    Attributes:
        name: Name of the wrap surface.
        link: Name of the link it is fixed to, or `world`; that of its occurrence if empty.
        muscles: Which muscles wrap over it.
        occurrence: Path of the occurrence that is meant where the component is in several places.
    """

    name: str
    link: str = ""
    muscles: tuple[WrapUse, ...] = ()
    occurrence: str = ""


@dataclass(frozen=True, slots=True)
class PointSnapshot:
    """A construction point in one place: a via point, task point or marker.

    Attributes:
        name: Its name.
        occurrence: Path of the occurrence that it belongs to.
        position: In [m].
        entity: What the CAD system's component and point are; the same for a point that is in
            several places because its component is.
        use: What it is; None if its name says it, as in designs of earlier add-ins:
            `VP_motor<number>_EXPORT_<link>_<number>`, `EE_<link>`, `VM_<link>`.
        problem: What the CAD system says is wrong with it; empty if nothing.
    """

    name: str
    occurrence: str
    position: Vector3
    entity: str = ""
    use: PointUse | None = None
    problem: str = ""


@dataclass(frozen=True, slots=True)
class SurfaceSnapshot:
    """A cylinder or sphere face that muscles wrap over, in one place.

    Attributes:
        occurrence: Path of the occurrence that it belongs to.
        shape: `sphere` or `cylinder`.
        radius: In [m].
        centre: Of the sphere, or of the cylinder's middle, in [m].
        axis: Of the cylinder, a unit vector; z for a sphere.
        length: Of the cylinder, in [m]; 0 for a sphere.
        entity: As for a point.
        use: What it is; None for a face that no muscle wraps over.
    """

    occurrence: str
    shape: Literal["sphere", "cylinder"]
    radius: float
    centre: Vector3
    axis: Vector3 = (0.0, 0.0, 1.0)
    length: float = 0.0
    entity: str = ""
    use: SurfaceUse | None = None
