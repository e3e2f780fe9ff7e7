"""Bodies of an occurrence: solids, surfaces and meshes, with mass and triangles."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, Literal

from ...snapshot import BodySnapshot, MassSnapshot
from ..notes import Notes, optional
from ..occurrences import Occurrence, each_in, subject_in
from .appearance import read_appearance
from .mass import Weigher
from .meshes import Mesher

Kind = Literal["solid", "surface", "mesh"]
Tick = Callable[[str], None]


def count_bodies(occurrence: Occurrence) -> int:
    """Return the approximate number of bodies in an occurrence, for the progress."""
    component = occurrence.component
    return optional(lambda: int(component.bRepBodies.count + component.meshBodies.count)) or 0


def read_bodies(
    occurrence: Occurrence,
    mesher: Mesher | None,
    weigher: Weigher | None,
    notes: Notes,
    tick: Tick,
) -> Iterator[BodySnapshot]:
    """Yield the bodies of an occurrence without its children; with meshes if a mesher is given."""
    component = occurrence.component
    for native, name, proxy in each_in(occurrence, lambda: component.bRepBodies, notes, "body"):
        tick(occurrence.named(name))
        subject = subject_in(occurrence, "body", name)
        solid = notes.attempt(subject, "kind", lambda body: bool(body.isSolid), native)
        if solid is not None:
            kind: Kind = "solid" if solid else "surface"
            yield _body(occurrence, name, kind, (native, proxy), mesher, weigher, notes)
    for native, name, proxy in each_in(occurrence, lambda: component.meshBodies, notes, "body"):
        tick(occurrence.named(name))
        yield _body(occurrence, name, "mesh", (native, proxy), mesher, weigher, notes)


def _body(
    occurrence: Occurrence,
    name: str,
    kind: Kind,
    body: tuple[Any, Any],
    mesher: Mesher | None,
    weigher: Weigher | None,
    notes: Notes,
) -> BodySnapshot:
    native, proxy = body
    subject = subject_in(occurrence, "body", name)
    material = notes.attempt(subject, "material", _material, native, severity="warning")
    mesh = None
    if mesher is not None:
        mesh = notes.attempt(
            subject,
            "mesh",
            mesher.mesh,
            *(native, proxy, kind, occurrence, subject),
            severity="warning",
        )
    visible = notes.attempt(subject, "visibility", lambda: bool(proxy.isVisible))
    appearance = read_appearance(proxy)
    return BodySnapshot(
        name=name,
        occurrence=occurrence.path,
        kind=kind,
        visible=visible is not False,
        mass=_mass(native, name, material or "", occurrence, notes, weigher)
        if weigher and kind == "solid"
        else None,
        material=material or "",
        mesh=mesh,
        color=appearance.color,
        opacity=appearance.opacity,
        appearance=appearance.appearance,
    )


def _material(body: Any) -> str:
    material = body.material
    return "" if material is None else str(material.name)


def _mass(
    native: Any,
    name: str,
    material: str,
    occurrence: Occurrence,
    notes: Notes,
    weigher: Weigher,
) -> MassSnapshot | None:
    subject = subject_in(occurrence, "body", name)
    read = notes.attempt(subject, "mass", lambda: (weigher.body(native, name, occurrence),))
    if read is None:
        return None
    (mass,) = read
    if mass is None:
        todo = "check its material's density" if material else "Modify > Physical Material"
        why = "no volume, or a material without density" if material else "no material"
        message = f"body {subject.name!r} has no mass, because it has {why}: {todo}"
        notes.warn(subject, "no-mass", message)
    return mass
