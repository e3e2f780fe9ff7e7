"""Reads the open Fusion design: everything that the add-in does with a design starts here.

Only this file and those in `fusion/` read the whole of it, in Fusion's units; the commands look at
what the user clicks, and write. Nothing is edited here. What cannot be read becomes a finding; the
rest is read all the same.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, TypeVar

import adsk.core
import adsk.fusion

from ..muscles.attributes import SETTINGS, read_settings
from ..muscles.point_names import natural_key
from ..progress import Progress, no_progress
from ..robot.errors import InputError
from ..robot.finding import Subject
from ..settings import ExportSettings
from ..snapshot import (
    BodySnapshot,
    DesignIntent,
    DesignSnapshot,
    GroupSnapshot,
    JointSnapshot,
    OccurrenceSnapshot,
    PointSnapshot,
    SurfaceSnapshot,
)
from .bodies.bodies import count_bodies, read_bodies
from .bodies.mass import read_mass
from .bodies.meshes import Mesher
from .joints.groups import read_groups
from .joints.joints import read_joints
from .keys import Keys
from .names import with_unique_names
from .notes import Log, Notes, if_told
from .occurrences import Place, find_places, name_of
from .points import own_attributes, read_points
from .surfaces import read_surfaces

Item = TypeVar("Item")

_VERSION = r" v\d+$"  # the root component is named after the document's version


def read_design(
    design: Any,
    *,
    meshes: bool = True,
    masses: bool = True,
    progress: Progress | None = None,
    log: Log | None = None,
) -> DesignSnapshot:
    """All that the export needs of a design.

    Args:
        design: The design, or Fusion's application for the one that is open.
        meshes: Whether to calculate the triangles of bodies.
        masses: Whether to calculate mass properties, which takes Fusion a while.
        progress: Told of every body and occurrence; may raise `Cancelled`.
        log: Takes the traces of what cannot be read; Fusion's log if not given.

    Returns:
        The design; what could not be read is among its findings.

    Raises:
        InputError: There is no design.
        Cancelled: The user has stopped it.
    """
    application = adsk.core.Application.cast(design)
    product = design if application is None else application.activeProduct
    found = adsk.fusion.Design.cast(product)
    if found is None:
        raise InputError("open a design first, and switch to the Design workspace")
    return _Reading(found, masses, progress or no_progress, log or _log).read(meshes)


def _log(text: str) -> None:
    adsk.core.Application.get().log(text)


class _Reading:
    """One reading of a design."""

    def __init__(self, design: Any, masses: bool, progress: Progress, log: Log) -> None:
        self._design = design
        self._masses = masses
        self._progress = progress
        self._notes = Notes(log)
        self._subject = Subject("design", "design")
        self._done, self._whole = 0, 1

    def read(self, meshes: bool) -> DesignSnapshot:
        """The design."""
        notes, design = self._notes, self._design
        attributes = notes.attempt(self._subject, "attributes", own_attributes, design) or {}
        settings = self._settings(attributes)
        root = notes.attempt(self._subject, "root component", lambda: design.rootComponent)
        places = [] if root is None else find_places(root, notes)
        by_path = {place.path: place for place in places}
        self._whole = sum(1 + count_bodies(place) for place in places)
        mesher = Mesher(settings.quality, notes) if meshes else None
        occurrences, bodies = self._parts(places, mesher)
        keys = Keys(places)
        points = [
            point
            for place in places
            for point in self._all("points", place, read_points(place, keys, notes))
        ]
        return DesignSnapshot(
            name=self._name(),
            settings=settings,
            occurrences=tuple(occurrences),
            bodies=tuple(bodies),
            groups=self._groups(places, by_path),
            joints=self._joints(places, by_path),
            points=_sorted_points(points),
            surfaces=self._surfaces(places, keys),
            attributes=attributes,
            intent=self._intent(),
            findings=notes.sorted(),
        )

    def _parts(
        self, places: Sequence[Place], mesher: Mesher | None
    ) -> tuple[list[OccurrenceSnapshot], list[BodySnapshot]]:
        """Occurrences and bodies, which take the time."""
        occurrences: list[OccurrenceSnapshot] = []
        bodies: list[BodySnapshot] = []
        for place in places:
            self._tick(place.path or self._name())
            if place.occurrence is not None:
                occurrences.append(self._occurrence(place))
            read = read_bodies(place, mesher, self._masses, self._notes, self._tick)
            found = self._all("bodies", place, read)
            bodies += sorted(found, key=lambda body: (natural_key(body.name), body.kind))
        return occurrences, bodies

    def _occurrence(self, place: Place) -> OccurrenceSnapshot:
        subject, attempt = place.subject, self._notes.attempt
        told = place.occurrence
        component = attempt(subject, "component", name_of, place.component)
        grounded = attempt(subject, "grounding", _is_grounded, told)
        visible = attempt(subject, "visibility", lambda: bool(told.isVisible))
        referenced = attempt(subject, "reference", lambda: bool(told.isReferencedComponent))
        mass = attempt(subject, "mass", read_mass, told) if self._masses else None
        return OccurrenceSnapshot(
            place.path,
            place.parent,
            component or "",
            bool(grounded),
            visible is not False,
            bool(referenced),
            mass,
        )

    def _joints(
        self, places: Sequence[Place], by_path: Mapping[str, Place]
    ) -> tuple[JointSnapshot, ...]:
        found: list[tuple[str, JointSnapshot]] = []
        for place in places:
            joints = self._all("joints", place, read_joints(place, by_path, self._notes))
            ordered = sorted(joints, key=lambda joint: (natural_key(joint.name), joint.as_built))
            found += [(place.path, joint) for joint in ordered]
        named = with_unique_names(found, "joint", self._notes)
        return tuple(sorted(named, key=lambda joint: natural_key(joint.name)))

    def _groups(
        self, places: Sequence[Place], by_path: Mapping[str, Place]
    ) -> tuple[GroupSnapshot, ...]:
        found: list[tuple[str, GroupSnapshot]] = []
        for place in places:
            groups = self._all("groups", place, read_groups(place, by_path, self._notes))
            ordered = sorted(groups, key=lambda group: natural_key(group.name))
            found += [(place.path, group) for group in ordered]
        named = with_unique_names(found, "group", self._notes)
        return tuple(sorted(named, key=lambda group: natural_key(group.name)))

    def _surfaces(self, places: Sequence[Place], keys: Keys) -> tuple[SurfaceSnapshot, ...]:
        subject, told = Subject("design", "wrap surfaces"), list[SurfaceSnapshot]()
        found = read_surfaces(self._design, places, keys, self._notes)
        self._notes.attempt(subject, "faces", told.extend, found)

        def key(surface: SurfaceSnapshot) -> Any:
            return natural_key(surface.occurrence), natural_key(surface.entity)

        return tuple(sorted(told, key=key))

    def _all(self, what: str, place: Place, found: Iterator[Item]) -> list[Item]:
        """What is found in a place, up to what nobody has thought of."""
        read: list[Item] = []
        self._notes.attempt(place.subject, what, read.extend, found)
        return read

    def _settings(self, attributes: Mapping[str, str]) -> ExportSettings:
        text = attributes.get(SETTINGS)
        if text is None:
            return ExportSettings()
        try:
            return read_settings(text)
        except InputError as error:
            self._notes.trace("settings")
            message = (
                f"the settings that the design remembers cannot be read ({error}); the defaults "
                "are used. Set them again in Export"
            )
            self._notes.warn(Subject("design", "settings"), "bad-settings", message)
            return ExportSettings()

    def _name(self) -> str:
        name = self._notes.attempt(
            self._subject, "name", lambda: str(self._design.rootComponent.name)
        )
        return re.sub(_VERSION, "", name or "design")

    def _intent(self) -> DesignIntent:
        told = if_told(lambda: self._design.designIntent)  # since January 2026
        return _INTENTS.get(told, "unknown")

    def _tick(self, what: str) -> None:
        self._progress(min(self._done, self._whole), self._whole, what)
        self._done += 1


_INTENTS: dict[Any, DesignIntent] = {0: "part", 1: "assembly", 2: "hybrid"}  # DesignIntentTypes


def _is_grounded(occurrence: Any) -> bool:
    """Whether an occurrence is pinned or, since May 2024, grounded to the one that holds it."""
    return bool(occurrence.isGrounded or if_told(lambda: occurrence.isGroundToParent))


def _sorted_points(points: list[PointSnapshot]) -> tuple[PointSnapshot, ...]:
    def key(point: PointSnapshot) -> Any:
        return natural_key(point.name), natural_key(point.occurrence), point.position

    return tuple(sorted(points, key=key))
