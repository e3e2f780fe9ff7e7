"""Bodies of an occurrence: solids, surfaces and meshes, with mass and triangles."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, Literal

from ...robot.finding import Subject
from ...robot.model.pose import Vector3
from ...snapshot import BodySnapshot, MassSnapshot
from ..notes import Notes, optional
from ..occurrences import Occurrence, each_in, subject_in
from ..units import distance
from .appearance import read_appearance
from .mass import Accuracy, read_mass
from .meshes import Mesher, bounding_box

Kind = Literal["solid", "surface", "mesh"]
Tick = Callable[[str], None]


def count_bodies(occurrence: Occurrence) -> int:
    """Return the approximate number of bodies in an occurrence, for the progress."""
    component = occurrence.component
    return optional(lambda: int(component.bRepBodies.count + component.meshBodies.count)) or 0


def read_bodies(
    occurrence: Occurrence,
    mesher: Mesher | None,
    masses: Accuracy | None,
    notes: Notes,
    tick: Tick,
) -> Iterator[BodySnapshot]:
    """Yield the bodies of an occurrence without its children; with meshes if a mesher is given."""
    component = occurrence.component
    for native, name, proxy in each_in(occurrence, lambda: component.bRepBodies, notes, "body"):
        tick(occurrence.named(name))
        subject = subject_in(occurrence, "body", name)
        solid = notes.attempt(subject, "kind", _is_solid, native)
        if solid is not None:
            kind: Kind = "solid" if solid else "surface"
            yield _body(occurrence, name, kind, (native, proxy), mesher, masses, notes)
    for native, name, proxy in each_in(occurrence, lambda: component.meshBodies, notes, "body"):
        tick(occurrence.named(name))
        yield _body(occurrence, name, "mesh", (native, proxy), mesher, masses, notes)


def _body(
    occurrence: Occurrence,
    name: str,
    kind: Kind,
    body: tuple[Any, Any],
    mesher: Mesher | None,
    masses: Accuracy | None,
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
        mass=_mass(proxy, material or "", occurrence, subject, notes, masses)
        if masses and kind == "solid"
        else None,
        material=material or "",
        mesh=mesh,
        color=appearance.color,
        opacity=appearance.opacity,
        appearance=appearance.appearance,
    )


def _is_solid(body: Any) -> bool:
    return bool(body.isSolid)


def _material(body: Any) -> str:
    material = body.material
    return "" if material is None else str(material.name)


def _mass(
    proxy: Any,
    material: str,
    occurrence: Occurrence,
    subject: Subject,
    notes: Notes,
    accuracy: Accuracy,
) -> MassSnapshot | None:
    read = notes.attempt(subject, "mass", lambda: (read_mass(proxy, accuracy),))
    if read is None:
        return None
    (mass,) = read
    if mass is None:
        todo = "check its material's density" if material else "Modify > Physical Material"
        why = "no volume, or a material without density" if material else "no material"
        message = f"body {subject.name!r} has no mass, because it has {why}: {todo}"
        notes.warn(subject, "no-mass", message)
        return None
    if _in_component_frame(mass, proxy, occurrence):
        message = (
            f"body {subject.name!r}: Fusion reports its mass properties in the frame of its "
            "component. Please report this with the snapshot of the design"
        )
        notes.add("error", subject, "mass-elsewhere", message)
    return mass


def _in_component_frame(mass: MassSnapshot, proxy: Any, occurrence: Occurrence) -> bool:
    """Return whether the centre of mass is given in the frame of the component.

    Then it is inside the body only after the transform by the pose of the occurrence.
    """
    box = optional(lambda: bounding_box(proxy))
    if box is None:
        return False
    low, high = box
    slack = 0.01 * distance(low, high)

    def inside(p: Vector3) -> bool:
        return all(a - slack <= v <= b + slack for a, v, b in zip(low, p, high, strict=True))

    return not inside(mass.com) and inside(occurrence.T.apply(mass.com))
