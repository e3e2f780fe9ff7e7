"""Random robots that use every field of the description, and variants with one changed field."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import fields, is_dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from addin_sdfusion.robot import (
    WORLD,
    BasePulley,
    Branch,
    CableModel,
    CableSet,
    Coordinate,
    CoordinateTerm,
    Inertia,
    Joint,
    LimitForce,
    Link,
    LoopJoint,
    Mesh,
    Muscle,
    PointCondition,
    PointMotion,
    Polynomial,
    Pose,
    Robot,
    Shape,
    SimmSpline,
    TaskFrame,
    TaskSet,
    Term,
    ViaPoint,
    Wrap,
    WrapSurface,
)

from .muscle_bench import SOUND
from .random_robots import random_tree
from .wrapped import vector

HALF = Polynomial((0.1, 0.5))


def robot_of_every_field(seed: int) -> Robot:
    """Return a random tree with meshes, limits, springs, motors, all muscle laws and wraps.

    With an odd seed, joint frames are not rotated at q = 0, as in CASPR.
    """
    rng = np.random.default_rng(seed)
    tree = random_tree(seed)
    names = [link.name for link in tree.links]
    links = [_seen(rng, link) if k % 2 == 0 else link for k, link in enumerate(tree.links)]
    joints = [
        replace(joint, coordinates=tuple(_limited(rng, c, k) for c in joint.coordinates))
        for k, joint in enumerate(tree.joints)
    ]
    if seed % 2:
        joints = [_straight(joint) for joint in joints]
    surfaces = (
        WrapSurface("ball", names[0], "sphere", 0.1, _pose(rng)),
        WrapSurface("rod", WORLD, "cylinder", 0.2, _pose(rng)),
        WrapSurface("drum", names[-1], "cylinder", 0.1, _pose(rng), 0.4),
        WrapSurface("egg", names[0], "ellipsoid", 0.1, _pose(rng), half_axes=(0.2, 0.3)),
    )
    # fmt: off
    cables = [Muscle(f"law {kind}", _way(rng, names)[:2 if kind == "heavy_cable" else 4], 1.0, 50.0,
                     CableModel(kind, tuple(SOUND[kind].items())))  # type: ignore[arg-type]
              for kind in SOUND]
    # fmt: on
    cables = [
        replace(muscle, f_min=0.0, f_max=0.0) if muscle.model.kind == "passive_spring" else muscle
        for muscle in cables
    ]
    wraps = (
        Wrap("ball", 0, 1, friction=0.3),
        Wrap("rod", 1),
        Wrap("drum", 1, -1, 1),
        Wrap("rod", 2, inside=True),
    )
    first, *others = _way(rng, names)
    way = (first, replace(others[0], friction=0.2), *others[1:])
    cables.append(Muscle("wrapped", way, 0.0, 100.0, wraps=wraps, friction=0.1))
    cables.append(Muscle("thick", _way(rng, names), 0.0, 9.0, CableModel("ideal", _thick())))
    cables.append(Muscle("sprung", _way(rng, names), 0.0, 9.0, CableModel("linear_spring", _k())))
    cables.append(Muscle("led", _way(rng, names, WORLD), 0.0, 9.0, pulley=_pulley()))
    cables += _of_other_programs(rng, tree, names)
    elastic = SOUND["hill_degroote2016"] | {"elastic_tendon": 1.0, "fibre_damping": 0.1}
    model = CableModel("hill_degroote2016", tuple(elastic.items()))
    other = (replace(cables[0], name="other"), Muscle("tendon", _way(rng, names), model=model))
    more = (TaskFrame("knee", names[0], vector(rng), ("z", "y")), TaskFrame("toe", names[-1]))
    return replace(
        tree,
        links=tuple(links),
        joints=tuple(joints),
        cable_sets=(CableSet("all", tuple(cables)), CableSet("less", other)),
        cable_set="all",
        task_sets=(*tree.task_sets, TaskSet("more", more)),
        wrap_surfaces=surfaces,
    )


def _of_other_programs(
    rng: np.random.Generator, tree: Robot, names: list[str]
) -> tuple[Muscle, ...]:
    """Return muscles with features of OpenSim and MuJoCo models."""
    first, *others = _way(rng, names)
    coordinates = [c.name for c in tree.coordinates]
    spline = SimmSpline((-1.0, 0.0, 0.5, 1.0), (0.0, 0.25, 0.125, 0.5))
    moves = (
        PointMotion((1.0, 0.0, 0.0), coordinates[0], spline, -0.75, 0.75),
        PointMotion((0.0, 0.5, 0.5), coordinates[-1], Polynomial((0.5, 0.25))),
    )
    at_times = replace(
        others[0], when=PointCondition(coordinates[0], -0.5, 0.75, 0.125), moves=moves
    )
    points = (first, at_times, *others[1:], *_way(rng, names))
    branches, terms = (Branch(0, 1.5), Branch(4, 2.0)), (CoordinateTerm(coordinates[-1], 0.5),)
    site = ViaPoint(names[-1], vector(rng))
    at_side = Wrap("ball", 0, rule="mujoco", side_point=site)
    in_half = Wrap("drum", 0, rule="opensim", quadrant="-y", last_segment=2)
    moving = _way(rng, names, names[0], WORLD, names[-1])  # so that its rule has an effect
    return (
        Muscle("at times", points, 0.0, 9.0, branches=branches, terms=terms),
        Muscle("at side", _way(rng, names), 0.0, 9.0, wraps=(at_side,)),
        Muscle("by MuJoCo", moving, 0.0, 9.0, wraps=(Wrap("rod", 1, rule="mujoco"),)),
        Muscle("by OpenSim", _way(rng, names), 0.0, 9.0,
               wraps=(in_half, Wrap("egg", 0, rule="opensim"))),
    )  # fmt: skip


def _seen(rng: np.random.Generator, link: Link) -> Link:
    """Return a link with meshes and an end."""
    color = (0.25, 0.5, 1.0, 0.75)
    visual = Mesh("visual", "a.stl", _pose(rng), (0.001, 0.002, 0.003), "shell", color)
    collision = Mesh("collision", "b.stl", _pose(rng))
    shapes = (
        Shape("box", (0.25, 0.125, 0.5), _pose(rng)),
        Shape("sphere", (0.125,), _pose(rng)),
        Shape("cylinder", (0.0625, 0.375), _pose(rng)),
    )
    return replace(link, end=vector(rng), meshes=(visual, collision), shapes=shapes)


def _straight(joint: Joint) -> Joint:
    poses = (Pose(joint.T_parent_joint.position), Pose(joint.T_child_joint.position))
    return replace(joint, T_parent_joint=poses[0], T_child_joint=poses[1])


def _limited(rng: np.random.Generator, c: Coordinate, k: int) -> Coordinate:
    damping, stiffness, rest, friction = (float(x) for x in rng.uniform(0.1, 1.0, 4))
    return replace(
        c,
        lower=-1.5 if k % 3 else -math.inf,
        upper=1.25,
        initial=float(rng.uniform(-1.0, 1.0)),
        damping=damping,
        actuated=k % 2 == 0,
        stiffness=stiffness,
        rest=rest,
        friction=friction,
        tau_min=-3.0 if k % 4 == 0 else -math.inf,
        tau_max=5.0 if k % 4 == 0 else math.inf,
        max_velocity=6.0 if k % 3 == 0 else math.inf,
    )


def _pose(rng: np.random.Generator) -> Pose:
    return Pose(vector(rng), vector(rng))


def _way(rng: np.random.Generator, names: list[str], *first: str) -> tuple[ViaPoint, ...]:
    links = [*first, *rng.choice([WORLD, *names], 4).tolist()][:4]
    return tuple(ViaPoint(link, vector(rng)) for link in links)


def _thick() -> tuple[tuple[str, float], ...]:
    return (("diameter", 0.002), ("force_error", -1.0))


def _k() -> tuple[tuple[str, float], ...]:
    return (("K", 100.0),)


def _pulley() -> BasePulley:
    numbers = (("pulley_radius", (0.05,)), ("cable_entry_vector", (0.0, 0.6, 0.8)))
    return BasePulley("rotating", numbers)


def _winch() -> BasePulley:
    rows = (("winch_vector", (1.0, 0.0, 0.0)), ("cable_pulley_entry_vector", (0.0, 0.6, 0.8)))
    sizes = ("pulley_radius", "winch_radius", "winch_groove_width")
    return BasePulley("screw", (*rows, *((name, (0.05,)) for name in sizes)))


class Variant(NamedTuple):
    """Robot with one changed field.

    Attributes:
        field: The changed field, such as `Coordinate.damping`.
        within: The original objects that contain it, from the robot to the object with this field.
        robot: The changed robot.
    """

    field: str
    within: tuple[Any, ...]
    robot: Robot


def variants(robot: Robot) -> Iterator[Variant]:
    """Yield robots with one changed field; they may be invalid."""
    for field, within, changed in _changes(robot, (robot,)):
        if changed != robot:
            yield Variant(field, within, changed)
    for field, within, old, new in _renamings(robot):
        yield Variant(field, within, _renamed(robot, field, old, new))


def _changes(part: Any, within: tuple[Any, ...]) -> Iterator[tuple[str, tuple[Any, ...], Any]]:
    robot = within[0]
    for item in fields(part):
        name, value = item.name, getattr(part, item.name)
        label = f"{type(part).__name__}.{name}"
        if is_dataclass(value):
            for field, chain, new in _changes(value, (*within, value)):
                yield field, chain, replace(part, **{name: new})
        if isinstance(value, tuple) and value and is_dataclass(value[0]):
            for k, member in enumerate(value):
                for field, chain, new in _changes(member, (*within, member)):
                    yield field, chain, replace(part, **{name: (*value[:k], new, *value[k + 1 :])})
            yield f"{label} order", within, replace(part, **{name: value[::-1]})
            yield f"{label} number", within, replace(part, **{name: value[:-1]})
        for new in _others(robot, part, name, value):
            yield label, within, replace(part, **{name: new})
    if isinstance(part, Joint) and part.motions:
        yield from _other_motions(part, within)


def _other_motions(
    joint: Joint, within: tuple[Any, ...]
) -> Iterator[tuple[str, tuple[Any, ...], Joint]]:
    """Yield joints with the last motion of the other kind, or with changed coordinates."""
    *others, last = joint.motions
    moved, unit = ("translation", "m") if last.kind == "rotation" else ("rotation", "rad")
    k, c = last.coordinate, joint.coordinates
    coordinates = (*c[:k], replace(c[k], unit=unit), *c[k + 1 :])  # type: ignore[arg-type]
    motions = (*others, replace(last, kind=moved))  # type: ignore[arg-type]
    yield "Motion.kind", within, replace(joint, motions=motions, coordinates=coordinates)
    if len(joint.motions) > 1:
        first, *between = others
        new = (replace(first, coordinate=k), *between, replace(last, coordinate=first.coordinate))
        yield "Motion.coordinate", within, replace(joint, motions=new)


def _others(robot: Robot, part: Any, name: str, value: Any) -> Iterator[Any]:
    """Yield other values of a field."""
    links = [WORLD, *(link.name for link in robot.links)]
    choices: dict[str, list[Any]] = {
        "link": links,
        "parent": links,
        "surface": [surface.name for surface in robot.wrap_surfaces],
        "cable_set": [group.name for group in robot.cable_sets],
        "task_set": [group.name for group in robot.task_sets],
        "shape": ["sphere", "cylinder"],
        "role": ["visual", "collision"],
        "side": [-1, 0, 1],
        "segment": [0, 1, 2],
        "last_segment": [None, 1, 2],
        "rule": ["taut", "mujoco", "opensim"],
        "quadrant": ["all", "+x", "-z"],
        "moves": [()],
        "when": [None, PointCondition(robot.coordinates[0].name, -1.0, 1.0)],
        "side_point": [None, ViaPoint(WORLD, (0.5, 0.0, 0.0))],
        "point": [0, 2, 4],
        "turns": [0, 1, 2],
        "end": [None, (0.0, 0.0, 0.0), (0.1, 0.2, 0.3)],
        "uri": ["a.stl", "c.stl"],
        "axes": [("x",), ("y", "x"), ("alpha",), ("gamma", "beta", "alpha")],
        "model": [CableModel(), CableModel("elastic_cable", (("stiffness", 1e3),))],
        "pulley": [None, _winch()],
        "coupling": [(Term(name, HALF),) for name in _other_coordinates(robot, part)],
        "loops": [
            (LoopJoint("loop", WORLD, robot.links[-1].name, "revolute", ((0.0, 1.0, 0.0),)),)
        ],
        "limit_force": [None, LimitForce(-0.5, 0.5, 3.0, 4.0, 0.1)],
    }
    if name == "coordinate" and isinstance(value, str):
        yield from (c.name for c in robot.coordinates if c.name != value)
    elif name in choices:
        yield from (other for other in choices[name] if other != value)
    elif isinstance(value, bool):
        yield not value
    elif isinstance(value, float):
        yield from _numbers(part, name, value)
    elif name == "axis":
        yield (value[1], value[2], value[0])
    elif name == "parameters":
        yield from _parameters(value)
    elif isinstance(value, tuple) and value and isinstance(value[0], float):
        for k in range(len(value)):
            yield (*value[:k], value[k] + 0.0625, *value[k + 1 :])


def _other_coordinates(robot: Robot, part: Any) -> list[str]:
    return [c.name for c in robot.coordinates if c != part][:1]


def _numbers(part: Any, name: str, value: float) -> Iterator[float]:
    if isinstance(part, Inertia):
        yield value * 1.001 + 1e-5 * (name != "mass")
    elif math.isinf(value):
        yield math.copysign(2.5, value)
    else:
        yield value + 0.0625
        if name in ("damping", "stiffness", "friction"):
            yield 0.0
        if name in ("lower", "upper", "tau_min", "tau_max", "length"):
            yield math.inf if name in ("upper", "tau_max", "length") else -math.inf


def _parameters(value: tuple[tuple[str, Any], ...]) -> Iterator[tuple[tuple[str, Any], ...]]:
    for k, (name, number) in enumerate(value):
        new = number * 1.01 if isinstance(number, float) else (number[0] + 0.125, *number[1:])
        yield (*value[:k], (name, new), *value[k + 1 :])
        yield value[:k] + value[k + 1 :]


def _renamings(robot: Robot) -> Iterator[tuple[str, tuple[Any, ...], str, str]]:
    parts: list[tuple[Any, ...]] = [(robot, part) for part in (*robot.links, *robot.joints)]
    parts += [(robot, joint, c) for joint in robot.joints for c in joint.coordinates]
    parts += [(robot, group) for group in (*robot.cable_sets, *robot.task_sets)]
    parts += [(robot, group, member) for group in robot.cable_sets for member in group.muscles]
    parts += [(robot, group, member) for group in robot.task_sets for member in group.frames]
    parts += [(robot, surface) for surface in robot.wrap_surfaces]
    parts += [(robot, link, mesh) for link in robot.links for mesh in link.meshes]
    for within in ((robot,), *parts):
        name = within[-1].name
        yield f"{type(within[-1]).__name__}.name", within, name, "new"


_REFERENCES = {
    "Link.name": ("parent", "child", "link"),
    "WrapSurface.name": ("surface",),
    "CableSet.name": ("cable_set",),
    "TaskSet.name": ("task_set",),
    "Coordinate.name": ("coordinate",),
}


def _renamed(part: Any, field: str, old: str, new: str) -> Any:
    """Return a part in which objects of a type and name, and references to them, are renamed."""
    changes: dict[str, Any] = {}
    for item in fields(part):
        value = getattr(part, item.name)
        if is_dataclass(value):
            changes[item.name] = _renamed(value, field, old, new)
        elif isinstance(value, tuple) and value and is_dataclass(value[0]):
            changes[item.name] = tuple(_renamed(member, field, old, new) for member in value)
    for name in _REFERENCES.get(field, ()):
        if getattr(part, name, None) == old:
            changes[name] = new
    if f"{type(part).__name__}.name" == field and part.name == old:
        changes["name"] = new
    return replace(part, **changes)
