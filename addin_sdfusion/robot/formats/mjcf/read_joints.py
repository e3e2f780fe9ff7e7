"""Reader of MJCF joints; the joints of one body become the motions of one joint."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from ...finding import Subject
from ...model.function import ITSELF, constant, linear
from ...model.joint import Coordinate, Joint, Motion
from ...model.pose import AXES, Vector3
from ...model.rotations import normalized, subtract
from ...model.transform import IDENTITY, Transform, motion_transform
from ...transforms.joint_chains import Names
from ..reading.xml import ZERO, Node
from .compiled import Compiled, Row, transform, vector
from .document import Document

ANGLES = {"ball": 3, "free": 6}
"""Number of coordinates of joints that use a quaternion in MuJoCo."""


def read_joints(document: Document, compiled: Compiled) -> list[Joint]:
    """Return the parent joint of each body except the world; fixed if the body has no joints."""
    names = Names()
    return [
        _joint(document, compiled, body, number, names)
        for number, body in enumerate(compiled.bodies)
        if number
    ]


def _joint(document: Document, compiled: Compiled, body: Row, number: int, names: Names) -> Joint:
    rows = [row for row in compiled.joints if row["bodyid"] == number]
    motions: list[Motion] = []
    coordinates: list[Coordinate] = []
    at_start, first, current = Transform(IDENTITY.R, ZERO), IDENTITY, None
    for k, row in enumerate(rows):
        place = vector(row["pos"])
        if row["type"] in ("slide", "free"):
            place = current if current is not None else _next_place(rows[k + 1 :])
        if current is None:
            at_start = Transform(IDENTITY.R, place)
        elif place != current:
            motions += _shift(subtract(place, current))
        current = place
        joint_motions, joint_coordinates = _motions(document, compiled, row, len(coordinates))
        if not motions and len(joint_motions) == 1 and joint_motions[0].function != ITSELF:
            (moved,) = joint_motions
            first = motion_transform(moved.kind, moved.axis, moved.displacement(0.0))
            joint_motions = [replace(moved, function=ITSELF)]
        motions += joint_motions
        coordinates += joint_coordinates
    name = coordinates[0].name if len(coordinates) == 1 else f"{body['name']}_joint"
    return Joint(
        names.unique(name),
        compiled.bodies[body["parentid"]]["name"],
        body["name"],
        tuple(motions),
        tuple(coordinates),
        transform(body).compose(at_start).compose(first).pose(),
        Transform(IDENTITY.R, current or ZERO).pose(),
    )


def _motions(
    document: Document, compiled: Compiled, row: Row, start: int
) -> tuple[list[Motion], list[Coordinate]]:
    """Return the motions and coordinates of a MuJoCo joint; coordinates count from `start`."""
    node = document.node_at(row["line"])
    if row["type"] in ANGLES:
        return _quaternion_joint(compiled, row, node, start)
    node = node.with_subject(Subject("coordinate", row["name"]))
    coordinate = _coordinate(compiled, row, node)
    ref = coordinate.initial
    function = linear(1.0, -ref) if ref else ITSELF
    axis = vector(row["axis"])
    if row["type"] == "slide":
        return [Motion("translation", axis, start, function)], [coordinate]
    return [Motion("rotation", axis, start, function)], [coordinate]


def _coordinate(compiled: Compiled, row: Row, node: Node) -> Coordinate:
    dof = compiled.dofs[row["dofadr"]]
    _note_polynomial(node, "stiffness", row["stiffness"], row["stiffnesspoly"])
    _note_polynomial(node, "damping", dof["damping"], dof["dampingpoly"])
    if row["springyield"]:
        node.warning("plasticity-left-out", "its spring is plastic in MuJoCo; here it is elastic")
    lower, upper = row["range"] if row["limited"] else (-math.inf, math.inf)
    tau_min, tau_max = row["actfrcrange"] if row["actfrclimited"] else (-math.inf, math.inf)
    return Coordinate(
        row["name"],
        lower,
        upper,
        compiled.qpos0[row["qposadr"]],
        dof["damping"],
        "m" if row["type"] == "slide" else "rad",
        stiffness=row["stiffness"],
        rest=compiled.qpos_spring[row["qposadr"]],
        friction=dof["frictionloss"],
        tau_min=tau_min,
        tau_max=tau_max,
        armature=dof["armature"],
    )


def _note_polynomial(node: Node, label: str, first: float, others: Sequence[float]) -> None:
    if any(others):
        problem = f"its {label} is a polynomial; only the first coefficient {first:g} is used"
        node.warning("polynomial-left-out", problem)


def _next_place(following: Sequence[Row]) -> Vector3:
    """Return the position of the first hinge after a slide, whose own position has no effect."""
    turning = (vector(row["pos"]) for row in following if row["type"] in ("hinge", "ball"))
    return next(turning, ZERO)


def _shift(by: Vector3) -> list[Motion]:
    """Return a constant translation, between hinges at different positions."""
    length = math.hypot(*by)
    return [Motion("translation", normalized(by), 0, constant(length))] if length else []


def _quaternion_joint(
    compiled: Compiled, row: Row, node: Node, start: int
) -> tuple[list[Motion], list[Coordinate]]:
    """Return three angles for a ball joint; for a free joint also three translations before."""
    name, count = row["name"], ANGLES[row["type"]]
    words = ("x", "y", "z", "alpha", "beta", "gamma")[-count:]
    motions, coordinates = [], []
    for k, word in enumerate(words):
        dof = compiled.dofs[row["dofadr"] + k]
        kind = "rotation" if k >= count - 3 else "translation"
        motion = Motion(kind, AXES[k % 3], start + k)  # type: ignore[arg-type]
        coordinate = f"{name}_{word}"
        node.with_subject(Subject("coordinate", coordinate))
        motions.append(motion)
        coordinates.append(
            Coordinate(
                coordinate,
                unit=motion.unit,
                damping=dof["damping"],
                friction=dof["frictionloss"],
                armature=dof["armature"],
            )
        )
    about = node.with_subject(Subject("joint", name))
    about.warning(
        "angles-for-quaternion",
        f"a {row['type']} joint rotates by Rx(alpha) Ry(beta) Rz(gamma) here, relative to its "
        "initial pose",
    )
    _note_polynomial(about, "damping", dof["damping"], dof["dampingpoly"])
    if row["limited"] or row["stiffness"]:
        about.warning("ball-range", "its range and spring are omitted")
    if any(c.armature or c.damping or c.friction for c in coordinates):
        about.warning("ball-resistance", "armature, damping and friction act on the angles here")
    return motions, coordinates
