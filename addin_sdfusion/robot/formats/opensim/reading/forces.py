"""Reader of OpenSim forces at coordinates: motors, springs with dampers, limit forces."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

from ....finding_builders import unknown
from ....model.joint import Coordinate, Joint, LimitForce
from ...reading.xml import Node
from .document import is_true, last_part, text

Change = Callable[[Node, Coordinate], Coordinate]


def with_joint_forces(joints: Sequence[Joint], forces: Sequence[Node]) -> list[Joint]:
    """Return the joints with the forces at their coordinates; report unsupported forces."""
    coordinates = {c.name: c for joint in joints for c in joint.coordinates}
    unread: dict[str, list[Node]] = {}
    for node in forces:
        if not is_true(node, "appliesForce", True):
            continue
        if node.tag not in CHANGES:
            unread.setdefault(node.tag, []).append(node)
            continue
        name = last_part(text(node, "coordinate"))
        if name not in coordinates:
            problem = f"<{node.tag}>: {unknown('coordinate', name, list(coordinates))}"
            node.error("unknown-coordinate", problem)
        else:
            coordinates[name] = CHANGES[node.tag](node, coordinates[name])
    for tag, nodes in unread.items():
        names = ", ".join(repr(node.attribute("name", "")) for node in nodes[:10])
        problem = f"<{tag}> is not supported; {len(nodes)} omitted: {names}"
        nodes[0].warning("force-left-out", problem)
    return [joint.map_coordinates(lambda c: coordinates[c.name]) for joint in joints]


def _motor(node: Node, c: Coordinate) -> Coordinate:
    """Return a coordinate with a motor; several motors become one with the sum of the torques."""
    if not c.is_free:
        state = "locked" if c.locked else "coupled to another"
        problem = f"coordinate {c.name!r} is {state}; its motor {node.attribute('name', '')!r}"
        node.warning("motor-left-out", f"{problem} is omitted")
        return c
    scale = node.number("optimal_force", 1.0)
    low = scale * node.number("min_control", -math.inf, infinite=True)
    high = scale * node.number("max_control", math.inf, infinite=True)
    if c.actuated:
        problem = f"a second motor at {c.name!r}; both are combined, with the sum of both torques"
        node.warning("motors-joined", problem)
        low, high = low + c.tau_min, high + c.tau_max
    return replace(c, actuated=True, tau_min=low, tau_max=high)


def _spring(node: Node, c: Coordinate) -> Coordinate:
    k, rest = node.number("stiffness", 0.0), node.number("rest_length", 0.0)
    stiffness = c.stiffness + k
    if c.stiffness and k:  # two springs are equal to one with a mean rest length
        rest = (c.stiffness * c.rest + k * rest) / stiffness
    elif c.stiffness:
        rest = c.rest
    damping = c.damping + node.number("viscosity", 0.0)
    return replace(c, stiffness=stiffness, rest=rest, damping=damping)


def _limit_force(node: Node, c: Coordinate) -> Coordinate:
    """Return a coordinate with a limit force; for rotations OpenSim uses degrees in all units."""
    degree = math.pi / 180.0 if c.unit == "rad" else 1.0
    if c.limit_force is not None:
        problem = f"a second limit force at {c.name!r} is omitted"
        node.warning("force-left-out", problem)
        return c
    force = LimitForce(
        degree * node.number("lower_limit", 0.0),
        degree * node.number("upper_limit", 0.0),
        node.number("lower_stiffness", 1.0) / degree,
        node.number("upper_stiffness", 1.0) / degree,
        node.number("damping", 0.001) / degree,
        degree * node.number("transition", 0.1),
    )
    return replace(c, limit_force=force)


CHANGES: dict[str, Change] = {
    "CoordinateActuator": _motor,
    "SpringGeneralizedForce": _spring,
    "CoordinateLimitForce": _limit_force,
}
