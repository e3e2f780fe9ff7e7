"""Summary of state estimates and their errors."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from cardsflow_fmu.cosim.signals.estimation import ESTIMATE, STATUSES, VALID
from cardsflow_fmu.cosim.signals.ports import coordinate_signals
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.utils.arrays import FloatArray


def estimation_summary(
    experiment: Experiment, columns: Mapping[str, FloatArray], observed: Mapping[str, Any]
) -> dict[str, Any]:
    """Return errors, standard deviations, innovations and validity; empty without an estimate.

    Hardware without joint encoders has no ground truth, so that the errors are unknown. `fitted`
    marks positions that were fitted to muscle lengths.

    Args:
        experiment: The experiment.
        columns: Columns of the run.
        observed: Observability; see `analysis.observable`.
    """
    if experiment.estimator is None or VALID not in columns or not len(columns[VALID]):
        return {}
    hardware = experiment.hardware
    is_known = hardware.has_positions or not hardware.use
    robot, valid, time = experiment.robot, columns[VALID] != 0, columns["time"]
    lost = np.flatnonzero(~valid)
    return {
        "estimation": {
            "valid_share": float(valid.mean()),
            "first_lost_at_s": float(time[lost[0]]) if lost.size else None,
            "last_lost_at_s": float(time[lost[-1]]) if lost.size else None,
            "status": STATUSES[int(columns["status"][-1])],
            "innovation": float(columns["innovation"].mean()),
            **({} if is_known else {"fitted": True}),
            "feeds": experiment.estimator.feedback,
            "observability": dict(observed),
            "per_signal": {
                hat: _errors(columns[q] - columns[hat], columns[sd], c.unit)
                for q, hat, sd, c in zip(
                    coordinate_signals("q", robot),
                    coordinate_signals(ESTIMATE["q"], robot),
                    coordinate_signals(ESTIMATE["sd"], robot),
                    robot.coordinates,
                    strict=True,
                )
                if is_known and {q, hat, sd} <= set(columns)
            },
        }
    }


def _errors(error: FloatArray, sd: FloatArray, unit: str) -> dict[str, Any]:
    is_within = np.abs(error) <= 3.0 * sd
    return {
        "rms": float(np.sqrt(np.mean(error**2))),
        "max": float(np.abs(error).max()),
        "largest_sd": float(sd.max()),
        "within_3_sd": float(is_within.mean()),
        "unit": unit,
    }
