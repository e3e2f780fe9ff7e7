"""Choice of the joints at which closed loops are cut."""

from __future__ import annotations

from collections.abc import Sequence

from ...robot.model.joint import Motion
from ...robot.model.loop import LoopType, loop_type
from ...robot.model.pose import Vector3
from ..joints.edges import Edge, edge_key

UNSUPPORTED = 4
"""Cost of an edge that cannot close a loop."""
_COSTS: dict[LoopType, int] = {"revolute": 0, "ball": 0, "fixed": 1}
"""Costs of the types that SDF, MuJoCo and OpenSim support."""
_OTHER = 3
_WITH_PROPERTIES = 2


def closing_type(edge: Edge) -> tuple[LoopType, tuple[Vector3, ...]] | None:
    """Return type and axes of the loop joint for an edge, in the frame of `two`; None if unable."""
    return loop_type(tuple(Motion(m.kind, m.axis, k) for k, m in enumerate(edge.motions)))


def lost_properties(edge: Edge) -> list[str]:
    """Return the properties of an edge that a loop joint cannot have."""
    words = {
        "limits": any(m.lower is not None or m.upper is not None for m in edge.motions),
        "effort": any(m.effort is not None for m in edge.motions),
        "velocity": any(m.velocity is not None for m in edge.motions),
        "damping": any(m.damping for m in edge.motions),
        "friction": any(m.friction for m in edge.motions),
        "spring": any(m.stiffness for m in edge.motions),
    }
    return [word for word, is_given in words.items() if is_given]


def cutting_cost(edge: Edge) -> int:
    """Return the cost of a cut at an edge; 0 if every format keeps all properties of the edge."""
    closing = closing_type(edge)
    if closing is None:
        return UNSUPPORTED
    cost = _COSTS.get(closing[0], _OTHER)
    return max(cost, _WITH_PROPERTIES) if lost_properties(edge) else cost


def best_cut(closing: Edge, path: Sequence[Edge]) -> Edge:
    """Return the edge of a loop whose cut has the lowest cost.

    Args:
        closing: The edge that closes the loop; it is preferred among equal costs.
        path: The other edges of the loop that can be cut.
    """
    return min((closing, *sorted(path, key=edge_key)), key=cutting_cost)
