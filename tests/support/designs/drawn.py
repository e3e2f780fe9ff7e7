"""Expected snapshots of drawn designs, computed from the data of the fake in SI units."""

from __future__ import annotations

import random
from collections.abc import Iterator
from typing import Any

import numpy as np
from fake_fusion import Builder
from fake_fusion.build import FREEDOMS
from fake_fusion.designs import random_motion
from fake_fusion.model.data import Path, paths_below, transform

CM = 0.01


def places(design: Any) -> Iterator[tuple[str, Path, Any, np.ndarray]]:
    """Yield path name, path, component and pose, in [cm], of all occurrences of a design."""
    root = design._data.root
    yield "", (), root, np.eye(4)
    for path in paths_below(root):
        yield "+".join(o.name for o in path), path, path[-1].component, transform(path)


def at(T: np.ndarray, p: Any) -> np.ndarray:
    """Return a point, given in [cm], transformed, in [m]."""
    return CM * (T[:3, :3] @ np.asarray(p, dtype=float) + T[:3, 3])


def tensor(mass: Any) -> np.ndarray:
    """Return the inertia matrix of a MassSnapshot with tensor signs about its centre of mass."""
    xx, yy, zz, xy, yz, xz = mass.moments
    I = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])  # noqa: E741
    r = np.array(mass.com)
    return I - mass.mass * (r @ r * np.eye(3) - np.outer(r, r))


def drawn_joints(design: Any) -> dict[tuple[str, str], Any]:
    """Return the expected frames and axes of joints, by path of the occurrence and name."""
    found = {}
    for text, path, component, _ in places(design):
        for joint in (*component.joints, *component.as_built):
            T_two = transform((*path, *joint.two)) @ joint.T_two
            T_one = transform((*path, *joint.one)) @ joint.T_one
            axes = [T_two[:3, :3] @ np.asarray(f.axis, dtype=float) for f in joint.freedoms]
            found[text, joint.name] = (path, joint, T_one, T_two, axes)
    return found


def random_design(order: random.Random, *, joints: bool = True) -> Any:
    """Return a random design with nested components, some with several occurrences, and joints.

    Poses are random or rotated by right angles. The design may contain obsolete rigid groups and
    unresolved references. Names of joints are unique unless their component has several
    occurrences.
    """
    build = Builder(f"design {order.random()}")
    paths: list[Path] = []
    for k in range(order.randint(2, 6)):
        above = order.choice([(), *paths]) if paths else ()
        holders = [build.root, *(o.component for o in above)]
        again = [p[-1].component for p in paths if not _reaches(p[-1].component, holders)]
        what = order.choice(again) if again and order.random() < 0.4 else f"part {k}"
        if above and not isinstance(what, str) and any(o.component is what for o in above):
            what = f"part {k}"
        grounded = order.random() < 0.3
        path = build.place(what, _placement(order), above=above, grounded=grounded)
        paths.append(path)
        if isinstance(what, str):
            build.box(path, [order.uniform(0.5, 5.0) for _ in range(3)], random_motion(order))
            build.cylinder(path, order.uniform(0.5, 2.0), 3.0, random_motion(order))
            build.point(path, [order.uniform(-9, 9) for _ in range(3)], f"EE_{k}")
    if joints:
        _draw_joints(build, paths, order)
    for k, path in enumerate(paths):
        if order.random() < 0.2:
            build.rigid_group(f"left over {k}", [], inside=path[:-1], stale=True)
        if order.random() < 0.1:
            build.unresolved(f"lost {k}", _placement(order), above=path)
    build.shuffle(order)
    return build.done()


def _reaches(component: Any, holders: list[Any]) -> bool:
    """Return whether placing a component would create a cycle."""
    below = [component, *(path[-1].component for path in paths_below(component))]
    return any(known is holder for known in below for holder in holders)


def _placement(order: random.Random) -> np.ndarray:
    """Return a random pose with a random rotation or a rotation by right angles."""
    T = random_motion(order)
    if order.random() < 0.5:
        rows = order.sample(range(3), 3)
        R = np.eye(3)[rows] * [[order.choice((-1.0, 1.0))] for _ in rows]
        T[:3, :3] = R * np.linalg.det(R)
    return T


def _draw_joints(build: Builder, paths: list[Path], order: random.Random) -> None:
    used: set[int] = set()
    for k, one in enumerate(paths):
        if id(one[-1]) in used:
            continue
        used.add(id(one[-1]))
        inside = one[:-1]
        others = [
            p for p in paths if p[: len(inside)] == inside and p != one and p[-1] is not one[-1]
        ]
        two = order.choice([inside, *[p for p in others if p[: len(one)] != one]])
        kind = order.choice(list(FREEDOMS))
        count = len(FREEDOMS[kind])
        values = [order.uniform(-0.8, 0.8) for _ in range(count)]
        build.joint(
            f"joint {k}",
            kind,
            one,
            two,
            T=_placement(order),
            values=values,
            limits=[(v - 1.0, None) for v in values],
            inside=inside,
            as_built=order.random() < 0.3,
            by_origins=order.random() < 0.3,
            dragged=order.random() < 0.3,
        )
