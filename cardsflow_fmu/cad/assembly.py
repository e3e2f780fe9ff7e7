"""An assembly as a snapshot has it: components in places, and the solids in them."""

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
    """What a part is made of.

    Attributes:
        density: In [kg/m³].
        name: Its name; empty if not known.
    """

    density: float
    name: str = ""


@dataclass(frozen=True)
class Part:
    """A component in one place.

    Attributes:
        name: The component's; that of several parts that are alike.
        T: In what holds it, T_parent_part, lengths in [m].
        shape: The kernel's, in the part's frame; None if it only holds others.
        children: What it holds.
        label: What the place is called; empty if nothing.
        color: As `#rrggbb`; None if not known.
        opacity: From 0 to 1.
        key: What the part is known by, such as its `id`.
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
    """A part, and where it is.

    Attributes:
        path: As occurrences have it.
        parent: Path of what holds it.
        part: The part.
        T: T_root_part, in [m].
    """

    path: str
    parent: str
    part: Part
    T: Transform

    @property
    def name(self) -> str:
        """The part's name, as paths have it."""
        return self.path.rpartition("+")[2].rpartition(":")[0]

    @property
    def short(self) -> str:
        """What the export calls the link of it, if that is unique: `finger`, `finger_2`."""
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
        places: Every component in every place, what holds others first.
    """

    def __init__(self, parts: Sequence[Part], unit: float) -> None:
        """An assembly of parts.

        Args:
            parts: What is in the root.
            unit: The shapes' unit of length, in [m].
        """
        self.places = tuple(_placed(parts, ROOT, IDENTITY))
        self._unit = unit

    def find(self, name: str) -> Place:
        """Return the place of that path, or component's or place's name.

        Raises:
            InputError: There is none, or more than one; the message names those that exist.
        """
        for of in _NAMES:
            found = [place for place in self.places if of(place) == name]
            if len(found) == 1:
                return found[0]
            if found:
                paths = listed([place.path for place in found], 5)
                raise InputError(f"part {name!r} is in several places; say which: {paths}")
        raise InputError(unknown("part", name, [place.path for place in self.places]))

    def occurrences(self, grounded: Collection[str]) -> tuple[OccurrenceSnapshot, ...]:
        """Return the records of the places; `grounded` are the paths of those that stand still."""
        return tuple(
            OccurrenceSnapshot(place.path, place.parent, place.name, place.path in grounded)
            for place in self.places
        )

    def below(self, path: str) -> list[Place]:
        """Return a place and all below it."""
        return [p for p in self.places if p.path == path or p.path.startswith(f"{path}+")]

    def faces(self, place: Place) -> list[Face]:
        """Return the cylinder and sphere faces of a place itself."""
        return (
            [] if place.part.shape is None else round_faces(place.part.shape, place.T, self._unit)
        )

    def volume(self, path: str) -> float:
        """Return the volume of a place and all below it, in [m³]."""
        every = [
            s for p in self.below(path) if p.part.shape is not None for s in solids(p.part.shape)
        ]
        masses = [mass_of(solid, IDENTITY, 1.0, self._unit) for solid in every]
        return sum(mass.mass for mass in masses if mass is not None)

    def bodies(
        self, quality: MeshQuality, materials: Mapping[str, Material]
    ) -> tuple[BodySnapshot, ...]:
        """Return the records of the solids, with masses and triangles.

        Args:
            quality: How fine the triangles are.
            materials: By path, for all below it that have none of their own; `ROOT` for the rest.
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
        known = [materials[path] for path in paths if path in materials]
        material = known[-1] if known else None
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


def _placed(parts: Sequence[Part], parent: str, T: Transform) -> Iterator[Place]:
    count: Counter[str] = Counter()
    for part in parts:
        name = part.name.replace("+", "_").replace(":", "_") or "part"
        count[name] += 1
        path = f"{parent}+{name}:{count[name]}" if parent else f"{name}:{count[name]}"
        place = Place(path, parent, part, T.compose(part.T))
        yield place
        yield from _placed(part.children, path, place.T)
