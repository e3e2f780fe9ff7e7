"""Reader of muscles and task frames in cardsflow.xml and in the SDF plugin."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Literal, cast, get_args

from ...finding import member
from ...finding_builders import unknown
from ...model.muscle import (
    PRESLIDING,
    BasePulley,
    CableKind,
    CableModel,
    CableSet,
    Muscle,
    PulleyKind,
    Quadrant,
    ViaPoint,
    Wrap,
    WrapRule,
    WrapShape,
    WrapSurface,
)
from ...model.muscle_path import Branch, CoordinateTerm, PointCondition, PointMotion
from ...model.pose import Pose, Vector3
from ...model.robot import ANGLES, WORLD, Axis, TaskFrame, TaskSet
from ..reading.actuator import read_actuator
from ..reading.functions import read_function
from ..reading.unique_names import with_unique_names
from ..reading.xml import Node, short_repr
from .wraps import WRAP_TYPES
from .write import INSIDE, WRAP_STATES

SHAPES = {word: cast(WrapShape, shape) for shape, word in WRAP_TYPES.items()}
SIDES: dict[str, Literal[-1, 0, 1]] = {"-1": -1, "0": 0, "1": 1}


@dataclass(frozen=True)
class _Step:
    """Via point element: a via point, or a surface to wrap over."""

    node: Node
    link: str
    position: Vector3
    shape: WrapShape | None


class MuscleReader:
    """Reader of muscles, which also collects the wrap surfaces on their paths."""

    def __init__(self, links: Sequence[str], surfaces: Sequence[WrapSurface] = ()) -> None:
        self.surfaces = list(surfaces)
        self._links = [WORLD, *links]
        self._link_names = set(self._links)
        folded = Counter(name.casefold() for name in self._links)
        self._folded = {n.casefold(): n for n in self._links if folded[n.casefold()] == 1}
        self._names: dict[WrapSurface, list[str]] = {}
        self._used_names = {surface.name for surface in surfaces}
        self._copies: Counter[str] = Counter()
        for surface in surfaces:
            self._names.setdefault(_without_name(surface), []).append(surface.name)

    def cable_set(self, parent: Node, name: str, active: str) -> CableSet:
        """Return the `<myoMuscle>` children of an element as a cable set."""
        muscles = []
        nodes = with_unique_names(
            parent.all("myoMuscle"), partial(member, "muscle", of=name, active=active)
        )
        for node in nodes:
            subject = member("muscle", node.attribute("name"), name, active)
            muscles.append(self._muscle(node.with_subject(subject)))
        return CableSet(name, tuple(muscles))

    def _muscle(self, node: Node) -> Muscle:
        steps = [step for block in node.all("link") for step in self._steps(block)]
        points = [
            ViaPoint(
                step.link,
                step.position,
                _condition(step.node),
                tuple(_moves(step.node)),
                _local_friction(step.node),
            )
            for step in steps
            if step.shape is None
        ]
        return Muscle(
            node.attribute("name"),
            tuple(points),
            node.number_attribute("f_min", 0.0),
            node.number_attribute("f_max", math.inf, infinite=True),
            read_actuator(node) or _cable_model(node),
            _base_pulley(node),
            (*self._path_wraps(steps), *_wraps(node)),
            tuple(
                Branch(_integer(branch, "point"), branch.number_attribute("divisor", 1.0))
                for branch in node.all("branch")
            ),
            tuple(
                CoordinateTerm(term.attribute("coordinate"), term.number_attribute("factor"))
                for term in node.all("term")
            ),
            node.number_attribute("friction", 0.0),
            node.number_attribute("presliding", PRESLIDING),
        )

    def _steps(self, block: Node) -> Iterator[_Step]:
        link = block.attribute("name")
        if block.has("name") and link not in self._link_names:
            nearest = self._folded.get(link.casefold())
            if nearest is None:
                problem = f"via point on {unknown('link', link, self._links)}"
                block.error("unknown-via-link", problem)
            else:
                problem = f"unknown link {link!r}; link {nearest!r} is used instead"
                block.warning("link-name-case", problem)
                link = nearest
        for node in block.all("viaPoint"):
            kind = node.attribute("type")
            if node.has("type") and kind != "FIXPOINT" and kind not in SHAPES:
                problem = f"unknown via point type {short_repr(kind)}"
                node.error("unsupported-via-point", problem, ("FIXPOINT", *SHAPES))
            yield _Step(node, link, node.vector3(), SHAPES.get(kind))

    def _path_wraps(self, steps: Sequence[_Step]) -> Iterator[Wrap]:
        passed = -1
        ends = [None, *(step.shape for step in steps), None]
        outside = [True, *[False] * len(steps), True]
        for i, step in enumerate(steps):
            if step.shape is None:
                passed += 1
                continue
            surface = self._surface(step, step.shape)
            if ends[i] or ends[i + 2] or outside[i] or outside[i + 2]:
                problem = "a wrap must be between two via points of type FIXPOINT"
                step.node.error("wrap-not-between-points", problem)
            side, turns = _state(step.node)
            friction = _local_friction(step.node)
            inside = _is_inside(step.node)
            yield Wrap(surface, max(passed, 0), side, turns, inside, friction=friction)

    def _surface(self, step: _Step, shape: WrapShape) -> str:
        """Return the name of the surface at a via point; equal surfaces share one name."""
        node = step.node
        radius = node.number_attribute("radius")
        length = node.number_attribute("length", math.inf, infinite=True)
        new = WrapSurface("", step.link, shape, radius, Pose(step.position), length)
        named = node.attribute("surface", "")
        names = self._names.setdefault(new, [])
        if names and named in ("", *names):
            return named or names[0]
        names.append(named or self._free_name(f"{step.link}_{shape}"))
        self._used_names.add(names[-1])
        self.surfaces.append(replace(new, name=names[-1]))
        return names[-1]

    def _free_name(self, base: str) -> str:
        """Return the base name, or the base name with the first number that makes it unique."""
        name = base
        while name in self._used_names:
            self._copies[base] += 1
            name = f"{base}_{self._copies[base] + 1}"
        return name


def read_surface(node: Node) -> WrapSurface:
    """Return a `<wrap_surface>` element of the plugin."""
    shape = _required_word(node, "shape", get_args(WrapShape), "unsupported-wrap-shape")
    x, y, z, *angles = node.numbers(6)
    roll, pitch, yaw = angles
    return WrapSurface(
        node.attribute("name"),
        node.attribute("link"),
        cast(WrapShape, shape),
        node.number_attribute("radius"),
        Pose((x, y, z), (roll, pitch, yaw)),
        node.number_attribute("length", math.inf, infinite=True),
        _pair(node.numbers_attribute("half_axes", 2)) if node.has("half_axes") else None,
    )


def _pair(values: Sequence[float]) -> tuple[float, float]:
    first, second = values
    return first, second


def read_task_set(parent: Node, name: str, active: str, tag: str = "endEffector") -> TaskSet:
    """Return the `<endEffector>` or `<marker>` children of an element as a task set."""
    frames = []
    nodes = with_unique_names(
        parent.all(tag), partial(member, "task_frame", of=name, active=active)
    )
    for i, node in enumerate(nodes):
        called = node.attribute("name", f"{tag.lower()}{i}")
        subject = member("task_frame", called, name, active)
        frames.append(_task_frame(node.with_subject(subject), called))
    return TaskSet(name, tuple(frames))


def _task_frame(node: Node, name: str) -> TaskFrame:
    words = node.attribute("axes", "xyz").split()
    axes = [axis for word in words for axis in ([word] if word in ANGLES else word)]
    chosen = tuple(cast(Axis, axis) for axis in axes)
    return TaskFrame(name, node.attribute("link"), node.vector3(), chosen)


def _without_name(surface: WrapSurface) -> WrapSurface:
    """Return the surface without its name and, for a sphere, without its rotation."""
    pose = Pose(surface.pose.position) if surface.shape == "sphere" else surface.pose
    return replace(surface, name="", pose=pose)


def _state(node: Node) -> tuple[Literal[-1, 0, 1], int]:
    """Return the side and the turns of a wrap; states 0 and 1 mean the shorter path."""
    state = node.attribute("state", WRAP_STATES[0])
    if state not in WRAP_STATES:
        node.error("bad-number", f"state {short_repr(state)} must be 0, 1 or 2")
    if state == WRAP_STATES[2] and not node.has("side"):
        problem = "state 2, the longer path, is read as the shorter path; add side=1 or side=-1"
        node.warning("wrap-state-left", f"{problem}, the sense of rotation about the z axis")
    return _side(node), _integer(node, "revCounter")


def _side(node: Node) -> Literal[-1, 0, 1]:
    """Return the side of a wrap; 0 also for a wrap inside its surface."""
    side = node.attribute("side", "0")
    if side not in SIDES and side != INSIDE:
        node.error("bad-number", f"side {short_repr(side)} must be -1, 0, 1 or {INSIDE}")
    return SIDES.get(side, 0)


def _is_inside(node: Node) -> bool:
    return node.attribute("side", "0") == INSIDE


def _wraps(node: Node) -> Iterator[Wrap]:
    for wrap in node.all("wrap"):
        segment, turns = _integer(wrap, "segment"), _integer(wrap, "turns")
        rule = _known_word(wrap, "rule", get_args(WrapRule))
        yield Wrap(
            wrap.attribute("surface"),
            segment,
            _side(wrap),
            turns,
            _is_inside(wrap),
            cast(WrapRule, rule),
            _side_point(wrap),
            cast(Quadrant, _known_word(wrap, "quadrant", get_args(Quadrant))),
            _integer(wrap, "last_segment") if wrap.has("last_segment") else None,
            _local_friction(wrap),
        )


def _local_friction(node: Node) -> float | None:
    return node.number_attribute("friction") if node.has("friction") else None


def _known_word(node: Node, name: str, allowed: tuple[str, ...], code: str = "bad-word") -> str:
    """Return the word in an attribute; the first known word if the attribute is not set."""
    word = node.attribute(name, allowed[0])
    if word not in allowed:
        node.error(code, f"unknown {name} {short_repr(word)}", allowed)
        return allowed[0]
    return word


def _required_word(node: Node, name: str, allowed: tuple[str, ...], code: str) -> str:
    node.attribute(name)  # reports a missing one
    return _known_word(node, name, allowed, code)


def _side_point(node: Node) -> ViaPoint | None:
    if not node.has("side_link"):
        return None
    x, y, z = node.numbers_attribute("side_position", 3)
    return ViaPoint(node.attribute("side_link"), (x, y, z))


def _condition(node: Node) -> PointCondition | None:
    if not node.has("coordinate"):
        return None
    low, high = (node.number_attribute(name, infinite=True) for name in ("low", "high"))
    smoothing = node.number_attribute("smoothing", 0.0)
    return PointCondition(node.attribute("coordinate"), low, high, smoothing)


def _moves(node: Node) -> Iterator[PointMotion]:
    for move in node.all("move"):
        low = move.number_attribute("low", -math.inf, infinite=True)
        high = move.number_attribute("high", math.inf, infinite=True)
        axis, coordinate = move.vector_attribute("axis"), move.attribute("coordinate")
        yield PointMotion(axis, coordinate, read_function(move), low, high)


def _integer(node: Node, name: str) -> int:
    value = node.number_attribute(name, 0.0)
    if value != int(value) or abs(value) > 2**31:
        node.error("bad-number", f"{name} {value!r} is not an integer")
        return 0
    return int(value)


def _cable_model(node: Node) -> CableModel:
    child = node.optional("cable_model")
    if child is None:
        return CableModel()
    kind = _required_word(child, "kind", get_args(CableKind), "unsupported-cable")
    rows = [(name, values[0]) for name, values in _parameters(child) if len(values) == 1]
    return CableModel(kind, tuple(rows))


def _base_pulley(node: Node) -> BasePulley | None:
    child = node.optional("base_pulley")
    if child is None:
        return None
    kind = _required_word(child, "kind", get_args(PulleyKind), "unsupported-pulley")
    return BasePulley(cast(PulleyKind, kind), tuple(_parameters(child)))


def _parameters(node: Node) -> Iterator[tuple[str, tuple[float, ...]]]:
    for child in node.all("parameter"):
        yield child.attribute("name"), child.numbers(len(child.text.split()))
