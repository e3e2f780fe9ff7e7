"""Mass properties of a design's links.

If everything below an occurrence belongs to one link, the mass of the occurrence is used, which
includes a mass that the user has set. Otherwise the masses of the bodies are summed.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

from ...robot.finding import Finding, Subject
from ...robot.finding_builders import warning
from ...robot.model.robot import Inertia
from ...snapshot import ROOT, BodySnapshot, DesignSnapshot, MassSnapshot
from ...snapshot.mass_properties import (
    MISMATCH,
    common_sign,
    eigenvalue_error,
    is_usable,
    part,
    rounding,
    sign_of,
)
from .links import Links

SPLIT = 1e-6
"""Maximum relative difference of equal masses."""


class Masses(NamedTuple):
    """Mass properties of the links."""

    parts: Mapping[str, Inertia]
    bodies: Mapping[str, tuple[BodySnapshot, ...]]
    findings: tuple[Finding, ...]


def compute_masses(snapshot: DesignSnapshot, links: Links) -> Masses:
    """Return the mass properties of the links."""
    return _MassCalculator(snapshot, links).masses()


class _MassCalculator:
    def __init__(self, snapshot: DesignSnapshot, links: Links) -> None:
        self._links = links
        self._occurrences = {o.path: o for o in snapshot.occurrences}
        self._children: dict[str, list[str]] = {}
        for o in sorted(snapshot.occurrences, key=lambda o: o.path):
            self._children.setdefault(o.parent, []).append(o.path)
        self._bodies: dict[str, list[BodySnapshot]] = {}
        for body in sorted(
            snapshot.bodies, key=lambda b: (b.occurrence, b.name, b.kind, repr(b.mass))
        ):
            self._bodies.setdefault(body.occurrence, []).append(body)
        self._is_in_one_link: dict[str, bool] = {}
        self._findings: list[Finding] = []
        self._reported = {(finding.code, finding.subject) for finding in snapshot.findings}
        masses = [*(o.mass for o in snapshot.occurrences), *(b.mass for b in snapshot.bodies)]
        self._sign = common_sign(m for m in masses if m is not None and is_usable(m))

    def masses(self) -> Masses:
        parts: dict[str, list[Inertia]] = {name: [] for name in self._links.names}
        bodies: dict[str, list[BodySnapshot]] = {name: [] for name in self._links.names}
        for path, link in sorted(self._links.of_occurrence.items()):
            bodies[link] += self._bodies.get(path, [])
            if self._is_top(path, link):
                parts[link] += self._parts_below(path, link)
        return Masses(
            {link: Inertia.of_bodies(each) for link, each in parts.items()},
            {link: tuple(each) for link, each in bodies.items()},
            tuple(self._findings),
        )

    def _is_top(self, path: str, link: str) -> bool:
        """Return whether the parent of an occurrence does not belong to the link."""
        if path == ROOT:
            return True
        above = self._occurrences[path].parent
        return above == ROOT or self._links.of_occurrence.get(above) != link

    def _parts_below(self, path: str, link: str) -> Iterator[Inertia]:
        """Yield the mass properties of a link at and below an occurrence."""
        mass = None if path == ROOT else self._occurrences[path].mass
        if path != ROOT and self._is_whole(path, link):
            if mass is not None and is_usable(mass):
                for body in self._bodies_below(path):
                    self._note_body(body, is_weighed=True)
                yield self._part(mass, Subject("occurrence", path))
                return
        elif mass is not None and is_usable(mass):
            self._note_split(path, mass)
        for body in self._bodies.get(path, []):
            if self._note_body(body, is_weighed=False) and body.mass is not None:
                yield self._part(body.mass, _subject(body))
        for child in self._children.get(path, []) if path != ROOT else []:
            if self._links.of_occurrence.get(child) == link:
                yield from self._parts_below(child, link)

    def _is_whole(self, path: str, link: str) -> bool:
        """Return whether everything below an occurrence belongs to the same link."""
        if path not in self._is_in_one_link:
            self._is_in_one_link[path] = all(
                self._links.of_occurrence.get(child) == link and self._is_whole(child, link)
                for child in self._children.get(path, [])
            )
        return self._is_in_one_link[path]

    def _bodies_below(self, path: str) -> list[BodySnapshot]:
        bodies = list(self._bodies.get(path, []))
        for child in self._children.get(path, []):
            bodies += self._bodies_below(child)
        return bodies

    def _part(self, mass: MassSnapshot, subject: Subject) -> Inertia:
        sign = sign_of(mass) or self._sign
        missed = eigenvalue_error(mass, sign)
        if missed > MISMATCH + rounding(mass):
            problem = (
                "its moments of inertia in Fusion are inconsistent with its principal moments: "
                f"they differ by {missed:.1%} of the largest. Rebuild the body, or set the inertia "
                "in the exported files"
            )
            self._findings.append(warning(subject, "inertia-mismatch", problem))
        return part(mass, sign)

    def _note_body(self, body: BodySnapshot, is_weighed: bool) -> bool:
        """Return whether the body has mass; report a body without mass."""
        subject = _subject(body)
        if body.kind != "solid":
            problem = f"is a {body.kind} body without mass; convert it to a solid or delete it"
            self._findings.append(warning(subject, f"{body.kind}-body", problem))
            return False
        has_mass = body.mass is not None and is_usable(body.mass)
        if not has_mass and not is_weighed and ("no-mass", subject) not in self._reported:
            material = f"material {body.material!r}" if body.material else "no material"
            problem = f"has {material} and no mass; give it a physical material"
            self._findings.append(warning(subject, "no-mass", problem))
        return has_mass

    def _note_split(self, path: str, mass: MassSnapshot) -> None:
        bodies = [b.mass.mass for b in self._bodies_below(path) if b.mass and is_usable(b.mass)]
        if abs(sum(bodies) - mass.mass) > SPLIT * mass.mass:
            problem = (
                f"has a mass of {mass.mass:g} kg, its bodies {sum(bodies):g} kg. It is divided "
                "between links, so the bodies are used; set the masses of its child components"
            )
            self._findings.append(warning(Subject("occurrence", path), "mass-not-divided", problem))


def _subject(body: BodySnapshot) -> Subject:
    return Subject("body", f"{body.occurrence}/{body.name}" if body.occurrence else body.name)
