"""Designs drawn by tests, as a user would have drawn them before the add-in runs.

A Builder works on plain data and hands out paths (tuples of OccurrenceData); `Builder.done()` gives
the API's Design of a new active document. Lengths in cm, angles in rad, masses in kg; poses are 4x4
arrays that lead from the own frame to that of the component above.
"""

from __future__ import annotations

import math
import random
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from .maths import frame, inverse, rotation, translation
from .model.data import (
    BodyData,
    ComponentData,
    DesignData,
    Freedom,
    GroupData,
    JointData,
    JointOriginData,
    Limits,
    MotionLinkData,
    OccurrenceData,
    Path,
    PointData,
    SketchData,
    SketchPointData,
    motion,
)
from .model.entity import unique, wrap
from .model.joint_motions import (
    BALL,
    CYLINDRICAL,
    INFERRED,
    PIN_SLOT,
    PLANAR,
    REVOLUTE,
    RIGID,
    SLIDER,
)
from .model.joints import relative
from .model.shapes import STEEL, Box, Cylinder, Explicit, Shape, Sphere, Torus, at
from .state import world

X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
KINDS = {
    "rigid": RIGID,
    "revolute": REVOLUTE,
    "slider": SLIDER,
    "cylindrical": CYLINDRICAL,
    "pin_slot": PIN_SLOT,
    "planar": PLANAR,
    "ball": BALL,
    "inferred": INFERRED,
}
FREEDOMS: dict[str, tuple[tuple[str, Any], ...]] = {
    "rigid": (),
    "revolute": (("rotation", Z),),
    "slider": (("slide", Z),),
    "cylindrical": (("rotation", Z), ("slide", Z)),
    "pin_slot": (("slide", X), ("rotation", Z)),
    "planar": (("primarySlide", X), ("secondarySlide", Y), ("rotation", Z)),
    "ball": (("pitch", Z), ("yaw", X), ("roll", Y)),
    "inferred": (),
}
"""Freedoms of a joint, in their order from `two` to `one`, with axes in the joint's frame."""

Pair = tuple[float | None, float | None]
_ASSEMBLY = 1


class Builder:
    """Draws one design.

    Args:
        name: Name of the design and of its root component.
        parametric: Whether it has a timeline; else it is direct modelling.
        intent: `part`, `assembly` or `hybrid`.
        units: The user's length unit, such as `mm`.
        ground_first: Fusion's preference by which the first component is grounded to its parent.

    Attributes:
        design: The design's data.
        root: The root component's data.
    """

    def __init__(
        self,
        name: str = "design",
        *,
        parametric: bool = True,
        intent: str = "hybrid",
        units: str = "mm",
        ground_first: bool = True,
    ) -> None:
        self.ground_first = ground_first
        self.design = DesignData(name, kind=int(parametric), units=units)
        self.design.intent = ("part", "assembly", "hybrid").index(intent)
        self.root = ComponentData(name, design=self.design)
        self.design.root = self.root
        self.design.components.append(self.root)
        self._counters: dict[int, int] = {}

    # Structure -------------------------------------------------------------------------------

    def component(self, name: str, *, referenced: bool = False) -> ComponentData:
        """A new component, in no place yet; its name is made unique as Fusion does.

        In an assembly design it is always of a document of its own.
        """
        name = unique(name, self.design.components)
        source = DesignData(name) if self.design.intent == _ASSEMBLY else None
        external = referenced or source is not None
        made = ComponentData(name, design=self.design, referenced=external, source=source)
        self.design.components.append(made)
        return made

    def place(
        self,
        component: ComponentData | str,
        T: Any = None,
        *,
        above: Path = (),
        grounded: bool = False,
        ground_to_parent: bool | None = None,
        visible: bool = True,
    ) -> Path:
        """Put a component (or a new one of that name) into another one.

        Args:
            component: What.
            T: Its pose in the component above.
            above: Path of an occurrence of the component above; the root if empty.
            grounded: Whether the user pinned it.
            ground_to_parent: Whether it is fixed to the component above; if None, as Fusion's
                preference has it: the first one of the root is, without a word.
            visible: Its light bulb.

        Returns:
            Its path below the given one.
        """
        if isinstance(component, str):
            component = self.component(component)
        parent = above[-1].component if above else self.root
        first = self.ground_first and parent is self.root and not self.root.occurrences
        number = self._counters[id(component)] = self._counters.get(id(component), 0) + 1
        made = OccurrenceData(
            f"{component.name}:{number}",
            component=component,
            parent=parent,
            T=np.eye(4) if T is None else np.array(T, dtype=float),
            grounded=grounded,
            ground_to_parent=first if ground_to_parent is None else ground_to_parent,
            light_bulb=visible,
        )
        parent.occurrences.append(made)
        return (*above, made)

    def unresolved(self, name: str, T: Any = None, *, above: Path = ()) -> Path:
        """An external reference whose document cannot be found."""
        component = ComponentData(name, design=self.design, referenced=True)
        parent = above[-1].component if above else self.root
        made = OccurrenceData(f"{name}:1", component=component, parent=parent, T=_pose(T))
        made.unresolved = True
        parent.occurrences.append(made)
        return (*above, made)

    def pose(self, path: Path, T: Any) -> None:
        """Another pose of a part of a sub-assembly, in this place of it alone.

        Args:
            path: Path from the root of the part.
            T: Its pose relative to what is above it.
        """
        self.root.poses[path] = np.array(T, dtype=float)

    def move(self, path: Path, T: Any) -> None:
        """The user has moved an occurrence to a pose, and not captured the position."""
        path[-1].captured, path[-1].T = path[-1].T, np.array(T, dtype=float)

    # Content ---------------------------------------------------------------------------------

    def body(
        self,
        where: ComponentData | Path,
        shape: Shape,
        name: str = "",
        *,
        kind: str = "solid",
        material: str = "Steel",
        visible: bool = True,
    ) -> BodyData:
        """A body of a shape in a component's frame."""
        component = self._component(where)
        shelf = component.mesh_bodies if kind == "mesh" else component.bodies
        made = BodyData(
            unique(name or f"Body{len(shelf) + 1}", shelf),
            component=component,
            shape=shape,
            kind=kind,
            material=material,
            light_bulb=visible,
        )
        shelf.append(made)
        return made

    def box(self, where: Any, size: Sequence[float], T: Any = None, **more: Any) -> BodyData:
        """A box about its pose's origin, in [cm]. `density` in [kg/cm³]; the rest as `body`."""
        density = more.pop("density", STEEL)
        return self.body(where, Box(_pose(T), density, tuple(size)), **more)  # type: ignore[arg-type]

    def cylinder(
        self, where: Any, radius: float, height: float, T: Any = None, **more: Any
    ) -> BodyData:
        """A cylinder about the z axis of its pose, from -height/2 to height/2."""
        density = more.pop("density", STEEL)
        return self.body(where, Cylinder(_pose(T), density, radius, height), **more)

    def sphere(self, where: Any, radius: float, T: Any = None, **more: Any) -> BodyData:
        """A sphere about its pose's origin."""
        density = more.pop("density", STEEL)
        return self.body(where, Sphere(_pose(T), density, radius), **more)

    def torus(self, where: Any, major: float, minor: float, T: Any = None, **more: Any) -> BodyData:
        """A torus about the z axis of its pose."""
        density = more.pop("density", STEEL)
        return self.body(where, Torus(_pose(T), density, major, minor), **more)

    def explicit(
        self,
        where: Any,
        mass: float,
        com: Sequence[float] = (0.0, 0.0, 0.0),
        inertia: Any = None,
        T: Any = None,
        *,
        size: Sequence[float] = (1.0, 1.0, 1.0),
        **more: Any,
    ) -> BodyData:
        """A box to look at with given mass properties.

        Args:
            where: Its component or a path to it.
            mass: In [kg].
            com: Centre of mass in the body's pose, in [cm].
            inertia: About the centre of mass along the pose's axes, tensor signs, in [kg·cm²].
            T: The body's pose in the component.
            size: Of the box, in [cm].
            more: As for `body`.
        """
        shape = Explicit(
            _pose(T),
            STEEL,
            tuple(size),  # type: ignore[arg-type]
            mass,
            tuple(com),  # type: ignore[arg-type]
            inertia,
        )
        return self.body(where, shape, **more)

    def point(
        self,
        where: ComponentData | Path,
        position: Sequence[float],
        name: str,
        attributes: dict[str, str] | None = None,
        *,
        problem: str = "",
        exact_name: bool = False,
    ) -> PointData:
        """A construction point in a component's frame, with attributes of the add-in's group."""
        component = self._component(where)
        made = PointData(
            name if exact_name else unique(name, component.points),
            component=component,
            position=np.array(position, dtype=float),
            attributes={("CARDSFlow", key): text for key, text in (attributes or {}).items()},
            problem=problem,
            health=2 if problem else 0,
        )
        component.points.append(made)
        return made

    def sketch(
        self,
        where: ComponentData | Path,
        T: Any = None,
        *,
        points: Iterable[Sequence[float]] = (),
        name: str = "",
    ) -> SketchData:
        """A sketch of the user's with points in its own frame."""
        component = self._component(where)
        made = SketchData(
            unique(name or f"Sketch{len(component.sketches) + 1}", component.sketches),
            component=component,
            T=_pose(T),
        )
        made.points += [
            SketchPointData("", sketch=made, position=np.array(p, dtype=float)) for p in points
        ]
        component.sketches.append(made)
        return made

    # Relations -------------------------------------------------------------------------------

    def rigid_group(
        self,
        name: str,
        members: Iterable[Path],
        *,
        inside: Path = (),
        suppressed: bool = False,
        stale: bool = False,
    ) -> GroupData:
        """A rigid group of occurrences, in the root or in the component at the end of `inside`.

        A stale one is left over from occurrences that are gone.
        """
        component = self._component(inside)
        made = GroupData(
            unique(name, component.groups),
            component=component,
            members=[m[len(inside) :] for m in members],
            suppressed=suppressed,
            stale=stale,
        )
        component.groups.append(made)
        return made

    def joint_origin(self, where: ComponentData | Path, T: Any, name: str = "") -> JointOriginData:
        """A joint origin at a pose in a component's frame."""
        component = self._component(where)
        name = unique(
            name or f"Joint Origin{len(component.joint_origins) + 1}", component.joint_origins
        )
        made = JointOriginData(name, component=component, T=np.array(T, dtype=float))
        component.joint_origins.append(made)
        return made

    def joint(
        self,
        name: str,
        kind: str,
        one: Path,
        two: Path,
        origin: Sequence[float] = (0.0, 0.0, 0.0),
        axis: Sequence[float] = Z,
        x: Sequence[float] | None = None,
        *,
        T: Any = None,
        values: Sequence[float] = (),
        limits: Sequence[Pair] = (),
        inside: Path = (),
        as_built: bool = False,
        by_origins: bool = False,
        **more: Any,
    ) -> JointData:
        """A joint between two occurrences at their pose.

        Args:
            name: Its name.
            kind: As in KINDS.
            one: Path from the root of what moves; empty for the component that the joint is in.
            two: Path from the root of what it moves relative to; likewise.
            origin: Where it is on `two`, in the frame of the joint's component, in [cm].
            axis: Its z axis there: the axis of most joints, the pitch axis of a ball joint.
            x: Its x axis there.
            T: Its pose there, instead of the three.
            values: Its values, one a freedom in the order of FREEDOMS.
            limits: (lower, upper), None if not enabled, one a freedom.
            inside: Path of the occurrence whose component holds the joint.
            as_built: Whether it is an as-built joint.
            by_origins: Whether joint origins define it, in the components of `one` and `two`.
            more: Further fields of JointData, such as suppressed, locked, health, problem,
                broken_geometry, axes (of the freedoms, in the joint's frame), offsets (x, y, z),
                angle, flipped.
        """
        component = self._component(inside)
        one, two = one[len(inside) :], two[len(inside) :]
        axes = more.pop("axes", None)
        freedoms = _freedoms(kind, axes, values, limits)
        T = frame(origin, axis, x) if T is None else np.array(T, dtype=float)
        shelf = component.as_built if as_built else component.joints
        made = JointData(
            unique(name, shelf),
            component=component,
            kind="as-built" if as_built else "joint",
            type=KINDS[kind],
            one=one,
            two=two,
            T_one=inverse(relative(inside, one)) @ T @ _rest(more) @ motion(freedoms) @ _flip(more),
            T_two=inverse(relative(inside, two)) @ T,
            freedoms=freedoms,
            **more,
        )
        if by_origins:
            for side, path in (("one", one), ("two", two)):
                where = path[-1].component if path else component
                origin_of = self.joint_origin(where, getattr(made, f"T_{side}"))
                setattr(made, f"origin_{side}", origin_of)
        shelf.append(made)
        return made

    def constraint(self, name: str = "Constraint1", *, inside: Path = ()) -> None:
        """An assembly constraint; allJoints fails from now on, as where Fusion has them."""
        self._component(inside).constraints.append(name)
        world().options.all_joints_fail = True

    def motion_link(
        self, one: JointData, two: JointData | None = None, *, name: str = "", **more: Any
    ) -> MotionLinkData:
        """A motion link between two joints of a component, or two motions of one.

        Args:
            one: The first joint.
            two: The second; None: the same.
            name: Its name.
            more: Further fields of MotionLinkData: motions, values, reversed, suppressed.
        """
        shelf = one.component.motion_links
        name = unique(name or f"Motion Link{len(shelf) + 1}", shelf)
        made = MotionLinkData(name, component=one.component, joint_one=one, joint_two=two, **more)
        shelf.append(made)
        return made

    def tangent(self, name: str = "Tangent1", *, inside: Path = ()) -> None:
        """A tangent relationship between faces."""
        self._component(inside).tangents.append(name)

    # End -------------------------------------------------------------------------------------

    def shuffle(self, order: random.Random) -> None:
        """Change the order in which everything was made."""
        for component in self.design.components:
            for shelf in ("occurrences", "bodies", "points", "joints", "as_built", "groups"):
                order.shuffle(getattr(component, shelf))
        others = self.design.components[1:]
        order.shuffle(others)
        self.design.components[1:] = others

    def done(self) -> Any:
        """Open the design as the active document and give it as the API does."""
        if self.design not in world().documents:
            world().documents.append(self.design)
        world().active = self.design
        return wrap(self.design)

    def _component(self, where: ComponentData | Path) -> ComponentData:
        if isinstance(where, ComponentData):
            return where
        return where[-1].component if where else self.root


def _rest(more: dict[str, Any]) -> np.ndarray:
    """Where `one` is in the joint's frame of `two` at zero: the joint's offsets and angle."""
    T = translation(more.get("offsets", (0.0, 0.0, 0.0)))
    return T @ rotation(more.get("angle", 0.0), Z)


def _flip(more: dict[str, Any]) -> np.ndarray:
    """A flipped joint's frame on `one` is upside down."""
    return rotation(math.pi, X) if more.get("flipped") else np.eye(4)


def _pose(T: Any) -> np.ndarray:
    if T is None:
        return np.eye(4)
    T = np.array(T, dtype=float)
    return at(T) if T.shape == (3,) else T


def _freedoms(
    kind: str, axes: Any, values: Sequence[float], limits: Sequence[Pair]
) -> list[Freedom]:
    made = []
    for i, (role, axis) in enumerate(FREEDOMS[kind]):
        lower, upper = limits[i] if i < len(limits) else (None, None)
        bounds = Limits(
            lower or 0.0,
            upper or 0.0,
            has_minimum=lower is not None,
            has_maximum=upper is not None,
        )
        axis = axes[i] if axes is not None else axis
        value = values[i] if i < len(values) else 0.0
        made.append(Freedom(role, tuple(axis), float(value), bounds))
    return made
