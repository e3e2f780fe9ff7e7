"""Design of a build123d program for the import: an assembly with muscles, points and surfaces."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

from addin_sdfusion.muscles.table import COLORS
from addin_sdfusion.robot import InputError, Vector3
from addin_sdfusion.robot.model.transform import IDENTITY, Transform
from addin_sdfusion.robot.records import from_plain, to_plain
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
from .kernel import MILLIMETRE, Face, face_of, kernel, placed

_DYNAMICS = ("damping", "friction", "stiffness", "rest", "effort", "velocity")


@dataclass(frozen=True)
class _PartPoint:
    """A point in the frame of a part, in [m]; without a part in the root frame."""

    part: Any
    position: Vector3


class Design:
    """A build123d assembly with muscles, task points and joint dynamics.

    Parts that joints connect, `a.connect_to(b)`, become links. A part that is never the argument of
    `connect_to` is fixed. A point is a joint, which marks a position, or a pair of a part and a
    point in the part's coordinates, or a pair of a part and one of its faces, edges or vertices, or
    a pair of None and a point in the world.

    Attributes:
        settings: Settings for writing the robot folder.
    """

    def __init__(
        self,
        assembly: Any,
        *,
        density: float | None = None,
        unit: float = MILLIMETRE,
        **settings: Any,
    ) -> None:
        """Create a design from an assembly.

        Args:
            assembly: A Compound with children, a part, or a list of parts, with labels.
            density: Density of parts without a material, in [kg/m³]; None for massless parts.
            unit: Unit of length of the drawing, in [m].
            settings: Export settings, see ExportSettings.

        Raises:
            InputError: A setting is invalid.
        """
        self.settings = from_plain(ExportSettings, settings, "settings")
        self._assembly = assembly
        self._density = None if density is None else float(density)
        self._unit = float(unit)
        self._muscles: dict[str, MuscleSnapshot] = {}
        self._points: list[tuple[str, _PartPoint, PointUse]] = []
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
            points: Via points, in order.
            f_min: Minimum force that a controller can command, in [N].
            f_max: Maximum force, in [N].
            color: Color as `#rrggbb`; None for the next one of ten colors.
            model: Name of the muscle law.
            parameters: Parameters of the muscle law, in SI units.

        Raises:
            InputError: The name already exists, or an argument is invalid.
        """
        where = f"muscle {name!r}"
        if name in self._muscles:
            raise InputError(f"{where} already exists")
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
        """Add a task point, whose position is controlled or reported.

        Args:
            axes: Task coordinates in the world, such as "xz".

        Raises:
            InputError: An argument is invalid.
        """
        plain = {"role": "task", "name": name, "axes": list(axes)}
        use = from_plain(PointUse, plain, f"task point {name!r}")
        self._add(name, point, use, f"task point {name!r}")

    def marker(self, name: str, point: Any) -> None:
        """Add a marker, which is reported but not controlled; arguments as for `task`."""
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
        """Add a wrap of a muscle over a cylinder or sphere face.

        Args:
            name: Name of the surface; the same for all muscles that wrap over it.
            part: Part with the face.
            face: One of `part.faces()`.
            after: Number of the via point before the surface, counted from 1.
            side: 1 or -1 for a sense of rotation about the axis, 0 for the shorter path.
            turns: Number of additional full turns.
            inside: Whether the muscle passes through the surface.

        Raises:
            InputError: The face is neither a cylinder nor a sphere.
        """
        try:
            surface = face_of(face.wrapped, self._in_part(part), self._unit)
        except ValueError as error:
            raise InputError(f"wrap surface {name!r}: {error}") from None
        use = WrapUse(muscle, after, side, turns, inside)
        _, _, before = self._surfaces.get(name, (None, None, SurfaceUse(name)))
        muscles = (*before.muscles, use)
        self._surfaces[name] = part, surface, replace(before, muscles=muscles)

    def dynamics(self, joint: Any, **values: float) -> None:
        """Set the dynamic parameters of a joint.

        Args:
            joint: One of the two connected joints.
            values: `damping`, `friction`, `stiffness`, `rest`, `effort`, `velocity`, see
                MotionSnapshot.

        Raises:
            InputError: A parameter is unknown.
        """
        for name in values:
            if name not in _DYNAMICS:
                raise InputError(f"unknown parameter {name!r}; known: {', '.join(_DYNAMICS)}")
        self._dynamics[id(joint)] = {name: float(value) for name, value in values.items()}

    def snapshot(self, settings: ExportSettings, file: Path | None = None) -> DesignSnapshot:
        """Return the snapshot of the current design.

        Args:
            settings: Settings for writing the robot folder.
            file: The program that created the design.

        Raises:
            InputError: A part is not in the assembly.
        """
        try:
            return _SnapshotBuilder(self, settings, file).snapshot()
        except InputError as error:
            raise InputError(error.problem, file=file, key=error.key) from error

    def _add(self, name: str, point: Any, use: PointUse, where: str) -> None:
        try:
            self._points.append((name, self._part_point(point), use))
        except (TypeError, ValueError, AttributeError) as error:
            problem = (
                "must be a joint, or a pair of a part and a point, face, edge or vertex of it: "
                f"{' '.join(str(error).split())}"
            )
            raise InputError(f"{where}: {problem}") from None

    def _part_point(self, point: Any) -> _PartPoint:
        if hasattr(point, "location") and hasattr(point, "connected_to"):  # a joint
            at = placed(point.location, self._unit).p
            return _PartPoint(point.parent, self._in_part(point.parent).apply(at))
        part, where = point
        if hasattr(where, "wrapped") and hasattr(where, "geom_type"):
            return _PartPoint(part, self._in_part(part).apply(self._centre(where)))
        x, y, z = (self._unit * float(value) for value in where)
        return _PartPoint(part, (x, y, z))

    def _centre(self, shape: Any) -> Vector3:
        """Return the centre of a face, edge or vertex; for an arc the centre of its circle."""
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
        """Return T_part_parent, since build123d expresses faces and joints in the parent frame."""
        if part is None:
            return IDENTITY
        return placed(part.location, self._unit).inverse()


class _SnapshotBuilder:
    """Builder of one snapshot."""

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
            above = placed(assembly.location, self._unit)
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
        """Return a part with its children; `above` is multiplied from the left to its pose."""
        self._shapes[id(shape)] = shape
        T = above.compose(placed(shape.location, self._unit))
        children = tuple(self._part(child, IDENTITY) for child in shape.children)
        material = getattr(shape, "material", None)
        density = getattr(getattr(material, "material", None), "density", None)
        if density:
            name = getattr(material.material, "name", "")  # type: ignore[union-attr]
            self._materials[id(shape)] = Material(float(density), str(name or ""))
        color, opacity = _color(shape)
        solid = None if children else shape.wrapped.Located(kernel("TopLoc").TopLoc_Location())
        return Part(
            shape.label or type(shape).__name__.lower(),
            T,
            solid,
            children,
            color=color,
            opacity=opacity,
            key=id(shape),
        )

    def _place(self, part: Any, item: str) -> Place:
        for candidate in (part, getattr(part, "part", None)):  # a builder contains its part
            if id(candidate) in self._places:
                return self._places[id(candidate)]
        label = getattr(part, "label", "") or type(part).__name__
        raise InputError(f"{item} is on {label!r}, which is not in the assembly")

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
        for number, (name, point, use) in enumerate(self._design._points):
            path, T = self._at(point.part, f"point {name!r}")
            yield PointSnapshot(name, path, T.apply(point.position), str(number), use)

    def _surfaces(self) -> Iterator[SurfaceSnapshot]:
        for name, (part, face, use) in self._design._surfaces.items():
            path, T = self._at(part, f"wrap surface {name!r}")
            where = T.apply(face.centre), T.rotate(face.axis), face.length
            yield SurfaceSnapshot(path, face.shape, face.radius, *where, f"face {name}", use)

    def _at(self, part: Any, item: str) -> tuple[str, Transform]:
        """Return the path of a part and T_root_part; the root for None."""
        if part is None:
            return ROOT, IDENTITY
        place = self._place(part, item)
        return place.path, place.T


def _color(shape: Any) -> tuple[str | None, float]:
    color = getattr(shape, "color", None)
    if color is None:
        return None, 1.0
    text = kernel("Quantity").Quantity_Color.ColorToHex_s(color.wrapped.GetRGB())
    return str(text.ToCString()).lower(), float(color.wrapped.Alpha())
