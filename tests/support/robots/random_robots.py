"""Random robots: strategies of Hypothesis, and robots and states from a seed."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
from hypothesis import strategies as st

from addin_sdfusion.robot import (
    GRAVITY,
    IDENTITY,
    WORLD,
    BasePulley,
    CableModel,
    CableSet,
    Coordinate,
    Inertia,
    Joint,
    Link,
    Motion,
    Muscle,
    Pose,
    Robot,
    TaskFrame,
    TaskSet,
    ViaPoint,
    prismatic,
    revolute,
)
from addin_sdfusion.robot.caspr_vocabulary import CASPR_CABLES, CASPR_PULLEYS
from addin_sdfusion.robot.formats.caspr.joints import CASPR_JOINTS
from addin_sdfusion.robot.model.rotations import normalized

from .wrapped import vector
from .writable import writable

numbers = st.floats(-10.0, 10.0, allow_subnormal=False)
vectors = st.tuples(numbers, numbers, numbers)
angles = st.tuples(*[st.floats(-3.0, 3.0).map(lambda angle: round(angle, 15))] * 3)
# their products with masses are zero or far from underflow
poses = st.builds(Pose, vectors, st.one_of(st.just((0.0, 0.0, 0.0)), angles))
translations = st.builds(Pose, vectors)
names = st.text("abxyz012 _-.'\"&<>é関", min_size=1, max_size=8).filter(
    lambda name: name == name.strip() and not name.startswith("__") and name != WORLD
)
coordinate_axes = st.sampled_from([(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)])
axes = st.one_of(
    coordinate_axes,
    vectors.filter(lambda v: math.hypot(*v) > 1e-3).map(normalized),
)


@st.composite
def inertias(draw: st.DrawFn) -> Inertia:
    """Draw physically possible mass properties, from a positive definite ∫ r rᵀ dm."""
    a, b, c = (draw(st.floats(0.1, 1.0)) for _ in range(3))
    ab, ac, bc = (round(draw(st.floats(-0.04, 0.04)), 12) for _ in range(3))
    mass = draw(st.floats(0.01, 10.0))
    return Inertia(mass, draw(vectors), b + c, a + c, a + b, -ab, -ac, -bc)


springs = st.tuples(st.floats(0.0, 5.0), numbers, st.floats(0.0, 5.0))
"""Stiffness, rest and friction of a joint."""


@st.composite
def coordinates(
    draw: st.DrawFn, joint: str, motions: tuple[Motion, ...], caspr: bool
) -> tuple[Coordinate, ...]:
    """Draw the coordinates of a joint with given motions."""
    suffixes = next((j.suffixes for j in CASPR_JOINTS.values() if j.motions == motions), None)
    suffixes = suffixes or ("",) * len(motions)
    actuated = caspr and draw(st.booleans())
    units = [motion.unit for motion in sorted(motions, key=lambda motion: motion.coordinate)]
    drawn = []
    for unit, suffix in zip(units, suffixes, strict=True):
        lower, upper = sorted((draw(numbers), draw(numbers)))
        upper = upper if upper > lower else lower + 1.0  # equal limits are read as locked
        coordinate = Coordinate(
            f"{joint}_{suffix}" if suffix else joint,
            draw(st.sampled_from([lower, -math.inf])),
            draw(st.sampled_from([upper, math.inf])),
            draw(numbers),
            0.0 if caspr else draw(st.floats(0.0, 5.0)),
            unit,
            actuated,
            *([] if caspr else draw(springs)),
        )
        drawn.append(coordinate)
    return tuple(drawn)


@st.composite
def motions(draw: st.DrawFn, caspr: bool) -> tuple[Motion, ...]:
    """Draw any joint of CASPR, or a revolute, prismatic or fixed joint."""
    single = st.one_of(axes.map(revolute), axes.map(prismatic))
    if caspr:
        return draw(st.one_of(single, st.sampled_from([j.motions for j in CASPR_JOINTS.values()])))
    return draw(st.one_of(single, st.just(())))


@st.composite
def cable_models(draw: st.DrawFn) -> CableModel:
    """Draw any CASPR cable, with or without its optional properties."""
    cable = draw(st.sampled_from(list(CASPR_CABLES.values())))
    parameters = []
    for item in cable.properties:
        if item.required or draw(st.booleans()):
            count = item.size or draw(st.integers(1, 4))
            parameters += [(item.name(k), draw(numbers)) for k in range(1, count + 1)]
    if cable.kind == "passive_spring":  # must be valid, because it is simulated
        parameters = [(name, abs(value) if name == "K" else value) for name, value in parameters]
    return CableModel(cable.kind, tuple(parameters))


@st.composite
def base_pulleys(draw: st.DrawFn) -> BasePulley:
    """Draw one of the base pulleys of CASPR."""
    words = draw(st.sampled_from(list(CASPR_PULLEYS.values())))
    rows = [
        draw(st.tuples(*[numbers] * 3).filter(any))
        if item.size == 3
        else (draw(st.floats(1e-3, 1.0)),)
        for item in words.properties
    ]
    tags = [item.tag for item in words.properties]
    return BasePulley(words.kind, tuple(zip(tags, rows, strict=True)))


@st.composite
def caspr_muscles(draw: st.DrawFn, name: str, links: list[str]) -> Muscle:
    """Draw a muscle of any kind in CASPR."""
    muscle = replace(draw(muscles(name, links)), model=draw(cable_models()))
    if muscle.model.kind == "passive_spring":
        muscle = replace(muscle, f_min=0.0, f_max=0.0)
    first, *others = muscle.via_points
    first = replace(first, link=WORLD)
    if first != others[0] and draw(st.booleans()):
        muscle = replace(muscle, via_points=(first, *others), pulley=draw(base_pulleys()))
    return muscle


@st.composite
def muscles(draw: st.DrawFn, name: str, links: list[str]) -> Muscle:
    """Draw an ideal muscle with via points on any links and the world."""
    point = st.builds(ViaPoint, st.sampled_from([WORLD, *links]), vectors)
    points = draw(
        st.lists(point, min_size=2, max_size=4).filter(
            lambda through: all(a != b for a, b in pairwise(through))
        )
    )
    f_min, f_max = sorted((draw(st.floats(0.0, 100.0)), draw(st.floats(0.0, 100.0))))
    return Muscle(name, tuple(points), f_min, draw(st.sampled_from([f_max, math.inf])))


@st.composite
def cable_sets(draw: st.DrawFn, name: str, links: list[str], caspr: bool) -> CableSet:
    """Draw a cable set with up to three muscles."""
    members = draw(st.lists(names, max_size=3, unique=True))
    kinds = caspr_muscles if caspr else muscles
    return CableSet(name, tuple(draw(kinds(member, links)) for member in members))


def some_of(*axes: str) -> st.SearchStrategy[tuple[str, ...]]:
    """Draw some axes, in any order."""
    return st.lists(st.sampled_from(axes), min_size=1, max_size=3, unique=True).map(tuple)


@st.composite
def task_sets(draw: st.DrawFn, name: str, links: list[str], caspr: bool) -> TaskSet:
    """Draw a task set with one or two frames; for CASPR also with orientations and poses."""
    frames = []
    for member in draw(st.lists(names, min_size=1, max_size=2, unique=True)):
        link = draw(st.sampled_from(links))
        kind = draw(st.sampled_from(["position", "orientation", "pose"] if caspr else ["position"]))
        if kind != "orientation":
            frames.append(TaskFrame(member, link, draw(vectors), draw(some_of("x", "y", "z"))))
        if kind != "position":
            angles = draw(some_of("alpha", "beta", "gamma"))
            called = member + "_orientation" if kind == "pose" else member
            frames.append(TaskFrame(called, link, (0.0, 0.0, 0.0), angles))
    return TaskSet(name, tuple(frames))


@st.composite
def robots(draw: st.DrawFn, caspr: bool = False) -> Robot:
    """Draw a valid robot: a tree of up to five links with cable sets and task sets.

    With `caspr`, files of CASPR can represent it completely.
    """
    count = draw(st.integers(1, 5))
    drawn = draw(st.lists(names, min_size=2 * count, max_size=2 * count, unique=True))
    link_names = drawn[:count]
    joint_names = [f"joint_{i + 1}" for i in range(count)] if caspr else drawn[count:]
    ends = vectors if caspr else st.none() | vectors
    links, joints = [], []
    for i in range(count):
        moves = draw(motions(caspr))
        links.append(Link(link_names[i], draw(inertias()), draw(ends)))
        joints.append(
            Joint(
                joint_names[i],
                draw(st.sampled_from([WORLD, *link_names[:i]])),
                link_names[i],
                moves,
                draw(coordinates(joint_names[i], moves, caspr)),
                draw(translations if caspr else poses),
                IDENTITY if caspr else draw(poses),
            )
        )
    cables = draw(st.lists(names, max_size=3, unique=True))
    tasks = draw(st.lists(names, max_size=2, unique=True))
    robot = Robot(
        "robot" if caspr else draw(names),
        tuple(links),
        tuple(joints),
        tuple(draw(cable_sets(name, link_names, caspr)) for name in cables),
        draw(st.sampled_from(cables or [""])),
        tuple(draw(task_sets(name, link_names, caspr)) for name in tasks),
        draw(st.sampled_from(tasks or [""])),
        GRAVITY if caspr else draw(vectors),
    )
    sound: Robot = writable(robot)
    return sound


FREE = CASPR_JOINTS["SPATIAL_EULER_XYZ"].motions


def random_tree(seed: int, damping: float = 0.0) -> Robot:
    """Return a tree of up to seven links with branches, fixed joints, and sometimes a free base.

    Its task frames are a point, `hand`, and the angles of its parent link, `palm`. Every coordinate
    has the given damping, in [N·m·s/rad] or [N·s/m].
    """
    rng = np.random.default_rng(seed)
    count = int(rng.integers(2, 8))
    links, joints, names = [], [], [WORLD]
    for k in range(count):
        motions = FREE if k == 0 and seed % 3 == 0 else _motions(rng, k)
        name = f"link_{k}"
        links.append(Link(name, _inertia(rng)))
        joints.append(
            Joint(
                f"joint_{k}",
                str(rng.choice(names[-3:])) if k else WORLD,
                name,
                motions,
                _coordinates(k, motions, damping),
                _pose(rng),
                _pose(rng),
            )
        )
        names.append(name)
    muscles = tuple(
        Muscle(
            f"muscle_{m}",
            tuple(ViaPoint(str(rng.choice(names)), vector(rng)) for _ in range(3)),
            0.0,
            100.0,
        )
        for m in range(4)
    )
    tasks = (
        TaskFrame("hand", names[-1], vector(rng)),
        TaskFrame("palm", names[-2] if count > 1 else names[-1], axes=("alpha", "beta", "gamma")),
    )
    return Robot(
        f"tree {seed}",
        tuple(links),
        tuple(joints),
        (CableSet("all", muscles),),
        "all",
        (TaskSet("both", tasks),),
        "both",
    )


def random_state(robot: Robot, rng: np.random.Generator) -> tuple[np.ndarray, ...]:
    """Return random q, qd and muscle forces."""
    n, m = len(robot.coordinates), len(robot.muscles)
    return rng.uniform(-1.2, 1.2, n), rng.uniform(-1.0, 1.0, n), rng.uniform(0.0, 100.0, m)


def _motions(rng: np.random.Generator, k: int) -> tuple[Motion, ...]:
    """Return motions about a random axis, of a CASPR joint, or (not for the first joint) none."""
    kind = rng.random()
    if kind < 0.3:
        return revolute(_unit(rng))
    if kind < 0.4:
        return prismatic(_unit(rng))
    if kind < 0.5 and k > 0:
        return ()
    words = [word for word in CASPR_JOINTS if word != "SPATIAL_EULER_XYZ"]
    return CASPR_JOINTS[str(rng.choice(words))].motions


def _coordinates(k: int, motions: tuple[Motion, ...], damping: float) -> tuple[Coordinate, ...]:
    ordered = sorted(motions, key=lambda motion: motion.coordinate)
    return tuple(
        Coordinate(f"q_{k}_{i}", unit=motion.unit, damping=damping)
        for i, motion in enumerate(ordered)
    )


def _unit(rng: np.random.Generator) -> tuple[float, float, float]:
    v = rng.normal(size=3)
    x, y, z = v / np.linalg.norm(v)
    return float(x), float(y), float(z)


def _pose(rng: np.random.Generator) -> Pose:
    return Pose(vector(rng), vector(rng, 3.0))


def _inertia(rng: np.random.Generator) -> Inertia:
    """Return physically possible mass properties."""
    a, b, c = (float(x) for x in rng.uniform(0.02, 0.2, 3))
    mass, ab = float(rng.uniform(0.5, 2.0)), float(rng.uniform(-0.01, 0.01))
    return Inertia(mass, vector(rng, 0.2), b + c, a + c, a + b, ab)


def random_robot(
    seed: int, joints: int = 6, muscles: int = 8, points: int = 4, *, sliding: bool = True
) -> Robot:
    """Return a random tree with branches, rotated frames, fixed joints and muscles."""
    rng = np.random.default_rng(seed)
    links, chain, movable = [], [], [WORLD]
    for k in range(joints + joints // 3):
        fixed = k >= joints
        parent = str(rng.choice(movable[-4:]))
        kind = prismatic(_unit(rng)) if sliding and rng.random() < 0.3 else revolute(_unit(rng))
        links.append(Link(f"link_{k}", _light_inertia(rng)))
        chain.append(
            Joint(
                f"joint_{k}",
                parent,
                f"link_{k}",
                () if fixed else kind,
                () if fixed else (Coordinate(f"joint_{k}", unit=kind[0].unit),),
                T_parent_joint=_pose(rng),
                T_child_joint=_pose(rng),
            )
        )
        movable.append(f"link_{k}")
    names = [WORLD, *(link.name for link in links)]
    cables = tuple(
        Muscle(
            f"muscle_{k}",
            tuple(ViaPoint(str(rng.choice(names)), vector(rng)) for _ in range(points)),
            5.0,
            200.0,
        )
        for k in range(muscles)
    )
    tasks = (
        TaskFrame("hand", links[joints - 1].name, vector(rng)),
        TaskFrame("elbow", links[joints // 2].name, vector(rng), ("z", "x")),
        TaskFrame("palm", links[joints - 1].name, axes=("alpha", "gamma", "beta")),
    )
    return Robot(
        f"random_{seed}",
        tuple(links),
        tuple(chain),
        (CableSet("all", cables),),
        "all",
        (TaskSet("both", tasks),),
        "both",
    )


def _light_inertia(rng: np.random.Generator) -> Inertia:
    a, b, c = rng.uniform(0.01, 0.1, 3)
    return Inertia(
        float(rng.uniform(0.2, 2.0)), vector(rng, 0.2), float(b + c), float(a + c), float(a + b)
    )
