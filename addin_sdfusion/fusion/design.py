"""Reader for the open Fusion design.

The modules of `fusion/` read a complete design and convert it from Fusion's units to SI units. They
do not edit the design; the commands do. Objects that cannot be read are reported as findings and
skipped.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
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
    CouplingSnapshot,
    DesignIntent,
    DesignSnapshot,
    OccurrenceSnapshot,
    PointSnapshot,
    SourceSnapshot,
    SurfaceSnapshot,
)
from .bodies.bodies import count_bodies, read_bodies
from .bodies.mass import Weigher
from .bodies.meshes import Mesher
from .inserted import attributes_of_designs, read_kept
from .instances import Instances
from .joints.couplings import read_couplings
from .joints.groups import read_groups
from .joints.joints import read_joints
from .names import Keys, Named, with_unique_names
from .notes import Log, Notes, optional
from .occurrences import Occurrence, Occurrences, find_occurrences, name_of
from .places import Places
from .points import own_attributes, read_hidden_points, read_points
from .surfaces import read_surfaces

Item = TypeVar("Item")

_VERSION = r" v\d+$"  # the name of the root component contains the version of the document


def read_design(
    design: Any,
    *,
    meshes: bool = True,
    masses: bool = True,
    progress: Progress | None = None,
    log: Log | None = None,
) -> DesignSnapshot:
    """Return the snapshot of a design.

    Args:
        design: The design, or Fusion's application, whose open design is read.
        meshes: Whether to calculate the triangle meshes of bodies.
        masses: Whether to calculate the mass properties, which is slow.
        progress: Called for every body and occurrence; may raise `Cancelled`.
        log: Function that logs the tracebacks of reading errors (default: Fusion's log).

    Returns:
        The snapshot; its findings report objects that could not be read.

    Raises:
        InputError: No design is open.
        Cancelled: The user cancelled the operation.
    """
    application = adsk.core.Application.cast(design)
    product = design if application is None else application.activeProduct
    design = adsk.fusion.Design.cast(product)
    if design is None:
        raise InputError("open a design first, and switch to the Design workspace")
    return _DesignReader(design, masses, progress or no_progress, log or _log).read(meshes)


def _log(text: str) -> None:
    adsk.core.Application.get().log(text)


class _DesignReader:
    """Reader for one design."""

    def __init__(self, design: Any, masses: bool, progress: Progress, log: Log) -> None:
        self._design = design
        self._masses = masses
        self._progress = progress
        self._notes = Notes(log)
        self._subject = Subject("design", "design")
        self._done, self._total = 0, 1

    def read(self, meshes: bool) -> DesignSnapshot:
        """Return the snapshot of the design."""
        notes, design = self._notes, self._design
        attributes = notes.attempt(self._subject, "attributes", own_attributes, design) or {}
        settings = self._settings(attributes)
        root = notes.attempt(self._subject, "root component", lambda: design.rootComponent)
        occurrences = {} if root is None else find_occurrences(root, notes)
        self._total = sum(1 + count_bodies(occurrence) for occurrence in occurrences.values())
        mesher = Mesher(settings.quality, notes) if meshes else None
        weigher = Weigher(occurrences) if self._masses else None
        parts, bodies = self._parts(occurrences, mesher, weigher)
        if weigher is not None:
            parts, bodies = weigher.in_root_frame(parts, bodies)
        keys = Keys(occurrences.values())
        places = Places(design, occurrences)
        of_designs = attributes_of_designs(attributes, occurrences, places)
        instances = Instances(of_designs, self._name(), notes)
        points = [
            instances.point(point)
            for occurrence in occurrences.values()
            for point in self._read_all(
                "points", occurrence, read_points(occurrence, keys, places, notes)
            )
        ]
        visible = {places.component(path) for path in occurrences}
        if occurrences:
            hidden = read_hidden_points(design, visible, notes)
            notes.attempt(self._subject, "hidden points", points.extend, hidden)
        stored = read_kept(of_designs, occurrences, places, notes)
        points += [instances.point(point, path) for path, point in stored]
        groups = self._read_named("group", read_groups, occurrences)
        joints = self._read_named("joint", read_joints, occurrences)
        by_place = {(path, joint.name, joint.as_built): named for path, joint, named in joints}
        couplings = list[CouplingSnapshot]()
        links = read_couplings(occurrences, by_place, notes)
        notes.attempt(self._subject, "motion links", couplings.extend, links)
        return DesignSnapshot(
            name=self._name(),
            settings=settings,
            occurrences=tuple(parts),
            bodies=tuple(bodies),
            groups=_in_order(named for _, _, named in groups),
            joints=_in_order(named for _, _, named in joints),
            points=tuple(sorted(points, key=_point_key)),
            surfaces=self._surfaces(list(occurrences.values()), keys, places, instances),
            muscles=instances.muscles,
            intent=self._intent(),
            findings=notes.sorted(),
            source=self._source(),
            couplings=tuple(sorted(couplings, key=repr)),
        )

    def _parts(
        self, occurrences: Occurrences, mesher: Mesher | None, weigher: Weigher | None
    ) -> tuple[list[OccurrenceSnapshot], list[BodySnapshot]]:
        """Return the occurrences and bodies, and report the progress."""
        parts: list[OccurrenceSnapshot] = []
        bodies: list[BodySnapshot] = []
        for occurrence in occurrences.values():
            self._tick(occurrence.path or self._name())
            if occurrence.native is not None:
                parts.append(self._occurrence(occurrence, weigher))
            read = read_bodies(occurrence, mesher, weigher, self._notes, self._tick)
            found_bodies = self._read_all("bodies", occurrence, read)
            bodies += sorted(found_bodies, key=lambda body: (natural_key(body.name), body.kind))
        return parts, bodies

    def _occurrence(self, occurrence: Occurrence, weigher: Weigher | None) -> OccurrenceSnapshot:
        subject, attempt = occurrence.subject, self._notes.attempt
        native = occurrence.native
        component = attempt(subject, "component", name_of, occurrence.component)
        grounded = attempt(subject, "grounding", lambda: native.isGrounded)
        to_parent = optional(lambda: native.isGroundToParent)  # since May 2024
        visible = attempt(subject, "visibility", lambda: bool(native.isVisible))
        referenced = attempt(subject, "reference", lambda: bool(native.isReferencedComponent))
        mass = attempt(subject, "mass", weigher.occurrence, occurrence) if weigher else None
        return OccurrenceSnapshot(
            occurrence.path,
            occurrence.parent,
            component or "",
            bool(grounded),
            visible is not False,
            bool(referenced),
            mass,
            bool(to_parent),
        )

    def _read_named(
        self,
        kind: str,
        read: Callable[[Occurrence, Occurrences, Notes], Iterator[Named]],
        occurrences: Occurrences,
    ) -> list[tuple[str, Named, Named]]:
        """Return joints or groups: path of the occurrence, original item, uniquely named item."""
        pairs: list[tuple[str, Named]] = []
        for occurrence in occurrences.values():
            items = self._read_all(
                f"{kind}s", occurrence, read(occurrence, occurrences, self._notes)
            )
            items.sort(key=lambda i: (natural_key(i.name), getattr(i, "as_built", False)))
            pairs += [(occurrence.path, item) for item in items]
        named = with_unique_names(pairs, kind, self._notes)
        return [(path, item, unique) for (path, item), unique in zip(pairs, named, strict=True)]

    def _surfaces(
        self,
        occurrences: Sequence[Occurrence],
        keys: Keys,
        places: Places,
        instances: Instances,
    ) -> tuple[SurfaceSnapshot, ...]:
        subject, read = Subject("design", "wrap surfaces"), list[SurfaceSnapshot]()
        surfaces = read_surfaces(self._design, occurrences, keys, places, self._notes)
        self._notes.attempt(subject, "faces", read.extend, surfaces)
        read = [instances.surface(surface) for surface in read]
        return tuple(sorted(read, key=lambda s: (natural_key(s.occurrence), natural_key(s.entity))))

    def _read_all(self, label: str, occurrence: Occurrence, items: Iterator[Item]) -> list[Item]:
        """Return all items found in an occurrence before an unexpected error, if any."""
        read: list[Item] = []
        self._notes.attempt(occurrence.subject, label, read.extend, items)
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
                f"the settings stored in the design cannot be read ({error}); the defaults are "
                "used. Set them again in Export"
            )
            self._notes.warn(Subject("design", "settings"), "bad-settings", message)
            return ExportSettings()

    def _name(self) -> str:
        name = self._notes.attempt(
            self._subject, "name", lambda: str(self._design.rootComponent.name)
        )
        return re.sub(_VERSION, "", name or "design")

    def _intent(self) -> DesignIntent:
        intent = optional(lambda: self._design.designIntent)  # since January 2026
        return _INTENTS.get(intent, "unknown")

    def _source(self) -> SourceSnapshot:
        version = optional(lambda: str(adsk.core.Application.get().version))
        document = optional(lambda: str(self._design.parentDocument.name))
        return SourceSnapshot("Fusion", version or "", document or "")

    def _tick(self, step: str) -> None:
        self._progress(min(self._done, self._total), self._total, step)
        self._done += 1


_INTENTS: dict[Any, DesignIntent] = {0: "part", 1: "assembly", 2: "hybrid"}  # DesignIntentTypes


def _in_order(items: Iterable[Named]) -> tuple[Named, ...]:
    return tuple(sorted(items, key=lambda item: natural_key(item.name)))


def _point_key(point: PointSnapshot) -> Any:
    return natural_key(point.name), natural_key(point.occurrence), point.position
