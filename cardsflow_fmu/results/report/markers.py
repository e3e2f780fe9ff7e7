"""Motion-capture markers: positions on a robot and measured positions."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from addin_sdfusion.robot import InputError
from cardsflow_fmu.experiment.config.file import read_settings
from cardsflow_fmu.experiment.config.table import Context, Table, Text, Vector3, setting
from cardsflow_fmu.utils.arrays import FloatArray
from cardsflow_fmu.utils.csv_table import read_csv
from sim_dart.calibration.markers import Marker
from sim_dart.calibration.recordings import Recording


class MarkerSettings(Table):
    """Position of a marker on a link."""

    link: Text = setting("link that carries the marker")
    position: Vector3 = setting("position in the link frame, in m")


def read_markers(file: Path) -> tuple[Marker, ...]:
    """Read a table of markers: `[elbow]`, `link = "upper_arm"`, `position = [0.0, 0.0, 0.1]`.

    Raises:
        InputError: The table is invalid; the message names the marker.
    """
    context = Context(file)
    markers = []
    for name, data in read_settings(file).items():
        settings = MarkerSettings.read(data, context, name)
        markers.append(Marker(name, settings.link, settings.position))
    if not markers:
        raise InputError("has no markers; add a table with link and position for each", file=file)
    return tuple(markers)


def read_capture(file: Path) -> dict[str, FloatArray]:
    """Read the columns of a motion-capture table; empty fields are NaN."""
    names, rows = read_csv(file, kind="motion-capture table", blanks=True)
    if "time" not in names:
        raise InputError("has no column 'time'", file=file)
    return dict(zip(names, rows.T, strict=True))


def resample(
    readings: Recording, first: float, times: FloatArray, markers: FloatArray
) -> Recording:
    """Resample measurements at the times of motion capture; tensions are averaged over the steps.

    Args:
        first: Time of the first measurement, in [s].
        times: Times of motion capture, with equal steps, shape (K,), in [s].
        markers: Marker positions, shape (K, 3 M), in [m].
    """
    measured = first + readings.step * np.arange(len(readings.q) + 1)
    step = float(times[1] - times[0])

    def at(values: FloatArray) -> FloatArray:
        rows = (np.interp(times, measured[:-1], one, np.nan, np.nan) for one in values.T)
        return np.stack([*rows], axis=1) if values.shape[1] else np.zeros((len(times), 0))

    def mean(values: FloatArray) -> FloatArray:
        lost = np.isnan(values)
        sums = [np.where(lost, 0.0, values), lost.astype(float)]
        total, gaps = (
            readings.step * np.vstack([np.zeros(values.shape[1]), np.cumsum(one, axis=0)])
            for one in sums
        )
        ends = np.append(times, times[-1] + step)
        inside = (ends[:-1] >= measured[0]) & (ends[1:] <= measured[-1] + 1e-9)
        means = np.full((len(times), values.shape[1]), np.nan)
        for k in range(values.shape[1]):
            integral, lost_time = (
                np.diff(np.interp(ends, measured, one[:, k])) for one in (total, gaps)
            )
            sound = inside & (lost_time < 1e-9)
            means[sound, k] = integral[sound] / step
        return means

    return replace(
        readings,
        step=step,
        q=at(readings.q),
        lengths=at(readings.lengths),
        tensions=mean(readings.tensions),
        torques=mean(readings.torques),
        markers=markers,
    )
