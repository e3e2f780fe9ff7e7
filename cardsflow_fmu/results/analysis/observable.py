"""Observability of the reference poses from the sensors of an experiment, before a run."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from addin_sdfusion.robot import CardsflowError, Robot
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.experiment.settings.estimator import EstimatorTable
from cardsflow_fmu.utils.arrays import FloatArray
from sim_dart.estimation.observability import observability

POSES = 33
"""Number of poses of the reference at which the rank is computed."""


def observed_poses(experiment: Experiment) -> dict[str, Any]:
    """Compute the observability of poses along the reference from lengths and encoders.

    Returns:
        Plain data: `poses`, `least_rank`, `coordinates`; `sd`, the maximum standard deviation of
        each coordinate from one measurement, None if it is unobservable; `open_poses`, the number
        of poses at which it is unobservable; `critical`, muscles that make a pose unobservable if
        they are slack together; `rank_with_offsets`, the least rank if lengths
        with unknown offsets are ignored. Empty without an estimator.
    """
    settings = experiment.estimator
    if settings is None:
        return {}
    from .sizing import reference_motion  # imports SciPy, which is slow

    try:
        poses = reference_motion(experiment, POSES).q
    except CardsflowError:  # the run reports unreachable points
        poses = np.array([experiment.start.q])
    result = observability(experiment.robot, poses, settings.estimator_settings)
    names = [c.name for c in experiment.robot.coordinates]
    largest = result.sd.max(axis=0)
    return {
        "poses": len(poses),
        "least_rank": int(result.rank.min()),
        "coordinates": len(names),
        "sd": {
            n: float(s) if np.isfinite(s) else None for n, s in zip(names, largest, strict=True)
        },
        "open_poses": dict(zip(names, np.isinf(result.sd).sum(axis=0).tolist(), strict=True)),
        "critical": list(result.critical),
        "inertial_units": len(settings.imus),
        "rank_with_offsets": _rank_with_offsets(experiment.robot, poses, settings),
    }


def _rank_with_offsets(robot: Robot, poses: FloatArray, settings: EstimatorTable) -> int:
    is_unknown = np.hypot(settings.offset_drift, settings.start_offset_sd) > 0.0
    noise = np.where(is_unknown, 0.0, settings.length_noise)
    if not is_unknown.any():
        return len(robot.coordinates)
    known_noise = replace(settings.estimator_settings, length_noise=noise)
    return int(observability(robot, poses, known_noise).rank.min())


def observability_warnings(result: dict[str, Any]) -> list[str]:
    """Return warnings about unobservable poses and offsets."""
    unobservable = {name: count for name, count in result.get("open_poses", {}).items() if count}
    lines, coordinates = [], result.get("coordinates", 0)
    if (rank := result.get("rank_with_offsets", 0)) < coordinates:
        seen = "only by IMUs" if result["inertial_units"] else "not"
        lines.append(
            f"drifting offsets are {seen} observable: encoders and lengths with constant offsets "
            f"have rank {rank} of {coordinates}, so that a drift looks like a different pose; add "
            "encoders, or set estimator.offset_drift for fewer muscles"
        )
    if not unobservable:
        return lines
    coordinates = ", ".join(f"{name} at {count}" for name, count in unobservable.items())
    line = (
        f"muscles and encoders do not determine the pose: {coordinates} of {result['poses']} poses "
        f"of the reference (minimum rank {result['least_rank']} of {result['coordinates']})"
    )
    units = "; the IMUs must provide it" if result["inertial_units"] else ""
    return [*lines, line + (units or "; add encoders, IMUs or muscles")]


def observability_notes(result: dict[str, Any]) -> list[str]:
    """Describe the observability of the pose with taut and with slack muscles.

    Args:
        result: Result of `observed_poses`.
    """
    if not result or result["least_rank"] < result["coordinates"]:
        return []
    worst = max(result["sd"], key=lambda name: result["sd"][name])
    lines = [
        f"standard deviation from one measurement: up to {result['sd'][worst]:.3g} ({worst}, "
        "along the reference)"
    ]
    if result["critical"]:
        together = " and ".join(result["critical"])
        verb = "are" if len(result["critical"]) > 1 else "is"
        lines.append(f"a pose is unobservable if {together} {verb} slack")
    return lines
