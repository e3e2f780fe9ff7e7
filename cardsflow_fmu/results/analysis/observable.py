"""Observability of an experiment's reference poses from its sensors, before a run."""

from __future__ import annotations

from typing import Any

import numpy as np

from addin_sdfusion.robot import CardsflowError
from cardsflow_fmu.experiment.experiment import Experiment
from sim_dart.estimation.observability import observability

POSES = 33
"""Of the reference, at which the rank is taken."""


def observed_poses(experiment: Experiment) -> dict[str, Any]:
    """The rank of what lengths and encoders tell, along the reference; plain data.

    Returns:
        `poses`, `least_rank`, `coordinates`; `sd`, the largest one of each coordinate from one
        reading, None where it is left open, and `open_poses`, at how many it is; `critical`,
        muscles that leave a pose open when they are slack together. Nothing without an estimator.
    """
    settings = experiment.estimator
    if settings is None:
        return {}
    from .sizing import reference_motion  # late: SciPy

    try:
        poses = reference_motion(experiment, POSES).q
    except CardsflowError:  # what is out of reach is said by the run
        poses = np.array([experiment.start.q])
    found = observability(experiment.robot, poses, settings.believed)
    names = [c.name for c in experiment.robot.coordinates]
    largest = found.sd.max(axis=0)
    return {
        "poses": len(poses),
        "least_rank": int(found.rank.min()),
        "coordinates": len(names),
        "sd": {
            n: float(s) if np.isfinite(s) else None for n, s in zip(names, largest, strict=True)
        },
        "open_poses": dict(zip(names, np.isinf(found.sd).sum(axis=0).tolist(), strict=True)),
        "critical": list(found.critical),
        "inertial_units": len(settings.imus),
    }


def observability_warnings(found: dict[str, Any]) -> list[str]:
    """What cannot be observed along the reference, a line each; from `observed_poses`."""
    open_ = {name: count for name, count in found.get("open_poses", {}).items() if count}
    if not open_:
        return []
    words = ", ".join(f"{name} at {count}" for name, count in open_.items())
    line = (
        f"muscles and encoders leave the pose open: {words} of {found['poses']} poses of the "
        f"reference (least rank {found['least_rank']} of {found['coordinates']})"
    )
    units = "; inertial units have to tell it" if found["inertial_units"] else ""
    return [line + (units or "; add encoders, inertial units or muscles")]


def observability_remarks(found: dict[str, Any]) -> list[str]:
    """Lines on how observable the pose is with all muscles taut, and with some slack."""
    if not found or found["least_rank"] < found["coordinates"]:
        return []
    worst = max(found["sd"], key=lambda name: found["sd"][name])
    lines = [
        f"one reading tells the pose to {found['sd'][worst]:.3g} at worst ({worst}, along the "
        "reference)"
    ]
    if found["critical"]:
        together = " and ".join(found["critical"])
        lines.append(
            f"slack {'together' if len(found['critical']) > 1 else 'alone'}, {together} "
            "would leave a pose open"
        )
    return lines
