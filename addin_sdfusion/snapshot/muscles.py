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
"""Default force limits of a muscle, in [N]; earlier versions of the add-in used the same values."""


COPY = "it is a copy"
"""Beginning of the reason why a copied point is lost."""

KEPT = "kept:"
"""Prefix of the entities of points that are stored in a design. The position of a lost one is in
the frame of its part."""

HIDDEN_KEY = "hidden:"
"""Prefix of the entities of points whose component has no occurrence. They are lost; their position
is in the frame of their part."""


@dataclass(frozen=True, slots=True)
class Level:
    """One occurrence on the way from the root component of a design to a point.

    Attributes:
        component: Persistent identifier of its component.
        instance: Number of the occurrence in its name, such as 2 in `arm:2`.
        token: Token by which the CAD system finds the occurrence again.
    """

    component: str
    instance: int
    token: str = ""


@dataclass(frozen=True, slots=True)
class MuscleSnapshot:
    """A muscle without its via points; each via point refers to its muscle by name.

    Attributes:
        name: Name of the muscle.
        color: Colour of the muscle in drawings.
        f_min: Minimum force that a controller may command, in [N].
        f_max: Maximum force, in [N]; infinite if unknown.
        model: Muscle law, which relates force, length and stiffness.
        parameters: Parameters of the muscle law by name, in SI units.
    """

    name: str
    color: Color = DEFAULT_COLOR
    f_min: float = F_MIN
    f_max: float = F_MAX
    model: CableKind = "ideal"
    parameters: Mapping[str, float] = field(default_factory=dict)

    @property
    def cable_model(self) -> CableModel:
        """The muscle law with its parameters, as used by the robot model."""
        return CableModel(self.model, tuple(self.parameters.items()))


@dataclass(frozen=True, slots=True)
class PointUse:
    """Use of a construction point.

    Attributes:
        role: `via`, `task` or `marker`.
        link: Name of the link that the point is fixed to, or `world`; if empty, the link of its
            occurrence.
        muscle: Name of the muscle, for a via point.
        number: Position in the sequence of points along the muscle, for a via point.
        name: Name of the point, for a task point or marker.
        axes: Task coordinates, for a task point; if empty, the three coordinates of the position.
        occurrence: Path of the occurrence that the point belongs to, if its component has several.
        made: Whether the add-in created the point and may therefore delete it.
        original: Name that the user gave to a point that the add-in did not create.
        place: The occurrence by persistent identifiers, in the attributes of a design only;
            `occurrence` is used if it is empty.
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
    place: tuple[Level, ...] = ()


@dataclass(frozen=True, slots=True)
class WrapUse:
    """A muscle that wraps over a surface.

    Attributes:
        muscle: Name of the muscle.
        after: Number of the via point before the surface.
        side: 1 or -1 for a sense of rotation about the axis, 0 for the shorter path.
        turns: Number of full turns about the axis.
        inside: Whether the muscle passes through the inside of the surface; `side` and `turns`
            are then not used.
    """

    muscle: str
    after: int
    side: Literal[-1, 0, 1] = 0
    turns: int = 0
    inside: bool = False


@dataclass(frozen=True, slots=True)
class SurfaceUse:
    """Use of a face as a wrap surface.

    Attributes:
        name: Name of the wrap surface.
        link: Name of the link that the face is fixed to, or `world`; if empty, the link of its
            occurrence.
        muscles: The muscles that wrap over the face.
        occurrence: Path of the occurrence that the face belongs to, if its component has several.
        place: The occurrence by persistent identifiers, in the attributes of a design only;
            `occurrence` is used if it is empty.
    """

    name: str
    link: str = ""
    muscles: tuple[WrapUse, ...] = ()
    occurrence: str = ""
    place: tuple[Level, ...] = ()


@dataclass(frozen=True, slots=True)
class PointSnapshot:
    """A construction point in one occurrence: a via point, task point or marker.

    Attributes:
        name: Name of the construction point.
        occurrence: Path of the occurrence that it belongs to.
        position: In [m].
        entity: Identifier of the component and the point in the CAD system; all occurrences of a
            component have the same identifiers.
        use: Use of the point; None if the name specifies it, as in designs of earlier add-ins:
            `VP_motor<number>_EXPORT_<link>_<number>`, `EE_<link>`, `VM_<link>`.
        problem: Error that the CAD system reports for the point; empty if it reports no error.
        lost: Reason why the occurrence of the point is unknown; empty if it is known. Its position
            is then in the frame of the lost occurrence.
    """

    name: str
    occurrence: str
    position: Vector3
    entity: str = ""
    use: PointUse | None = None
    problem: str = ""
    lost: str = ""


@dataclass(frozen=True, slots=True)
class SurfaceSnapshot:
    """A cylindrical or spherical face that muscles wrap over, in one occurrence.

    Attributes:
        occurrence: Path of the occurrence that it belongs to.
        shape: `sphere` or `cylinder`.
        radius: In [m].
        centre: Centre of the sphere or cylinder, in [m].
        axis: Axis of the cylinder, a unit vector; z for a sphere.
        length: Length of the cylinder, in [m]; 0 for a sphere.
        entity: Identifier of the component and the face in the CAD system.
        use: Use of the face; None for a face that no muscle wraps over.
        lost: Reason why the occurrence of the face is unknown; empty if it is known.
    """

    occurrence: str
    shape: Literal["sphere", "cylinder"]
    radius: float
    centre: Vector3
    axis: Vector3 = (0.0, 0.0, 1.0)
    length: float = 0.0
    entity: str = ""
    use: SurfaceUse | None = None
    lost: str = ""
