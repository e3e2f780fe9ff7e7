"""Assembly of components with their poses and solids, for a snapshot."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from addin_sdfusion.robot import InputError
from addin_sdfusion.robot.finding_builders import listed, unknown
from addin_sdfusion.robot.model.transform import IDENTITY, Transform
from addin_sdfusion.settings import MeshQuality
from addin_sdfusion.snapshot import ROOT, BodySnapshot, OccurrenceSnapshot

from .kernel import Face, mass_of, mesh_of, round_faces, solids


class Material(NamedTuple):
    """Material of a part.

    Attributes:
        density: In [kg/m³].
        name: Name of the material; empty if unknown.
    """

    density: float
    name: str = ""


@dataclass(frozen=True)
class Part:
    """An instance of a component.

    Attributes:
        name: Name of the component; equal parts have the same name.
        T: Pose in the parent assembly, T_parent_part, lengths in [m].
        shape: Shape of the geometry kernel in the part's frame; None for a subassembly.
        label: Name of the instance; may be empty.
        color: Color as `#rrggbb`; None if unknown.
        opacity: From 0 to 1.
        key: Identification of the part, such as its `id`.
    """

    name: str
    T: Transform = IDENTITY
    shape: Any = None
    children: tuple[Part, ...] = ()
    label: str = ""
    color: str | None = None
    opacity: float = 1.0
    key: object = None


@dataclass(frozen=True)
class Place:
    """A part with its path and pose in the assembly.

    Attributes:
        T: Pose T_root_part, lengths in [m].
    """

    path: str
    parent: str
    part: Part
    T: Transform

    @property
    def name(self) -> str:
        """Name of the part in its path."""
        return self.path.rpartition("+")[2].rpartition(":")[0]

    @property
    def short(self) -> str:
        """Name of the exported link if it is unique, such as `finger` or `finger_2`."""
        number = self.path.rpartition(":")[2]
        return self.name if number == "1" else f"{self.name}_{number}"


_NAMES: tuple[Callable[[Place], str], ...] = (
    lambda place: place.path,
    lambda place: place.short,
    lambda place: place.part.label,
    lambda place: place.part.name,
)


class Assembly:
    """An assembly.

    Attributes:
        places: All instances of all components, parents before children.
    """

    def __init__(self, parts: Sequence[Part], unit: float) -> None:
        """Create an assembly from parts.

        Args:
            unit: Unit of length of the shapes, in [m].
        """
        self.places = tuple(_places(parts, ROOT, IDENTITY))
        self._unit = unit

    def find(self, name: str) -> Place:
        """Return the place with a path, or with the name of an instance or component.

        Raises:
            InputError: No place or several places match; the message lists the candidates.
        """
        for name_of in _NAMES:
            matching = [place for place in self.places if name_of(place) == name]
            if len(matching) == 1:
                return matching[0]
            if matching:
                paths = listed([place.path for place in matching], 5)
                raise InputError(f"part {name!r} is not unique; use one of the paths {paths}")
        raise InputError(unknown("part", name, [place.path for place in self.places]))

    def occurrences(self, grounded: Collection[str]) -> tuple[OccurrenceSnapshot, ...]:
        """Return the records of the places; `grounded` contains the paths of fixed parts."""
        return tuple(
            OccurrenceSnapshot(place.path, place.parent, place.name, place.path in grounded)
            for place in self.places
        )

    def below(self, path: str) -> list[Place]:
        """Return a place and all places below it."""
        return [p for p in self.places if p.path == path or p.path.startswith(f"{path}+")]

    def faces(self, place: Place) -> list[Face]:
        """Return the cylinder and sphere faces of a place, without the places below it."""
        return (
            [] if place.part.shape is None else round_faces(place.part.shape, place.T, self._unit)
        )

    def volume(self, path: str) -> float:
        """Return the volume of a place and all places below it, in [m³]."""
        bodies = [
            s for p in self.below(path) if p.part.shape is not None for s in solids(p.part.shape)
        ]
        masses = [mass_of(solid, IDENTITY, 1.0, self._unit) for solid in bodies]
        return sum(mass.mass for mass in masses if mass is not None)

    def bodies(
        self, quality: MeshQuality, materials: Mapping[str, Material]
    ) -> tuple[BodySnapshot, ...]:
        """Return the records of the solids, with masses and triangles.

        Args:
            materials: Materials by path. A material applies to all places below its path, unless
                they have another one; `ROOT` is the default.
        """
        return tuple(b for place in self.places for b in self._bodies(place, quality, materials))

    def _bodies(
        self, place: Place, quality: MeshQuality, materials: Mapping[str, Material]
    ) -> Iterator[BodySnapshot]:
        part, unit = place.part, self._unit
        if part.shape is None:
            return
        steps = place.path.split("+")
        paths = (ROOT, *("+".join(steps[: i + 1]) for i in range(len(steps))))
        materials_above = [materials[path] for path in paths if path in materials]
        material = materials_above[-1] if materials_above else None
        bodies = solids(part.shape)
        for number, solid in enumerate(bodies or [part.shape], start=1):
            mass = mass_of(solid, place.T, material.density, unit) if bodies and material else None
            yield BodySnapshot(
                f"Body{number}",
                place.path,
                "solid" if bodies else "surface",
                mass=mass,
                material=material.name if material else "",
                mesh=mesh_of(solid, place.T, quality, unit),
                color=part.color,
                opacity=part.opacity,
            )


def _places(parts: Sequence[Part], parent: str, T: Transform) -> Iterator[Place]:
    count: Counter[str] = Counter()
    for part in parts:
        name = part.name.replace("+", "_").replace(":", "_") or "part"
        count[name] += 1
        path = f"{parent}+{name}:{count[name]}" if parent else f"{name}:{count[name]}"
        place = Place(path, parent, part, T.compose(part.T))
        yield place
        yield from _places(part.children, path, place.T)
