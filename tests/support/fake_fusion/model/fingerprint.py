"""Fingerprint of a design, which detects changes."""

from __future__ import annotations

import hashlib
import json
from typing import Any

import numpy as np

from .data import DesignData, Path

GROUP = "CARDSFlow"


def fingerprint(design: DesignData, *, everything: bool = False) -> str:
    """Return a text that is equal for equal designs only.

    Args:
        design: The design.
        everything: Whether to include objects that the add-in may create: construction points,
            attributes and custom graphics.
    """
    text = json.dumps(content(design, everything=everything), sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()


def content(design: DesignData, *, everything: bool = False) -> Any:
    """Return the content of a design as plain data, which shows differences."""
    return {
        "design": [design.name, design.kind, design.intent, design.units],
        "attributes": _attributes(design, everything),
        "components": [_component(c, everything) for c in design.components],
    }


def _attributes(owner: Any, everything: bool) -> Any:
    return sorted(
        [*key, value] for key, value in owner.attributes.items() if everything or key[0] != GROUP
    )


def _component(c: Any, everything: bool) -> Any:
    points = [p for p in c.points if everything or p.by_user]
    return {
        "name": c.name,
        "mass": [c.user_mass, c.opacity],
        "occurrences": [
            [o.name, _numbers(o.T), o.grounded, o.ground_to_parent, _named(o, everything)]
            for o in c.occurrences
        ],
        "bodies": [
            [_named(b, everything), b.kind, b.material, repr(b.shape)]
            for b in (*c.bodies, *c.mesh_bodies)
        ],
        "points": [[_named(p, everything), _numbers(p.position)] for p in points],
        "sketches": [
            [
                _named(s, everything),
                _numbers(s.T),
                [_numbers(p.position) for p in s.points],
            ]
            for s in c.sketches
        ],
        "joints": [_joint(j, everything) for j in (*c.joints, *c.as_built)],
        "groups": [
            [_named(g, everything), [_path(m) for m in g.members], g.suppressed] for g in c.groups
        ],
        "origins": [[_named(o, everything), _numbers(o.T)] for o in c.joint_origins],
        "graphics": len(c.graphics) if everything else 0,
        "base_features": [
            [
                _named(f, everything),
                [[_named(p, everything), _numbers(p.position)] for p in f.points],
            ]
            for f in (c.base_features if everything else ())
        ],
    }


def _named(item: Any, everything: bool) -> Any:
    return [item.name, item.light_bulb, _attributes(item, everything)]


def _joint(j: Any, everything: bool) -> Any:
    return [
        _named(j, everything),
        [j.kind, j.type, j.suppressed, j.locked, _path(j.one), _path(j.two)],
        [_numbers(j.T_one), _numbers(j.T_two)],
        [[f.role, f.value, vars(f.limits)] for f in j.freedoms],
    ]


def _path(path: Path) -> str:
    return "+".join(o.name for o in path)


def _numbers(values: Any) -> Any:
    return None if values is None else np.asarray(values).ravel().tolist()
