"""Summary of state estimates, changed length offsets, detected faults and the reactions to them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from addin_sdfusion.robot import InputError
from addin_sdfusion.robot.json_text import json_text
from cardsflow_fmu.cosim.signals.estimation import ESTIMATE, OFFSET, OFFSET_SD, VALID
from cardsflow_fmu.cosim.signals.port import muscle_signals
from cardsflow_fmu.cosim.signals.ports import coordinate_signals
from cardsflow_fmu.cosim.signals.reaction import DECISIONS, FAULTS, LOST, PARTS, REACTION, SPEED
from cardsflow_fmu.experiment.config.file import read_settings
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.experiment.settings.estimator import CALIBRATION_FILE
from cardsflow_fmu.utils.arrays import FloatArray
from sim_dart.estimation.estimator import NOT_CONVERGED, STATUSES

UPDATED_CALIBRATION = "calibration_updated.json"
"""Name of the file with changed length offsets in a results folder."""
_EVIDENCE = ("statistic", "threshold", "confidence", "value")


def fault_events(columns: Mapping[str, FloatArray]) -> list[dict[str, Any]]:
    """Return the detected faults and the decisions about them, in the order of time."""
    events: list[tuple[int, dict[str, Any]]] = []
    for name, values in columns.items():
        prefix, _, part = name.partition(".")
        if prefix not in PARTS or not part:
            continue
        for row in _changes(values):
            evidence = {
                key: float(columns[f"fault_{key}"][row])
                for key in _EVIDENCE
                if f"fault_{key}" in columns
            }
            kind = FAULTS.get(int(values[row]), "unknown")
            fault = {"part": f"{PARTS[prefix]} {part}", "kind": kind.replace("_", " ")}
            events.append((row, fault | evidence))
    if REACTION in columns:
        for row in sorted(
            {*_changes(columns[REACTION]), *_changes(columns.get(LOST, np.empty(0)))}
        ):
            decision: dict[str, Any] = {
                "decision": DECISIONS.get(int(columns[REACTION][row]), "unknown")
            }
            if SPEED in columns:
                decision["speed"] = float(columns[SPEED][row])
            events.append((row, decision))
    return [
        {"time": float(columns["time"][row])} | event
        for row, event in sorted(events, key=lambda pair: pair[0])
    ]


def describe_event(event: Mapping[str, Any]) -> str:
    """Return a detected fault or a decision as text."""
    if "decision" in event:
        speed = f" to {event['speed']:.0%} of the speed" if event.get("speed", 0.0) % 1.0 else ""
        return f"at {event['time']:.6g} s decision: {event['decision']}{speed}"
    how_sure = f" (confidence {event['confidence']:.1%})" if "confidence" in event else ""
    return f"at {event['time']:.6g} s {event['part']}: {event['kind']}{how_sure}"


def _changes(values: FloatArray) -> list[int]:
    """Return the rows at which a number that begins with 0 changes to another one than 0."""
    before = np.concatenate([[0.0], values[:-1]])
    return [int(k) for k in np.flatnonzero((values != before) & (values != 0.0))]


def estimation_summary(
    experiment: Experiment, columns: Mapping[str, FloatArray], observed: Mapping[str, Any]
) -> dict[str, Any]:
    """Return errors, standard deviations, innovations and validity; empty without an estimate.

    Hardware without joint encoders has no ground truth, so that the errors are unknown. `fitted`
    marks positions that were fitted to muscle lengths.
    """
    if experiment.estimator is None or VALID not in columns or not len(columns[VALID]):
        return {}
    hardware = experiment.hardware
    is_known = hardware.has_positions or not hardware.use
    robot, valid, time = experiment.robot, columns[VALID] != 0, columns["time"]
    lost = np.flatnonzero(~valid)
    is_unsolved = columns["status"] == STATUSES.index(NOT_CONVERGED)
    return {
        "estimation": {
            "valid_share": float(valid.mean()),
            "first_lost_at_s": float(time[lost[0]]) if lost.size else None,
            "last_lost_at_s": float(time[lost[-1]]) if lost.size else None,
            "status": STATUSES[int(columns["status"][-1])],
            "innovation": float(columns["innovation"].mean()),
            "not_converged_share": float(is_unsolved.mean()),
            **({} if is_known else {"fitted": True}),
            "feeds": experiment.estimator.feedback,
            "observability": dict(observed),
            **_offsets(experiment, columns),
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


def _offsets(experiment: Experiment, columns: Mapping[str, FloatArray]) -> dict[str, Any]:
    """Return the length offsets of the last valid estimate; empty if they are constant.

    An offset is observed if the measurements at least halve its standard deviation.
    """
    settings = experiment.estimator
    valid = np.flatnonzero(columns[VALID])
    if settings is None or settings.offset is None or not valid.size:
        return {}
    time, rows = float(columns["time"][valid[-1]]), {}
    names = zip(
        *(muscle_signals(key, experiment.robot) for key in (OFFSET, OFFSET_SD)), strict=True
    )
    for k, (offset, sd) in enumerate(names):
        if {offset, sd} <= set(columns):
            prior = np.hypot(settings.start_offset_sd[k], settings.offset_drift[k] * np.sqrt(time))
            after = float(columns[sd][valid[-1]])
            rows[experiment.robot.muscles[k].name] = {
                "start": settings.offset[k],
                "end": float(columns[offset][valid[-1]]),
                "sd": after,
                "observed": bool(after < prior / 2),
            }
    return {"offsets": rows} if rows else {}


def changed_offsets(summary: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """Return the observed length offsets that changed by more than three standard deviations."""
    rows = (summary.get("estimation") or {}).get("offsets") or {}
    return {
        name: row
        for name, row in rows.items()
        if row["observed"] and abs(row["end"] - row["start"]) > 3.0 * row["sd"]
    }


def updated_calibration(experiment: Experiment, summary: Mapping[str, Any]) -> dict[str, str]:
    """Return a calibration with the changed offsets by file name; empty if none has changed.

    It contains the calibration in the folder of the robot, which is not changed, with new offsets.
    """
    changed = changed_offsets(summary)
    if not changed:
        return {}
    try:
        data = read_settings(experiment.folder / CALIBRATION_FILE)
    except InputError:  # no calibration so far, or a damaged one
        data = {}
    rows = summary["estimation"]["offsets"]
    new = {name: row["end" if name in changed else "start"] for name, row in rows.items()}
    parameters = {f"muscles.{name}.offset": row for name, row in changed.items()}
    entries = data.get("parameters")
    for one in entries if isinstance(entries, list) else ():
        if isinstance(one, dict) and (row := parameters.get(str(one.get("name")))):
            one |= {"change": row["end"], "sd": row["sd"]}
    return {UPDATED_CALIBRATION: json_text({**data, "offsets": new}, indent=1) + "\n"}


def _errors(error: FloatArray, sd: FloatArray, unit: str) -> dict[str, Any]:
    is_within = np.abs(error) <= 3.0 * sd
    return {
        "rms": float(np.sqrt(np.mean(error**2))),
        "max": float(np.abs(error).max()),
        "largest_sd": float(sd.max()),
        "within_3_sd": float(is_within.mean()),
        "unit": unit,
    }
