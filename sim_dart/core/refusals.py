"""What descriptions hold of muscle paths and the C core does not compute yet."""

from __future__ import annotations

from collections.abc import Iterator

from addin_sdfusion.robot import CardsflowError, Muscle, Robot


def refuse_uncomputed(robot: Robot) -> None:
    """Refuse a robot whose muscles or coordinates have what is not computed.

    Raises:
        CardsflowError: It names the first such muscle and what it has.
    """
    for c in robot.all_coordinates:
        if c.friction and c.coupling:
            problem = "friction of a coupled coordinate cannot be simulated; put it on another"
            raise CardsflowError(f"coordinate {c.name!r}: {problem}")
    ellipsoids = {s.name for s in robot.wrap_surfaces if s.shape == "ellipsoid"}
    for muscle in robot.muscles:
        for what in _uncomputed(muscle, ellipsoids):
            raise CardsflowError(f"muscle {muscle.name!r}: {what} cannot be simulated yet")


def _uncomputed(muscle: Muscle, ellipsoids: set[str]) -> Iterator[str]:
    for wrap in muscle.wraps:
        if wrap.surface in ellipsoids:
            yield f"a wrap over the ellipsoid {wrap.surface!r}"
