"""Calibration of a robot from recordings: calibrated robot, and report of all parameters."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import zip_longest
from pathlib import Path
from typing import Any

import numpy as np

from addin_sdfusion.robot import Finding, InputError
from addin_sdfusion.robot.files import write_files
from addin_sdfusion.robot.formats.convert import convert
from addin_sdfusion.robot.formats.read import read
from addin_sdfusion.robot.json_text import json_text
from cardsflow_fmu.experiment.settings.estimator import CALIBRATION_FILE
from cardsflow_fmu.utils.folder_lock import create_new_folder
from sim_dart.calibration.calibrate import Calibration, Errors, calibrate
from sim_dart.calibration.identifiability import (
    ParameterInformation,
    identifiable,
    unidentifiable_directions,
    without_effect,
)
from sim_dart.calibration.inertia import NUMBERS, inertia_numbers

from .markers import read_markers
from .readings import read_readings

REPORT = "calibration.txt"

_MAX_DIRECTIONS = 8


@dataclass(frozen=True)
class WrittenReport:
    """Report that was written to a folder, with other files.

    Attributes:
        text: Text of the report.
        findings: Findings on the robot, and on losses of the file format.
    """

    files: list[Path]
    text: str
    findings: Sequence[Finding]


def calibrate_files(
    recordings: Sequence[Path],
    robot: Path,
    parameters: Sequence[str],
    folder: Path,
    cable_set: str | None = None,
    markers: Path | None = None,
    captures: Sequence[Path] = (),
    progress: Callable[[int, int], None] | None = None,
) -> WrittenReport:
    """Calibrate a robot from recordings and write it as SDF with CARDSFlow muscles.

    The report is written as text and as JSON.

    Args:
        recordings: Recordings of motions; see `read_readings`. If there are several recordings, the
            last one is held out for validation.
        robot: Robot file or its folder; it is not changed.
        parameters: Patterns of the parameters; see `sim_dart.calibration.parameters.GROUPS`.
        folder: New or empty folder of the robot and the report.
        cable_set: Name of the cable set (default: as in the robot file).
        markers: Table of markers on the robot; see `read_markers`. None without markers.
        captures: Motion-capture tables, one per recording; empty if the recordings contain markers.
        progress: Called during the calibration with the completed work and its expected total.

    Raises:
        InputError: The recordings or the robot cannot be read, or do not identify the parameters.
            No file is written.
        CardsflowError: The result predicts the held-out data worse. No file is written.
    """
    with create_new_folder(folder, "calibration"):
        reading = read(robot, cable_set)
        nominal = reading.require()
        marker_list = () if markers is None else read_markers(markers)
        if captures and not marker_list:
            raise InputError(
                "contains markers; specify their positions with --markers", key="--capture"
            )
        if captures and len(captures) != len(recordings):
            problem = f"must be given once per recording: {len(recordings)} times"
            raise InputError(f"{problem}, not {len(captures)}", key="--capture")
        pairs = zip_longest(recordings, captures)
        readings = [read_readings(path, nominal, marker_list, capture) for path, capture in pairs]
        result = calibrate(nominal, readings, parameters, markers=marker_list, progress=progress)
        text, table = describe(result), _table(result)
        mesh_folder = reading.files[0].parent
        files, losses = convert(result.robot, "sdf", folder, mesh_folder=mesh_folder)
        files += write_files(
            folder, {REPORT: text + "\n", CALIBRATION_FILE: json_text(table, indent=1) + "\n"}
        )
        return WrittenReport(files, text, [*reading.findings, *losses])


def describe(result: Calibration) -> str:
    """Return the report as text."""
    is_known = identifiable(result)
    lines = [
        f"{len(is_known)} parameters from {result.windows} windows, {result.held_out} held out; "
        f"{is_known.sum()} identifiable, {(~is_known).sum()} determined by their priors",
        f"misfit      {result.misfit:.3g} (1: as expected from the noise)",
        "",
        "RMS of measurement minus simulation          before     after",
        *_error_lines("calibration", result.before, result.after),
        *_error_lines("held out", result.held_out_before, result.held_out_after),
        "",
        "parameter                                          change        sd",
    ]
    rows = zip(result.parameters, result.change, result.sd, is_known, strict=True)
    for one, change, sd, is_identifiable in rows:
        mark = "" if is_identifiable else "  unidentifiable: determined by its prior"
        lines.append(f"{one.name:45s} {change:11.4g} {sd:9.2g} {one.unit}{mark}")
    return "\n".join(
        [*lines, *_curvature_lines(result), *unidentifiable_lines(result), *warnings(result)]
    )


def _curvature_lines(result: Calibration) -> list[str]:
    """Return a line with the parameters whose standard deviation is dominated by curvature."""
    linear_sd = np.sqrt(np.diag(result.covariance))
    curved = [
        one.name
        for one, sd, bend in zip(result.parameters, linear_sd, result.curvature_sd, strict=True)
        if bend > sd
    ]
    if not curved:
        return []
    reason = "sd is dominated by a curved direction that hardly changes the measurements"
    return ["", f"{reason}: {', '.join(curved)}"]


def unidentifiable_lines(result: ParameterInformation) -> list[str]:
    """Describe unidentifiable parameters and directions, one line each."""
    names, directions, lines = _without_effect(result), unidentifiable_directions(result), []
    if names:
        lines += ["", f"no effect on the measurements: {', '.join(names)}"]
    if directions:
        lines += ["", f"{len(directions)} directions are unidentifiable; the least identifiable:"]
        lines += [f"  {direction}" for direction in directions[:_MAX_DIRECTIONS]]
    return lines


def _without_effect(result: ParameterInformation) -> list[str]:
    """Return the names of the parameters without effect on the measurements."""
    rows = zip(result.parameters, without_effect(result), strict=True)
    return [one.name for one, idle in rows if idle]


def warnings(result: Calibration) -> list[str]:
    """Return warnings about a result, one line each."""
    lines = [f"WARNING {note}" for note in result.notes]
    if not result.converged:
        lines.append(
            "WARNING not converged: the parameters may be inaccurate; calibrate fewer of them"
        )
    if result.misfit > 2.0:
        lines.append(
            f"WARNING the misfit is {result.misfit:.3g}: the robot differs in something "
            "that is not calibrated; the standard deviations are scaled accordingly"
        )
    return lines


def _error_lines(label: str, before: Errors, after: Errors) -> list[str]:
    def rms(values: Any) -> float:
        return float(np.sqrt(np.nanmean(values**2))) if np.isfinite(values).any() else np.nan

    return [
        f"{label:16s} {name:27s} {1e3 * rms(b):9.4g} {1e3 * rms(a):9.4g}"
        for name, b, a in (
            ("positions, mrad or mm", before.q, after.q),
            ("lengths, mm", before.lengths, after.lengths),
            ("markers, mm", before.markers, after.markers),
        )
        if len(b)
    ]


_ERRORS = {
    "before": "before",
    "after": "after",
    "kept_before": "held_out_before",
    "kept_after": "held_out_after",
}
"""Attributes of `Calibration` with errors, by their keys in the report."""


def _table(result: Calibration) -> dict[str, Any]:
    return {
        "misfit": result.misfit,
        "converged": result.converged,
        "windows": result.windows,
        "windows_kept_out": result.held_out,
        "errors": {
            key: {kind: _rms(result, name, kind) for kind in ("q", "lengths", "markers")}
            for key, name in _ERRORS.items()
        },
        "parameters": [
            {
                "name": one.name,
                "unit": one.unit,
                "change": float(change),
                "sd": float(sd),
                "bend": float(bend),
                "prior_sd": one.sd,
                "identifiable": bool(seen),
            }
            for one, change, sd, bend, seen in zip(
                result.parameters,
                result.change,
                result.sd,
                result.curvature_sd,
                identifiable(result),
                strict=True,
            )
        ],
        "offsets": {
            one.name.split(".")[1]: float(change)
            for one, change in zip(result.parameters, result.change, strict=True)
            if one.kind == "offset"
        },
        "inertias": {
            link.name: dict(zip(NUMBERS, inertia_numbers(link.inertia).tolist(), strict=True))
            for link in result.robot.links
        },
        "no_effect": _without_effect(result),
        "not_identifiable": [str(direction) for direction in unidentifiable_directions(result)],
        "warnings": warnings(result),
    }


def _rms(result: Calibration, name: str, kind: str) -> list[float | None]:
    """Return the RMS residuals of a kind, in SI units; None without a sensor."""
    errors = getattr(getattr(result, name), kind)
    return [None if np.isnan(one) else float(one) for one in errors]
