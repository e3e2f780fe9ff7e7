"""Refusals of muscle paths that descriptions hold and the C core does not compute yet."""

from __future__ import annotations

from collections.abc import Iterator

from addin_sdfusion.robot import InputError, Muscle, Robot, WrapSurface, limits
from addin_sdfusion.robot.model.muscle_laws import law_of

MAX_HALF_AXIS = 10.0
"""As of layout.h: over longer ellipsoids the search for the shortest path may fail."""


def refuse_uncomputed(robot: Robot) -> None:
    """Reject a robot whose muscles or coordinates have what is not computed, or are too many.

    Raises:
        InputError: It names the first such muscle and what it has.
    """
    n, m = len(robot.coordinates), len(robot.muscles)
    if n * max(n, m) > limits.MATRIX:
        raise InputError(
            f"robot {robot.name!r}: {n} coordinates and {m} muscles are too many to compute with; "
            f"a matrix of them may have {limits.MATRIX} numbers"
        )
    for c in robot.all_coordinates:
        if c.friction and c.coupling:
            problem = "friction of a coupled coordinate cannot be simulated; put it on another"
            raise InputError(f"coordinate {c.name!r}: {problem}")
    for muscle in robot.muscles:
        if len(muscle.wraps) > limits.WRAPS:
            raise InputError(f"muscle {muscle.name!r} has more than {limits.WRAPS} wraps")
    long = {s.name for s in robot.wrap_surfaces if _is_long(s)}
    for muscle in robot.muscles:
        for what in _uncomputed(muscle, long):
            raise InputError(f"muscle {muscle.name!r}: {what} cannot be simulated yet")


def _is_long(surface: WrapSurface) -> bool:
    axes = (surface.radius, *(surface.half_axes or ()))
    return surface.half_axes is not None and max(axes) > MAX_HALF_AXIS * min(axes)


def _uncomputed(muscle: Muscle, long: set[str]) -> Iterator[str]:
    for wrap in muscle.wraps:
        if wrap.surface in long:
            problem = f"with a half axis over {MAX_HALF_AXIS:g} times as long as another one"
            yield f"a wrap over the ellipsoid {wrap.surface!r} {problem}"
    if muscle.wraps and any(p.when is not None and p.when.smoothing for p in muscle.via_points):
        yield "wraps beside a via point whose condition is smoothed"
    if muscle.bend_friction and _has_route(muscle):
        yield "friction on a path with conditions, moving points, branches, terms or wrap rules"
    if muscle.bend_friction and law_of(muscle.model).pushes:
        yield f"friction of a {law_of(muscle.model).kind}, which pushes,"
    if muscle.pulley is not None and _has_route(muscle):
        yield "a pulley at the base with conditions, moving points, branches, terms or wrap rules"


def _has_route(muscle: Muscle) -> bool:
    """Return whether its path is more than fixed points, and wraps by our own rule."""
    changing = any(point.when is not None or point.moves for point in muscle.via_points)
    ruled = any(wrap.rule != "taut" for wrap in muscle.wraps)
    return bool(changing or ruled or muscle.branches or muscle.terms)
