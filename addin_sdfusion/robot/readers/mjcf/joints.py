"""Joints of MJCF: those of one body are the motions of one joint."""

from __future__ import annotations

import math
from dataclasses import replace

from ...finding import Subject
from ...formats.reading.xml import ZERO, Node
from ...model.function import ITSELF, constant, linear
from ...model.joint import Coordinate, Joint, Motion
from ...model.pose import Pose, Vector3
from ...model.rotations import axis_rotation, normalized, subtract
from ...model.transform import IDENTITY, Transform
from ...transforms.joint_chains import Names
from .bodies import Body, Part
from .compiler import Compiler, numbers

X: Vector3 = (1.0, 0.0, 0.0)
Y: Vector3 = (0.0, 1.0, 0.0)
Z: Vector3 = (0.0, 0.0, 1.0)
TYPES = ("hinge", "slide", "ball", "free")


class JointReader:
    """Reads joints, and gives names to those without."""

    def __init__(self, compiler: Compiler, bodies: list[Body]) -> None:
        self._compiler = compiler
        named = [part.node.attribute("name", "") for body in bodies for part in body.joints]
        self._names = Names(name for name in named if name)
        self._joints = Names()
        self._count = 0

    def read(self, body: Body) -> Joint:
        """The joint that carries a body; a fixed one where it has none."""
        free = [part for part in body.joints if _type(part.node) == "free"]
        motions: list[Motion] = []
        coordinates: list[Coordinate] = []
        T_body_joint = Transform(IDENTITY.R, ZERO)
        first = Transform(IDENTITY.R, ZERO)
        here: Vector3 | None = None
        for part in body.joints:
            pos = part.T.apply(_vector(part.node, "pos", ZERO))
            if _type(part.node) == "slide" or part in free:
                pos = here if here is not None else _next_place(body, part)
            if here is None:
                T_body_joint = Transform(IDENTITY.R, pos)
            elif pos != here:
                motions += _shift(subtract(pos, here))
            here = pos
            made, of = self._motions(part, len(coordinates))
            if not motions and len(made) == 1 and made[0].function != ITSELF:
                first, made = _turned_back(made[0])
            motions += made
            coordinates += of
        T_last = Transform(IDENTITY.R, here or ZERO)
        name = coordinates[0].name if len(coordinates) == 1 else f"{body.name}_joint"
        T = body.T.compose(T_body_joint).compose(first)
        turned = self._compiler.pose(body.node, body.T).rpy
        pose = Pose(T.p, turned) if first == IDENTITY else T.pose()
        return Joint(
            self._joints.give(name),
            body.parent,
            body.name,
            tuple(motions),
            tuple(coordinates),
            pose,
            T_last.pose(),
        )

    def _motions(self, part: Part, start: int) -> tuple[list[Motion], list[Coordinate]]:
        """The motions of one joint element; its coordinates are numbered from a start."""
        node, type_ = part.node, _type(part.node)
        name = self._name(node)
        if type_ in ("ball", "free"):
            return _several(node, name, type_, start)
        node = node.about(Subject("coordinate", name))
        axis = normalized(part.T.rotate(_vector(node, "axis", Z)))
        coordinate = self._coordinate(node, name, type_)
        ref = coordinate.initial
        function = linear(1.0, -ref) if ref else ITSELF
        kind = "translation" if type_ == "slide" else "rotation"
        return [Motion(kind, axis, start, function)], [coordinate]  # type: ignore[arg-type]

    def _coordinate(self, node: Node, name: str, type_: str) -> Coordinate:
        scale = 1.0 if type_ == "slide" else self._compiler.degree
        lower, upper = -math.inf, math.inf
        if self._compiler.limited(node, "limited", "range") and node.has("range"):
            low, high = node.numbers_attribute("range", 2)
            lower, upper = scale * low, scale * high
        torque = math.inf
        tau_min = -math.inf
        if self._compiler.limited(node, "actuatorfrclimited", "actuatorfrcrange"):
            tau_min, torque = node.numbers_attribute("actuatorfrcrange", 2)
        return Coordinate(
            name,
            lower,
            upper,
            scale * node.number_attribute("ref", 0.0),
            _first(node, "damping"),
            "m" if type_ == "slide" else "rad",
            stiffness=_first(node, "stiffness"),
            rest=scale * node.number_attribute("springref", 0.0),
            friction=node.number_attribute("frictionloss", 0.0),
            tau_min=tau_min,
            tau_max=torque,
            armature=node.number_attribute("armature", 0.0),
        )

    def _name(self, node: Node) -> str:
        given = node.attribute("name", "")
        if given:
            return given
        self._count += 1
        return self._names.give(f"joint_{self._count}")


def _first(node: Node, name: str) -> float:
    """A coefficient; those of higher powers are noted as left out."""
    values = numbers(node, name)
    if any(values[1:]):
        problem = f"its {name} is a polynomial; only its first coefficient {values[0]:g} is kept"
        node.warning("polynomial-left-out", problem)
    return values[0] if values else 0.0


def _type(node: Node) -> str:
    if node.tag == "freejoint":
        return "free"
    type_ = node.attribute("type", "hinge")
    if type_ not in TYPES:
        node.error("unsupported-joint", f"type {type_[:20]!r} is none of {', '.join(TYPES)}")
        return "hinge"
    return type_


def _vector(node: Node, name: str, default: Vector3) -> Vector3:
    return node.vector_attribute(name) if node.has(name) else default


def _next_place(body: Body, part: Part) -> Vector3:
    """The place of the first hinge behind a slide, whose own place counts for nothing."""
    behind = body.joints[body.joints.index(part) + 1 :]
    for other in behind:
        if _type(other.node) in ("hinge", "ball"):
            return other.T.apply(_vector(other.node, "pos", ZERO))
    return ZERO


def _shift(by: Vector3) -> list[Motion]:
    """A translation that stands still, between hinges at different places."""
    length = math.hypot(*by)
    return [Motion("translation", normalized(by), 0, constant(length))] if length else []


def _turned_back(motion: Motion) -> tuple[Transform, list[Motion]]:
    """A first motion that counts from another zero, as one that does not, and a place."""
    way = motion.way(0.0)
    if motion.kind == "rotation":
        T = Transform(axis_rotation(motion.axis, way), ZERO)
    else:
        x, y, z = (way * w for w in motion.axis)
        T = Transform(IDENTITY.R, (x, y, z))
    return T, [replace(motion, function=ITSELF)]


def _several(
    node: Node, name: str, type_: str, start: int
) -> tuple[list[Motion], list[Coordinate]]:
    """A ball turns by three angles, a free joint moves along three axes before."""
    kinds = "rrr" if type_ == "ball" else "tttrrr"
    words = ("x", "y", "z", "alpha", "beta", "gamma")[-len(kinds) :]
    axes = (X, Y, Z) * 2
    motions, coordinates = [], []
    for k, (kind, axis, word) in enumerate(zip(kinds, axes, words, strict=False)):
        motion = Motion("rotation" if kind == "r" else "translation", axis, start + k)
        each = f"{name}_{word}"
        node.about(Subject("coordinate", each))
        motions.append(motion)
        coordinates.append(
            Coordinate(
                each,
                unit=motion.unit,
                damping=_first(node, "damping"),
                friction=node.number_attribute("frictionloss", 0.0),
                armature=node.number_attribute("armature", 0.0),
            )
        )
    about = node.about(Subject("joint", name))
    about.warning(
        "angles-for-quaternion",
        f"a {type_} joint turns by Rx(alpha) Ry(beta) Rz(gamma) here, from where it is at first",
    )
    if type_ == "ball" and (node.has("range") or _first(node, "stiffness")):
        about.warning("ball-range", "its range and spring are left out")
    if any(c.armature or c.damping or c.friction for c in coordinates):
        about.warning("ball-resistance", "armature, damping and friction act on its angles here")
    return motions, coordinates
