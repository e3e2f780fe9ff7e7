"""Entities that a user can click: accepted by the filters, visible, and not inside a body.

An entity inside an opaque body can be selected only by a long press [manual]. Faces and edges are
inside a body if all sampled points of them are inside it.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base import FakeMistake
from ..maths import inverse
from ..model.data import BodyData, Path, TopologyData, paths_below, transform
from ..model.filters import passes
from ..model.points import position_of
from ..model.shapes import Cylinder, Shape, Sphere, Torus
from ..state import world

_SAME = 1e-6
"""Distance from the surface that is not inside, in [cm]."""


def why_not(entity: Any, data: Any, through: bool) -> str:
    """Return the reason why a user cannot click an entity in a selection input; empty if possible.

    Args:
        entity: The entity, in the context of the root.
        data: The selection input.
        through: Whether the user presses long, and chooses the entity from a list.
    """
    design = world().active
    path = entity._path
    context = path[0].parent if path else getattr(entity._data, "component", None)
    if entity._data is not design.root and context is not design.root:
        raise FakeMistake(f"{entity!r}: picked entities must be in the context of the root")
    if not passes(entity, data.fields["filters"]):
        return f"{entity!r} is not one of {', '.join(data.fields['filters'])}"
    if any(entity == chosen.entity for chosen in data.fields["selections"]):
        return f"{entity!r} is selected already"
    if not _is_visible(entity):
        return f"{entity!r} is hidden"
    if not through and (body := _enclosing(entity)) is not None:
        return f"{entity!r} is inside body {body.name!r}"
    return ""


def _is_visible(entity: Any) -> bool:
    data = entity._data
    above = [getattr(data, name, None) for name in ("body", "sketch")]
    return all(d.light_bulb for d in (data, *above, *entity._path) if d is not None)


def _enclosing(entity: Any) -> BodyData | None:
    """Return the opaque body that contains an entity."""
    points = _samples(entity)
    if points is None:
        return None
    for path in [(), *paths_below(world().active.root)]:
        owner = path[-1].component if path else world().active.root
        for body in () if path and path[-1].unresolved else owner.bodies:
            if _is_opaque(body, path) and body is not getattr(entity._data, "body", None):
                own = _moved(inverse(transform(path) @ body.shape.T), points)
                if np.all(_inside(body.shape, own)):
                    return body
    return None


def _is_opaque(body: BodyData, path: Path) -> bool:
    shown = body.light_bulb and all(o.light_bulb for o in path)
    components = [body.component, *(o.parent for o in path)]
    return shown and min(body.opacity, *(c.opacity for c in components)) == 1.0


def _samples(entity: Any) -> np.ndarray | None:
    """Return points of an entity in the root frame, shape (n, 3); None for other entities."""
    data = entity._data
    if isinstance(data, TopologyData) and data.kind != "vertex":
        if data.body.shape is None:
            return None
        nodes, _ = data.body.shape.mesh(12)
        return _moved(entity._T, nodes)
    try:
        return position_of(entity)[None, :]
    except AttributeError:
        return None


def _moved(T: np.ndarray, points: np.ndarray) -> np.ndarray:
    return points @ T[:3, :3].T + T[:3, 3]


def _inside(shape: Shape, p: np.ndarray) -> np.ndarray:
    """Return for each point in the frame of a shape whether it is inside."""
    x, y, z = p.T
    across = np.hypot(x, y)
    if isinstance(shape, Sphere):
        return np.linalg.norm(p, axis=1) < shape.radius - _SAME
    if isinstance(shape, Torus):
        return np.hypot(across - shape.major, z) < shape.minor - _SAME
    if isinstance(shape, Cylinder):
        return (across < shape.radius - _SAME) & (np.abs(z) < shape.height / 2.0 - _SAME)
    return np.all(np.abs(p) < np.asarray(shape.size) / 2.0 - _SAME, axis=1)
