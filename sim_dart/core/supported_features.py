"""Features of robots: checks that the C core supports them, and parts of the core that they use."""

from __future__ import annotations

from collections.abc import Iterator

from addin_sdfusion.robot import InputError, Muscle, Robot, WrapSurface, limits
from addin_sdfusion.robot.model.muscle_laws import law_of

MAX_HALF_AXIS = 10.0
"""Largest ratio of half axes of an ellipsoid, as in layout.h.

On longer ellipsoids the search for the shortest path can fail.
"""


def require_supported_features(robot: Robot) -> None:
    """Reject a robot with features that the C core does not support, or with too many muscles.

    Raises:
        InputError: A feature is not supported. The message contains the muscle and the feature.
    """
    n, m = len(robot.coordinates), len(robot.muscles)
    if n * max(n, m) > limits.MATRIX:
        raise InputError(
            f"robot {robot.name!r}: {n} coordinates and {m} muscles are too many; "
            f"a matrix of them may have at most {limits.MATRIX} numbers"
        )
    for c in robot.all_coordinates:
        if c.friction and c.coupling:
            problem = "friction of a coupled coordinate is not supported; set it on the driving one"
            raise InputError(f"coordinate {c.name!r}: {problem}")
    for muscle in robot.muscles:
        if len(muscle.wraps) > limits.WRAPS:
            raise InputError(f"muscle {muscle.name!r} has more than {limits.WRAPS} wraps")
    long = {s.name for s in robot.wrap_surfaces if _is_long(s)}
    for muscle in robot.muscles:
        for feature in _unsupported_features(muscle, long):
            raise InputError(f"muscle {muscle.name!r}: {feature} is not supported in simulation")


def used_parts(robot: Robot) -> list[str]:
    """Return the macros of csrc/optional_parts.h for the parts of the core that a robot uses."""
    muscles = robot.muscles
    segments = [{wrap.segment for wrap in muscle.wraps} for muscle in muscles]
    shares = any(len(group) < len(m.wraps) for group, m in zip(segments, muscles, strict=True))
    parts = {
        "WRAPS": any(muscle.wraps for muscle in muscles),
        "ELLIPSOIDS": any(surface.half_axes for surface in robot.wrap_surfaces),
        "SEQUENCES": shares or any(muscle.pulley is not None for muscle in muscles),
        "ROUTES": any(_has_special_routing(muscle) for muscle in muscles),
        "CABLE_FRICTION": any(muscle.bend_friction for muscle in muscles),
    }
    laws = sorted({"ideal" if m.model.custom else law_of(m.model).kind for m in muscles})
    return [f"USES_{part}" for part, is_used in parts.items() if is_used] + [
        f"USES_LAW_{law}" for law in laws
    ]


def _is_long(surface: WrapSurface) -> bool:
    axes = (surface.radius, *(surface.half_axes or ()))
    return surface.half_axes is not None and max(axes) > MAX_HALF_AXIS * min(axes)


def _unsupported_features(muscle: Muscle, long: set[str]) -> Iterator[str]:
    for wrap in muscle.wraps:
        if wrap.surface in long:
            problem = f"with a half axis more than {MAX_HALF_AXIS:g} times as long as another"
            yield f"a wrap over the ellipsoid {wrap.surface!r} {problem}"
    if muscle.wraps and any(p.when is not None and p.when.smoothing for p in muscle.via_points):
        yield "a wrap next to a via point with a smoothed condition"
    if muscle.bend_friction and _has_special_routing(muscle):
        yield "friction on a path with conditions, moving points, branches, terms or wrap rules"
    if muscle.bend_friction and law_of(muscle.model).pushes:
        yield f"friction of a {law_of(muscle.model).kind}, which can push,"
    if muscle.pulley is not None and _has_special_routing(muscle):
        yield "a pulley at the base with conditions, moving points, branches, terms or wrap rules"


def _has_special_routing(muscle: Muscle) -> bool:
    """Return whether the path has more than fixed points and wraps of the rule `taut`."""
    changing = any(point.when is not None or point.moves for point in muscle.via_points)
    ruled = any(wrap.rule != "taut" for wrap in muscle.wraps)
    return bool(changing or ruled or muscle.branches or muscle.terms or not muscle.via_points)
