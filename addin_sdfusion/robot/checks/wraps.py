"""Wrap surfaces: sound, on links that exist; and the muscles' ways over them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

from ..finding import Finding, Subject, member
from ..model import WORLD, Robot
from ..muscle import Muscle
from .report import error, unknown, warning


def wrap_surfaces(robot: Robot) -> Iterator[Finding]:
    """Names are there and unique, the link exists, and the surface has a size."""
    links = [WORLD, *(link.name for link in robot.links)]
    known = set(links)
    counts = Counter(surface.name for surface in robot.wrap_surfaces)
    for name, count in counts.items():
        subject = Subject("wrap_surface", name)
        if count > 1:
            problem = f"the name is used {count} times; rename all but one"
            yield error(subject, "duplicate-wrap-surface", problem)
        if not name or not name.isprintable() or name != name.strip():
            problem = "a name has no spaces at its ends, no control characters and is not empty"
            yield error(subject, "bad-name", problem)
    for surface in robot.wrap_surfaces:
        subject = Subject("wrap_surface", surface.name)
        if surface.link not in known:
            yield error(subject, "unknown-wrap-link", unknown("link", surface.link, links))
        if surface.radius <= 0.0 or surface.length <= 0.0:
            size = f"radius {surface.radius!r} and length {surface.length!r}"
            yield error(subject, "bad-wrap-size", f"{size} are not both above zero")


def wraps(robot: Robot) -> Iterator[Finding]:
    """Muscles wrap over surfaces that exist, between two of their via points."""
    surfaces = [surface.name for surface in robot.wrap_surfaces]
    known = set(surfaces)
    for group in robot.cable_sets:
        for muscle in group.muscles:
            subject = member("muscle", muscle.name, group.name, robot.cable_set)
            yield from _wraps(subject, muscle, surfaces, known)
            if muscle.wraps and group.name == robot.cable_set:
                problem = "wrapping is not simulated; it runs straight, as if nothing were there"
                yield warning(subject, "wrap-not-simulated", problem)


def _wraps(
    subject: Subject, muscle: Muscle, surfaces: list[str], known: set[str]
) -> Iterator[Finding]:
    last = len(muscle.via_points) - 2
    for wrap in muscle.wraps:
        if wrap.surface not in known:
            problem = unknown("wrap surface", wrap.surface, surfaces)
            yield error(subject, "unknown-wrap-surface", problem)
        if not 0 <= wrap.segment <= last:
            problem = f"wraps in segment {wrap.segment}; its segments are 0 to {last}"
            yield error(subject, "bad-wrap-segment", problem)
