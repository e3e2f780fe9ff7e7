"""The bodies of a place: solids, surfaces and meshes, with their mass and triangles."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, Literal

from ...robot.finding import Subject
from ...robot.model.pose import Vector3
from ...snapshot import BodySnapshot, MassSnapshot
from ..notes import Notes, if_told
from ..occurrences import Place, each_in, subject_in
from ..units import distance
from .mass import read_mass
from .meshes import Mesher, bounding_box

Kind = Literal["solid", "surface", "mesh"]
Tick = Callable[[str], None]


def count_bodies(place: Place) -> int:
    """About how many bodies a place has, to tell the progress."""
    component = place.component
    return if_told(lambda: int(component.bRepBodies.count + component.meshBodies.count)) or 0


def read_bodies(
    place: Place, mesher: Mesher | None, masses: bool, notes: Notes, tick: Tick
) -> Iterator[BodySnapshot]:
    """The bodies of a place, without those of the occurrences below it.

    Args:
        place: The place.
        mesher: Makes their meshes; None if they are not wanted.
        masses: Whether their masses are wanted.
        notes: Takes what fails.
        tick: Told the name of each body before it is read.
    """
    component = place.component
    for native, name, proxy in each_in(place, lambda: component.bRepBodies, notes, "body"):
        tick(place.named(name))
        subject = subject_in(place, "body", name)
        solid = notes.attempt(subject, "kind", _is_solid, native)
        if solid is not None:
            kind: Kind = "solid" if solid else "surface"
            yield _body(place, name, kind, (native, proxy), mesher, masses, notes)
    for native, name, proxy in each_in(place, lambda: component.meshBodies, notes, "body"):
        tick(place.named(name))
        yield _body(place, name, "mesh", (native, proxy), mesher, masses, notes)


def _body(
    place: Place,
    name: str,
    kind: Kind,
    body: tuple[Any, Any],
    mesher: Mesher | None,
    masses: bool,
    notes: Notes,
) -> BodySnapshot:
    native, proxy = body
    subject = subject_in(place, "body", name)
    material = notes.attempt(subject, "material", _material, native, severity="warning")
    mesh = None
    if mesher is not None:
        mesh = notes.attempt(
            subject,
            "mesh",
            mesher.mesh,
            *(native, proxy, kind, place, subject),
            severity="warning",
        )
    weighed = masses and kind == "solid"
    visible = notes.attempt(subject, "visibility", lambda: bool(proxy.isVisible))
    return BodySnapshot(
        name=name,
        occurrence=place.path,
        kind=kind,
        visible=visible is not False,
        mass=_mass(proxy, material or "", place, subject, notes) if weighed else None,
        material=material or "",
        mesh=mesh,
    )


def _is_solid(body: Any) -> bool:
    return bool(body.isSolid)


def _material(body: Any) -> str:
    material = body.material
    return "" if material is None else str(material.name)


def _mass(
    proxy: Any, material: str, place: Place, subject: Subject, notes: Notes
) -> MassSnapshot | None:
    told = notes.attempt(subject, "mass", lambda: (read_mass(proxy),))
    if told is None:
        return None
    (mass,) = told
    if mass is None:
        todo = "check its material's density" if material else "Modify > Physical Material"
        why = "no volume, or a material without density" if material else "no material"
        message = f"body {subject.name!r} has no mass, because it has {why}: {todo}"
        notes.warn(subject, "no-mass", message)
        return None
    if _in_component_frame(mass, proxy, place):
        message = (
            f"body {subject.name!r}: Fusion tells its mass properties in the frame of its "
            "component. Please report this with the design's snapshot"
        )
        notes.add("error", subject, "mass-elsewhere", message)
    return mass


def _in_component_frame(mass: MassSnapshot, proxy: Any, place: Place) -> bool:
    """Whether the centre of mass is in the body only once it is moved by the place's pose."""
    box = if_told(lambda: bounding_box(proxy))
    if box is None:
        return False
    low, high = box
    slack = 0.01 * distance(low, high)

    def inside(p: Vector3) -> bool:
        return all(a - slack <= v <= b + slack for a, v, b in zip(low, p, high, strict=True))

    return not inside(mass.com) and inside(place.T.apply(mass.com))
