"""A design that is drawn with build123d, with its muscles: what a program leaves for the import."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

from addin_sdfusion.muscles.table import COLORS
from addin_sdfusion.records import from_plain, to_plain
from addin_sdfusion.robot import InputError, Vector3
from addin_sdfusion.robot.model.transform import IDENTITY, Transform
from addin_sdfusion.settings import ExportSettings
from addin_sdfusion.snapshot import (
    F_MAX,
    F_MIN,
    ROOT,
    DesignSnapshot,
    JointSnapshot,
    MuscleSnapshot,
    PointSnapshot,
    PointUse,
    SourceSnapshot,
    SurfaceSnapshot,
    SurfaceUse,
    WrapUse,
)

from .assembly import Assembly, Material, Part, Place
from .build123d_joints import joint_record
from .kernel import MILLIMETRE, Face, face_of, kernel, transform

_DYNAMICS = ("damping", "friction", "stiffness", "rest", "effort")


@dataclass(frozen=True)
class _Spot:
    """A point on a part: in the part's frame, in [m]; in the root's without a part."""

    part: Any
    position: Vector3


class Design:
    """An assembly of build123d with muscles, task points and what joints are like.

    Parts are links where joints connect them, `a.connect_to(b)`; a part that is never the second
    one stands still. A point is a joint, as a name for a place, or a pair: of a part and a point in
    its coordinates, or one of its faces, edges or vertices; of None and a point of the world.

    Attributes:
        settings: How it becomes a robot's folder.
    """

    def __init__(
        self,
        assembly: Any,
        *,
        density: float | None = None,
        unit: float = MILLIMETRE,
        **settings: Any,
    ) -> None:
        """A design of an assembly.

        Args:
            assembly: A Compound with children, a part, or a list of parts, with labels.
            density: Of parts without a material, in [kg/m³]; None: they weigh nothing.
            unit: What one unit of length of the drawing is, in [m].
            settings: Of the export, by their names in ExportSettings.

        Raises:
            InputError: A setting is wrong.
        """
        self.settings = from_plain(ExportSettings, settings, "settings")
        self._assembly = assembly
        self._density = None if density is None else float(density)
        self._unit = float(unit)
        self._muscles: dict[str, MuscleSnapshot] = {}
        self._points: list[tuple[str, _Spot, PointUse]] = []
        self._surfaces: dict[str, tuple[Any, Face, SurfaceUse]] = {}
        self._dynamics: dict[int, dict[str, float]] = {}

    def muscle(
        self,
        name: str,
        *points: Any,
        f_min: float = F_MIN,
        f_max: float = F_MAX,
        color: str | None = None,
        model: str = "ideal",
        parameters: Mapping[str, float] | None = None,
    ) -> None:
        """Add a muscle.

        Args:
            name: Its name.
            points: Its via points, in order.
            f_min: Smallest force that a controller may command, in [N].
            f_max: Largest force, in [N].
            color: As `#rrggbb`; one of ten in turn if None.
            model: A law of tension.
            parameters: Of the law, in SI units.

        Raises:
            InputError: There is a muscle of that name, or an argument is wrong.
        """
        where = f"muscle {name!r}"
        if name in self._muscles:
            raise InputError(f"{where} is there already")
        plain = {
            "name": name,
            "color": color or COLORS[len(self._muscles) % len(COLORS)],
            "f_min": to_plain(float(f_min)),
            "f_max": to_plain(float(f_max)),
            "model": model,
            "parameters": {key: float(value) for key, value in (parameters or {}).items()},
        }
        self._muscles[name] = from_plain(MuscleSnapshot, plain, where)
        for number, point in enumerate(points, start=1):
            use = PointUse("via", muscle=name, number=number)
            self._add(f"{name}_{number}", point, use, f"{where}, point {number}")

    def task(self, name: str, point: Any, axes: Iterable[str] = ("x", "y", "z")) -> None:
        """Add a point whose position is controlled or reported.

        Args:
            name: Its name.
            point: Where it is.
            axes: Which coordinates count, such as "xz", in the world.

        Raises:
            InputError: An argument is wrong.
        """
        plain = {"role": "task", "name": name, "axes": list(axes)}
        use = from_plain(PointUse, plain, f"task point {name!r}")
        self._add(name, point, use, f"task point {name!r}")

    def marker(self, name: str, point: Any) -> None:
        """Add a point that is only looked at; arguments and errors as of `task`."""
        self._add(name, point, PointUse("marker", name=name), f"marker {name!r}")

    def wrap(
        self,
        name: str,
        part: Any,
        face: Any,
        muscle: str,
        after: int,
        *,
        side: Literal[-1, 0, 1] = 0,
        turns: int = 0,
        inside: bool = False,
    ) -> None:
        """Let a muscle wrap over a cylinder or sphere face.

        Args:
            name: Of the surface; the same for all muscles that wrap over it.
            part: What the face is of.
            face: One of `part.faces()`.
            muscle: Name of the muscle.
            after: Number of the via point before the surface, counted from 1.
            side: 1 or -1 for a chosen sense of turning about the axis, 0 for the shorter path.
            turns: Whole turns about it.
            inside: Whether it is led through the surface.

        Raises:
            InputError: The face is neither a cylinder nor a sphere.
        """
        try:
            found = face_of(face.wrapped, self._in_part(part), self._unit)
        except ValueError as error:
            raise InputError(f"wrap surface {name!r}: {error}") from None
        use = WrapUse(muscle, after, side, turns, inside)
        _, _, before = self._surfaces.get(name, (None, None, SurfaceUse(name)))
        muscles = (*before.muscles, use)
        self._surfaces[name] = part, found, replace(before, muscles=muscles)

    def dynamics(self, joint: Any, **values: float) -> None:
        """Say what a joint is like.

        Args:
            joint: The joint, of either side.
            values: `damping`, `friction`, `stiffness`, `rest`, `effort`, as motions have them.

        Raises:
            InputError: There is no such value.
        """
        for name in values:
            if name not in _DYNAMICS:
                raise InputError(f"no value {name!r}; values: {', '.join(_DYNAMICS)}")
        self._dynamics[id(joint)] = {name: float(value) for name, value in values.items()}

    def snapshot(self, settings: ExportSettings, file: Path | None = None) -> DesignSnapshot:
        """Return the snapshot of the design as it is now.

        Args:
            settings: How it becomes a robot's folder.
            file: The program that has drawn it.

        Raises:
            InputError: Something is not in the assembly.
        """
        try:
            return _Reading(self, settings, file).snapshot()
        except InputError as error:
            raise InputError(error.what, file=file, key=error.key) from error

    def _add(self, name: str, point: Any, use: PointUse, where: str) -> None:
        try:
            self._points.append((name, self._spot(point), use))
        except (TypeError, ValueError, AttributeError) as error:
            what = (
                "must be a joint, or a pair of a part and a point, face, edge or vertex of it: "
                f"{' '.join(str(error).split())}"
            )
            raise InputError(f"{where}: {what}") from None

    def _spot(self, point: Any) -> _Spot:
        if hasattr(point, "location") and hasattr(point, "connected_to"):  # a joint
            at = transform(point.location.wrapped.Transformation(), self._unit).p
            return _Spot(point.parent, self._in_part(point.parent).apply(at))
        part, where = point
        if hasattr(where, "wrapped") and hasattr(where, "geom_type"):
            return _Spot(part, self._in_part(part).apply(self._centre(where)))
        x, y, z = (self._unit * float(value) for value in where)
        return _Spot(part, (x, y, z))

    def _centre(self, shape: Any) -> Vector3:
        """The centre of a face, an edge or a vertex; of a round one that of its roundness."""
        unit, kind = self._unit, type(shape).__name__
        if kind == "Face":
            try:
                return face_of(shape.wrapped, IDENTITY, unit).centre
            except ValueError:
                pass
        is_round = kind == "Edge" and shape.geom_type.name == "CIRCLE"
        centre = shape.arc_center if is_round else shape.center()
        return unit * centre.X, unit * centre.Y, unit * centre.Z

    def _in_part(self, part: Any) -> Transform:
        """T_part_parent: what faces and joints' places are given in is what holds the part."""
        if part is None:
            return IDENTITY
        return transform(part.location.wrapped.Transformation(), self._unit).inverse()


class _Reading:
    """The work on one snapshot."""

    def __init__(self, design: Design, settings: ExportSettings, file: Path | None) -> None:
        self._design = design
        self._settings = settings
        self._file = file
        self._unit = design._unit
        self._materials: dict[int, Material] = {}
        self._shapes: dict[object, Any] = {}
        assembly = design._assembly
        children = list(getattr(assembly, "children", ())) if hasattr(assembly, "wrapped") else None
        if children is None:
            parts = tuple(self._part(shape, IDENTITY) for shape in assembly)
        elif children:
            above = transform(assembly.location.wrapped.Transformation(), self._unit)
            parts = tuple(self._part(shape, above) for shape in children)
        else:
            parts = (self._part(assembly, IDENTITY),)
        self._assembly = Assembly(parts, self._unit)
        self._places = {place.part.key: place for place in self._assembly.places}

    def snapshot(self) -> DesignSnapshot:
        """Return the snapshot."""
        design, assembly = self._design, self._assembly
        joints = tuple(self._joints())
        links = dict.fromkeys(path for j in joints for path in (j.two, j.one) if path is not None)
        moving = {joint.one for joint in joints}
        settings = self._settings
        if not settings.components and links:
            settings = replace(settings, components=tuple(links))
        materials = {
            place.path: self._materials[key]
            for place in assembly.places
            if isinstance(key := place.part.key, int) and key in self._materials
        }
        if design._density is not None:
            materials[ROOT] = Material(design._density)
        return DesignSnapshot(
            self._name(),
            settings,
            assembly.occurrences({path for path in links if path not in moving}),
            assembly.bodies(settings.quality, materials),
            joints=joints,
            points=tuple(self._points()),
            surfaces=tuple(self._surfaces()),
            muscles=tuple(design._muscles.values()),
            source=self._source(),
        )

    def _name(self) -> str:
        label = getattr(self._design._assembly, "label", "")
        return label or (self._file.stem if self._file else "design")

    def _source(self) -> SourceSnapshot:
        import build123d

        return SourceSnapshot(
            "build123d", str(build123d.__version__), self._file.name if self._file else ""
        )

    def _part(self, shape: Any, above: Transform) -> Part:
        """Return a part with what it holds; `above` is put before its place."""
        self._shapes[id(shape)] = shape
        T = above.compose(transform(shape.location.wrapped.Transformation(), self._unit))
        children = tuple(self._part(child, IDENTITY) for child in shape.children)
        material = getattr(shape, "material", None)
        density = getattr(getattr(material, "material", None), "density", None)
        if density:
            name = getattr(material.material, "name", "")  # type: ignore[union-attr]
            self._materials[id(shape)] = Material(float(density), str(name or ""))
        color, opacity = _color(shape)
        own = None if children else shape.wrapped.Located(kernel("TopLoc").TopLoc_Location())
        return Part(
            shape.label or type(shape).__name__.lower(),
            T,
            own,
            children,
            color=color,
            opacity=opacity,
            key=id(shape),
        )

    def _place(self, part: Any, what: str) -> Place:
        for own in (part, getattr(part, "part", None)):  # a builder has its part
            if id(own) in self._places:
                return self._places[id(own)]
        label = getattr(part, "label", "") or type(part).__name__
        raise InputError(f"{what} is on {label!r}, which is not in the assembly")

    def _joints(self) -> Iterator[JointSnapshot]:
        names: set[str] = set()
        for place in self._assembly.places:
            for joint in getattr(self._shapes[place.part.key], "joints", {}).values():
                other = joint.connected_to
                if other is None:
                    continue
                near, far = (self._place(j.parent, f"joint {j.label!r}") for j in (joint, other))
                name = joint.label if joint.label not in names else f"{joint.label}_{far.short}"
                names.add(name)
                how = self._design._dynamics
                values = how.get(id(joint)) or how.get(id(other)) or {}
                yield joint_record(name, joint, other, (near, far), self._unit, values)

    def _points(self) -> Iterator[PointSnapshot]:
        for number, (name, spot, use) in enumerate(self._design._points):
            path, T = self._at(spot.part, f"point {name!r}")
            yield PointSnapshot(name, path, T.apply(spot.position), str(number), use)

    def _surfaces(self) -> Iterator[SurfaceSnapshot]:
        for name, (part, face, use) in self._design._surfaces.items():
            path, T = self._at(part, f"wrap surface {name!r}")
            placed = T.apply(face.centre), T.rotate(face.axis), face.length
            yield SurfaceSnapshot(path, face.shape, face.radius, *placed, f"face {name}", use)

    def _at(self, part: Any, what: str) -> tuple[str, Transform]:
        """Return the path of a part, and T_root_part; the world's for None."""
        if part is None:
            return ROOT, IDENTITY
        place = self._place(part, what)
        return place.path, place.T


def _color(shape: Any) -> tuple[str | None, float]:
    color = getattr(shape, "color", None)
    if color is None:
        return None, 1.0
    text = kernel("Quantity").Quantity_Color.ColorToHex_s(color.wrapped.GetRGB())
    return str(text.ToCString()).lower(), float(color.wrapped.Alpha())
