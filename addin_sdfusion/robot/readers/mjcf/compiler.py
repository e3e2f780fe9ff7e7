"""Flags of MJCF's `<compiler>`, and what is read by them: angles, orientations, places."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ...formats.reading.xml import ZERO, Node
from ...model.pose import Pose, Vector3
from ...model.rotations import Matrix3, axis_rotation, cross, dot, multiply, normalized, rotation
from ...model.transform import IDENTITY, Transform
from .document import Document

AXES: dict[str, Vector3] = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
ORIENTATIONS = ("quat", "axisangle", "xyaxes", "zaxis", "euler")
MOST_NUMBERS = 100


@dataclass(frozen=True)
class Compiler:
    """The flags that change what a file means.

    Attributes:
        degree: What an angle of 1 is, in [rad].
        sequence: The axes of Euler angles, in their order; capitals turn about fixed axes.
        autolimits: Whether a range makes a limit.
        from_geoms: Whether masses come from geoms: `true`, `false`, or `auto`, if not given.
        groups: First and last group of geoms that have mass.
        least_mass, least_inertia: What bodies have at least, in [kg] and [kg·m²].
        balance: Whether impossible inertias become those of a ball.
        total_mass: What the masses are scaled to, in [kg]; None for not at all.
        mesh_folder: Where meshes are, from the file's folder.
        strips: Whether only the names of mesh files count.
    """

    degree: float = math.pi / 180.0
    sequence: str = "xyz"
    autolimits: bool = True
    from_geoms: str = "auto"
    groups: tuple[float, float] = (0.0, 5.0)
    least_mass: float = 0.0
    least_inertia: float = 0.0
    balance: bool = False
    total_mass: float | None = None
    mesh_folder: str = ""
    strips: bool = False

    def angle(self, value: float) -> float:
        """An angle of the file, in [rad]."""
        return self.degree * value

    def limited(self, node: Node, word: str, range_: str) -> bool:
        """Whether a range counts: as the file says, or because it is given."""
        given = node.attribute(word, "auto")
        return given == "true" or (given == "auto" and self.autolimits and node.has(range_))

    def orientation(self, node: Node) -> Matrix3:
        """The rotation that an element gives in one of five ways."""
        given = [name for name in ORIENTATIONS if node.has(name)]
        if not given:
            return IDENTITY.R
        if given[0] == "quat":
            return of_quaternion(node.numbers_attribute("quat", 4))
        if given[0] == "axisangle":
            x, y, z, angle = node.numbers_attribute("axisangle", 4)
            return axis_rotation(normalized((x, y, z)), self.angle(angle))
        if given[0] == "xyaxes":
            return _of_axes(node.numbers_attribute("xyaxes", 6))
        if given[0] == "zaxis":
            return to_z(node.vector_attribute("zaxis"))
        return self.of_euler(node.vector_attribute("euler"))

    def place(self, node: Node) -> Transform:
        """The position and rotation of an element."""
        p = node.vector_attribute("pos") if node.has("pos") else ZERO
        return Transform(self.orientation(node), p)

    def pose(self, node: Node, T: Transform) -> Pose:
        """The place of an element as the description has it: roll, pitch, yaw as they are given."""
        if node.has("euler") and self.sequence == "XYZ" and self.place(node) == T:
            x, y, z = map(self.angle, node.vector_attribute("euler"))
            return Pose(T.p, (x, y, z))
        return T.pose()

    def of_euler(self, angles: Vector3) -> Matrix3:
        """The rotation of Euler angles of the file."""
        R = IDENTITY.R
        for letter, angle in zip(self.sequence, angles, strict=True):
            axis = AXES[letter.lower()]
            about = [self.angle(angle) * w for w in axis]
            turn = rotation((about[0], about[1], about[2]))
            R = multiply(R, turn) if letter.islower() else multiply(turn, R)
        return R


def read_compiler(document: Document) -> Compiler:
    """The flags of all `<compiler>` elements, later ones first."""
    values: dict[str, Node] = {}
    for node in document.sections("compiler"):
        values |= {str(name): node for name in node.element.attrib}
    default = Compiler()

    def word(name: str, otherwise: str) -> str:
        return values[name].attribute(name) if name in values else otherwise

    def number(name: str) -> float:
        return values[name].number_attribute(name) if name in values else 0.0

    def pair(name: str) -> tuple[float, float]:
        low, high = values[name].numbers_attribute(name, 2)
        return low, high

    sequence = word("eulerseq", default.sequence)
    if len(sequence) != 3 or any(letter.lower() not in AXES for letter in sequence):
        values["eulerseq"].error("bad-word", f"eulerseq {sequence[:20]!r} is not three axes")
        sequence = default.sequence
    if word("coordinate", "local") != "local":
        values["coordinate"].error("unsupported-flag", "global coordinates are of old MuJoCo only")
    total = number("settotalmass")
    return Compiler(
        1.0 if word("angle", "degree") == "radian" else default.degree,
        sequence,
        word("autolimits", "true") != "false",
        word("inertiafromgeom", "auto"),
        pair("inertiagrouprange") if "inertiagrouprange" in values else default.groups,
        number("boundmass"),
        number("boundinertia"),
        word("balanceinertia", "false") == "true",
        total if total > 0.0 else None,
        word("meshdir", word("assetdir", "")),
        word("strippath", "false") == "true",
    )


def numbers(node: Node, name: str, *, infinite: bool = False) -> tuple[float, ...]:
    """As many numbers as an attribute has; none where it is not given."""
    if not node.has(name):
        return ()
    size = min(len(node.attribute(name).split()), MOST_NUMBERS)
    return node.numbers_attribute(name, size, infinite=infinite)


def of_quaternion(q: tuple[float, ...]) -> Matrix3:
    """The rotation of a quaternion w, x, y, z of any length."""
    norm = math.hypot(*q)
    if not 0.0 < norm < math.inf:
        return IDENTITY.R
    w, x, y, z = (entry / norm for entry in q)
    return (
        (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)),
        (2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)),
        (2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)),
    )


def to_z(axis: Vector3) -> Matrix3:
    """The least rotation that turns z to an axis."""
    z = normalized(axis)
    about = cross(AXES["z"], z)
    sine, cosine = math.hypot(*about), z[2]
    if sine < 1e-12:
        turned = rotation((math.pi, 0.0, 0.0))
        return IDENTITY.R if cosine >= 0.0 else turned
    return axis_rotation(normalized(about), math.atan2(sine, cosine))


def _of_axes(numbers: tuple[float, ...]) -> Matrix3:
    """The rotation with these x and y axes, y made orthogonal."""
    x = normalized((numbers[0], numbers[1], numbers[2]))
    y = (numbers[3], numbers[4], numbers[5])
    share = dot(x, y)
    y = normalized((y[0] - share * x[0], y[1] - share * x[1], y[2] - share * x[2]))
    z = cross(x, y)
    return (x[0], y[0], z[0]), (x[1], y[1], z[1]), (x[2], y[2], z[2])
