"""Builder of designs for tests, which simulates designs drawn by a user.

A Builder uses plain data and returns paths (tuples of OccurrenceData); `Builder.done()` returns
the API Design of a new active document. Lengths are in cm, angles in rad, masses in kg. A pose is a
4x4 array that transforms the frame of a component to the frame of its parent.
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
"""Degrees of freedom of joints, ordered from `two` to `one`, with axes in the joint frame."""

Pair = tuple[float | None, float | None]
_ASSEMBLY = 1


class Builder:
    """Builder of one design.

    Args:
        name: Name of the design and of its root component.
        parametric: Whether the design has a timeline; otherwise it uses direct modelling.
        intent: `part`, `assembly` or `hybrid`.
        units: Length unit of the user, such as `mm`.
        ground_first: Preference of Fusion to ground the first component to its parent.

    Attributes:
        design: Data of the design.
        root: Data of the root component.
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
        """Create a component without occurrences; a duplicate name gets a suffix like in Fusion.

        In an assembly design each component belongs to a separate document.
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
        """Create an occurrence of a component.

        Args:
            component: The component, or the name of a new component.
            T: Pose in the parent component.
            above: Path of an occurrence of the parent component; empty for the root.
            grounded: Whether the user grounded it.
            ground_to_parent: Whether it is fixed to its parent; None to follow the preference of
                Fusion, which grounds the first component of the root.
            visible: Whether it is visible.

        Returns:
            Path of the occurrence.
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
        """Create an unresolved external reference."""
        component = ComponentData(name, design=self.design, referenced=True)
        parent = above[-1].component if above else self.root
        made = OccurrenceData(f"{name}:1", component=component, parent=parent, T=_pose(T))
        made.unresolved = True
        parent.occurrences.append(made)
        return (*above, made)

    def pose(self, path: Path, T: Any) -> None:
        """Set the pose of a part in one occurrence of a sub-assembly only.

        Args:
            path: Path of the part from the root.
            T: Pose relative to its parent.
        """
        self.root.poses[path] = np.array(T, dtype=float)

    def move(self, path: Path, T: Any) -> None:
        """Move an occurrence to a pose without capturing the position."""
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
        """Add a body with a shape in the frame of a component."""
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
        """Add a box centred at its pose, in [cm]; density in [kg/cm³], `more` as for `body`."""
        density = more.pop("density", STEEL)
        return self.body(where, Box(_pose(T), density, tuple(size)), **more)  # type: ignore[arg-type]

    def cylinder(
        self, where: Any, radius: float, height: float, T: Any = None, **more: Any
    ) -> BodyData:
        """Add a cylinder about the z axis of its pose, from -height/2 to height/2."""
        density = more.pop("density", STEEL)
        return self.body(where, Cylinder(_pose(T), density, radius, height), **more)

    def sphere(self, where: Any, radius: float, T: Any = None, **more: Any) -> BodyData:
        """Add a sphere centred at its pose."""
        density = more.pop("density", STEEL)
        return self.body(where, Sphere(_pose(T), density, radius), **more)

    def torus(self, where: Any, major: float, minor: float, T: Any = None, **more: Any) -> BodyData:
        """Add a torus about the z axis of its pose."""
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
        """Add a box with given mass properties.

        Args:
            where: Component or path of an occurrence.
            mass: In [kg].
            com: Centre of mass in the frame of the body, in [cm].
            inertia: Inertia matrix about the centre of mass, tensor signs, in [kg·cm²].
            T: Pose of the body in the component.
            size: Size of the box, in [cm].
            more: Arguments of `body`.
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
        """Add a construction point in the frame of a component, with attributes of the add-in."""
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
        """Add a sketch of the user with points in the frame of the sketch."""
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
        """Add a rigid group of occurrences to the root or to the component of `inside`.

        A stale group has lost its occurrences.
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
        """Add a joint origin at a pose in the frame of a component."""
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
        """Add a joint between two occurrences at their pose.

        Args:
            name: Name of the joint.
            kind: Key of KINDS.
            one: Path of the moving occurrence; empty for the component of the joint.
            two: Path of the other occurrence; empty for the component of the joint.
            origin: Position on `two`, in the frame of the joint's component, in [cm].
            axis: z axis on `two`: the axis of most joints, the pitch axis of a ball joint.
            x: x axis on `two`.
            T: Pose on `two`, instead of origin, axis and x.
            values: Values of the degrees of freedom, in the order of FREEDOMS.
            limits: (lower, upper) of each degree of freedom; None if not enabled.
            inside: Path of the occurrence whose component contains the joint.
            as_built: Whether it is an as-built joint.
            by_origins: Whether joint origins define it, in the components of `one` and `two`.
            more: Other fields of JointData, such as suppressed, locked, health, problem,
                broken_geometry, axes (in the joint frame), offsets (x, y, z), angle, flipped.
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
        """Add an assembly constraint; allJoints then fails like in Fusion."""
        self._component(inside).constraints.append(name)
        world().options.all_joints_fail = True

    def motion_link(
        self, one: JointData, two: JointData | None = None, *, name: str = "", **more: Any
    ) -> MotionLinkData:
        """Add a motion link between two joints of a component, or two motions of one joint.

        Args:
            one: First joint.
            two: Second joint; None for the same joint.
            name: Name of the motion link.
            more: Other fields of MotionLinkData: motions, values, reversed, suppressed.
        """
        shelf = one.component.motion_links
        name = unique(name or f"Motion Link{len(shelf) + 1}", shelf)
        made = MotionLinkData(name, component=one.component, joint_one=one, joint_two=two, **more)
        shelf.append(made)
        return made

    def tangent(self, name: str = "Tangent1", *, inside: Path = ()) -> None:
        """Add a tangent relationship between faces."""
        self._component(inside).tangents.append(name)

    # End -------------------------------------------------------------------------------------

    def shuffle(self, order: random.Random) -> None:
        """Shuffle the order of creation."""
        for component in self.design.components:
            for shelf in ("occurrences", "bodies", "points", "joints", "as_built", "groups"):
                order.shuffle(getattr(component, shelf))
        others = self.design.components[1:]
        order.shuffle(others)
        self.design.components[1:] = others

    def done(self) -> Any:
        """Open the design as the active document and return the API Design."""
        if self.design not in world().documents:
            world().documents.append(self.design)
        world().active = self.design
        return wrap(self.design)

    def _component(self, where: ComponentData | Path) -> ComponentData:
        if isinstance(where, ComponentData):
            return where
        return where[-1].component if where else self.root


def _rest(more: dict[str, Any]) -> np.ndarray:
    """Return the frame on `one` in the frame on `two` at zero values: offsets and angle."""
    T = translation(more.get("offsets", (0.0, 0.0, 0.0)))
    return T @ rotation(more.get("angle", 0.0), Z)


def _flip(more: dict[str, Any]) -> np.ndarray:
    """Return the rotation of the frame on `one` for a flipped joint."""
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
