"""What a robot is: links, joints, cables, task frames. Plain, frozen, standard library only.

Conventions: SI units. Every link has a frame; joints, via points, centres of mass and task points
are given in link frames. The robot is a tree: every link is the child of exactly one joint, and the
root of the tree is `WORLD`. Joints are listed parents first; that order is the order of the
coordinates q.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal, TypeVar

from .errors import UnknownNameError
from .joint import Coordinate, Joint
from .placement import Vector3

Axis = Literal["x", "y", "z"]

WORLD = "world"
"""The name of the fixed frame, usable wherever a link is named as parent or for a via point."""

GRAVITY: Vector3 = (0.0, 0.0, -9.81)
"""Gravity unless a robot says otherwise, in [m/s²]: CASPR's value, z up."""


@dataclass(frozen=True, slots=True)
class Inertia:
    """Mass, centre of mass and inertia matrix of a link.

    Attributes:
        mass: In [kg].
        com: Centre of mass in the link frame, in [m].
        ixx, iyy, izz, ixy, ixz, iyz: Entries of the inertia matrix about the centre of mass, along
            the axes of the link frame, in [kg·m²]. Off-diagonal entries carry the matrix' sign:
            ixy = -∫ x y dm.
    """

    mass: float
    com: Vector3 = (0.0, 0.0, 0.0)
    ixx: float = 0.0
    iyy: float = 0.0
    izz: float = 0.0
    ixy: float = 0.0
    ixz: float = 0.0
    iyz: float = 0.0

    @property
    def matrix(self) -> tuple[Vector3, Vector3, Vector3]:
        """The symmetric inertia matrix, row by row, in [kg·m²]."""
        return (
            (self.ixx, self.ixy, self.ixz),
            (self.ixy, self.iyy, self.iyz),
            (self.ixz, self.iyz, self.izz),
        )


@dataclass(frozen=True, slots=True)
class Link:
    """A rigid body.

    Attributes:
        name: Its name, unique among the links.
        inertia: Mass properties.
        end: The far end in the link frame, in [m]; for drawing only, None where unknown.
    """

    name: str
    inertia: Inertia
    end: Vector3 | None = None


@dataclass(frozen=True, slots=True)
class ViaPoint:
    """A point that a muscle passes through.

    Attributes:
        link: The link it is fixed to, or `WORLD`.
        position: In that link's frame, in [m].
    """

    link: str
    position: Vector3


@dataclass(frozen=True, slots=True)
class Muscle:
    """A cable that pulls along straight segments through its via points.

    Attributes:
        name: Its name, unique in its cable set.
        via_points: At least two, in order.
        f_min: Smallest force that a controller may command, in [N].
        f_max: Largest force, in [N]; infinite where unknown.
    """

    name: str
    via_points: tuple[ViaPoint, ...]
    f_min: float = 0.0
    f_max: float = math.inf


@dataclass(frozen=True, slots=True)
class CableSet:
    """A named, complete set of muscles; a robot has one or more and uses one at a time."""

    name: str
    muscles: tuple[Muscle, ...]


@dataclass(frozen=True, slots=True)
class TaskFrame:
    """A point on a link whose position is controlled or reported.

    Attributes:
        name: Its name, unique in its task set.
        link: The link it is fixed to.
        position: In that link's frame, in [m].
        axes: The world axes that count, in order.
    """

    name: str
    link: str
    position: Vector3
    axes: tuple[Axis, ...] = ("x", "y", "z")


@dataclass(frozen=True, slots=True)
class TaskSet:
    """A named operational space: the task coordinates y are its frames' axes, in order."""

    name: str
    frames: tuple[TaskFrame, ...]


_Named = TypeVar("_Named", Link, Joint, Coordinate, Muscle, CableSet, TaskSet)


def find(kind: str, name: str, items: Sequence[_Named]) -> _Named:
    """The item of that name.

    Args:
        kind: What is looked for, for the message.
        name: The name.
        items: Where to look.

    Raises:
        UnknownNameError: There is none; the message names the nearest and lists all.
    """
    for item in items:
        if item.name == name:
            return item
    raise UnknownNameError(kind, name, [item.name for item in items])


@dataclass(frozen=True)
class Robot:
    """A tree of links with muscles.

    The description does not judge itself: `check(robot)` tells what is wrong with it.

    Attributes:
        name: Its name.
        links: In any order.
        joints: Parents first.
        cable_sets: The alternatives; may be empty.
        cable_set: Name of the active one; empty if there is none.
        task_sets: Operational spaces; may be empty.
        task_set: Name of the active one; empty if there is none.
        gravity: In the world frame, in [m/s²].
    """

    name: str
    links: tuple[Link, ...]
    joints: tuple[Joint, ...]
    cable_sets: tuple[CableSet, ...] = ()
    cable_set: str = ""
    task_sets: tuple[TaskSet, ...] = ()
    task_set: str = ""
    gravity: Vector3 = field(default=GRAVITY)

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """The coordinates in the order of q."""
        return tuple(c for joint in self.joints for c in joint.coordinates)

    @property
    def muscles(self) -> tuple[Muscle, ...]:
        """The muscles of the active cable set, in the order of f."""
        if not self.cable_set:
            return ()
        return find("cable set", self.cable_set, self.cable_sets).muscles

    @property
    def task_frames(self) -> tuple[TaskFrame, ...]:
        """The frames of the active operational space, in the order of y."""
        if not self.task_set:
            return ()
        return find("operational space", self.task_set, self.task_sets).frames

    def link(self, name: str) -> Link:
        """The link of that name; UnknownNameError if there is none."""
        return find("link", name, self.links)

    def joint(self, name: str) -> Joint:
        """The joint of that name; UnknownNameError if there is none."""
        return find("joint", name, self.joints)

    def muscle(self, name: str) -> Muscle:
        """The active muscle of that name; UnknownNameError if there is none."""
        return find("muscle", name, self.muscles)

    def with_cable_set(self, name: str) -> Robot:
        """The same robot with another cable set active; UnknownNameError if there is none."""
        return replace(self, cable_set=find("cable set", name, self.cable_sets).name)

    def with_muscles(self, muscles: Iterable[Muscle]) -> Robot:
        """The same robot with the muscles of the active cable set replaced."""
        changed = CableSet(self.cable_set, tuple(muscles))
        sets = tuple(changed if s.name == self.cable_set else s for s in self.cable_sets)
        return replace(self, cable_sets=sets)
