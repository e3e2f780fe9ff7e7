"""Reader of the joints of URDF files."""

from __future__ import annotations

import math
from collections.abc import Container

from ...finding import Subject
from ...model.function import linear
from ...model.joint import Coordinate, Joint, Motion, MotionKind, Term
from ...model.pose import AXES, Vector3, X
from ...model.rotations import cross, normalized
from ..reading.xml import Node, short_repr
from .capabilities import NO_LIMIT
from .read_links import read_origin

SINGLE_AXIS_TYPES: dict[str, MotionKind] = {
    "revolute": "rotation",
    "continuous": "rotation",
    "prismatic": "translation",
}
TYPES = (*SINGLE_AXIS_TYPES, "fixed", "floating", "planar")
FREE = ("x", "y", "z", "alpha", "beta", "gamma")
LIMITED = ("revolute", "prismatic")


def read_joint(node: Node, motors: Container[str]) -> Joint:
    """Return a joint.

    A single coordinate has the name of the joint. The coordinates of a floating or planar joint
    have this name with a suffix.
    """
    name, type_ = node.subject.name, node.attribute("type")
    if type_ not in TYPES:
        node.error("unsupported-joint", f"unsupported joint type {short_repr(type_)}", TYPES)
        type_ = "fixed"
    motions, coordinates = _motions_and_coordinates(node, type_, name in motors)
    origin = read_origin(node)
    return Joint(name, _link(node, "parent"), _link(node, "child"), motions, coordinates, origin)


def _link(node: Node, tag: str) -> str:
    child = node.required(tag)
    return "" if child is None else child.attribute("link")


def _motions_and_coordinates(
    node: Node, type_: str, actuated: bool
) -> tuple[tuple[Motion, ...], tuple[Coordinate, ...]]:
    name = node.subject.name
    if type_ == "fixed":
        for unused in node.all("axis", "limit"):
            unused.mark_used()
        return (), ()
    if type_ in SINGLE_AXIS_TYPES:
        motion = Motion(SINGLE_AXIS_TYPES[type_], _axis(node))
        coordinate = _coordinate(node.with_subject(Subject("coordinate", name)), type_, actuated)
        return (motion,), (coordinate,)
    axes: tuple[Vector3, ...]
    kinds: str
    words: tuple[str, ...]
    if type_ == "floating":
        axes, kinds, words = AXES * 2, "tttrrr", FREE
        node.warning("floating-angles", "it rotates by Rx(alpha) Ry(beta) Rz(gamma) here")
    else:
        normal = _axis(node)
        unit = min(AXES, key=lambda e: abs(sum(map(float.__mul__, e, normal))))
        u = normalized(cross(unit, normal))
        axes, kinds, words = (u, cross(normal, u), normal), "ttr", ("x", "y", "angle")
    names = [f"{name}_{word}" for word in words]
    for each in names:
        node.with_subject(Subject("coordinate", each))
    motions = tuple(
        Motion("rotation" if kind == "r" else "translation", axis, k)
        for k, (kind, axis) in enumerate(zip(kinds, axes, strict=True))
    )
    pairs = zip(names, motions, strict=True)
    return motions, tuple(Coordinate(each, unit=motion.unit) for each, motion in pairs)


def _axis(node: Node) -> Vector3:
    axis = node.optional("axis")
    return X if axis is None or not axis.has("xyz") else normalized(axis.vector_attribute("xyz"))


def _coordinate(node: Node, type_: str, actuated: bool) -> Coordinate:
    limit, dynamics = node.optional("limit"), node.optional("dynamics")
    if type_ in LIMITED and limit is None:
        problem = f"a {type_} joint must have a <limit>; read as unlimited"
        node.warning("no-limit", problem)
    effort = math.inf if limit is None else _number(limit, "effort", math.inf)
    lower, upper = -math.inf, math.inf
    if limit is not None and type_ in LIMITED:
        lower, upper = _number(limit, "lower", 0.0), _number(limit, "upper", 0.0)
    _note_not_simulated(node, limit)
    coupling = tuple(_mimic_term(child) for child in node.all("mimic"))
    if coupling:  # the limits of the leading joint apply
        lower, upper = -math.inf, math.inf
        if actuated or 0.0 < effort < math.inf:
            problem = "follows another joint (<mimic>); its motor is ignored"
            node.warning("motor-left-out", problem)
    return Coordinate(
        node.subject.name,
        lower,
        upper,
        damping=_number(dynamics, "damping", 0.0),
        unit="m" if type_ == "prismatic" else "rad",
        actuated=actuated and not coupling,
        friction=_number(dynamics, "friction", 0.0),
        tau_min=-effort,
        tau_max=effort,
        coupling=coupling,
        max_velocity=_velocity(limit),
    )


def _mimic_term(node: Node) -> Term:
    """Return the coupling of a mimic: multiplier times the leading coordinate, plus offset."""
    factor, offset = node.number_attribute("multiplier", 1.0), node.number_attribute("offset", 0.0)
    return Term(node.attribute("joint"), linear(factor, offset))


def _number(node: Node | None, name: str, default: float) -> float:
    """Return the number in an attribute; infinite if its magnitude is at least `NO_LIMIT`."""
    value = default if node is None else node.number_attribute(name, default, infinite=True)
    return math.copysign(math.inf, value) if abs(value) >= NO_LIMIT else value


def _velocity(limit: Node | None) -> float:
    """Return the maximum velocity; infinite if the limit is negative or does not exist."""
    velocity = _number(limit, "velocity", -1.0)
    return velocity if velocity >= 0.0 else math.inf


def _note_not_simulated(node: Node, limit: Node | None) -> None:
    if limit is not None and _velocity(limit) < math.inf:
        limit.warning("joint-not-simulated", "its velocity limit is not simulated")
    for child in node.all("safety_controller"):
        child.warning("joint-not-simulated", "its safety controller is omitted")
