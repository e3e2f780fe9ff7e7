"""Names and contents of the files of a run."""

from __future__ import annotations

import io

import numpy as np

from addin_sdfusion.robot.json_text import json_text
from cardsflow_fmu.utils.csv_table import csv_text

from .run_data import RunData

TABLE = "results.csv"
NPY = "results.npy"
"""Name of a large table: the rows as an array; the names are the keys of `UNITS`."""
UNITS = "results.units.json"
SUMMARY = "summary.json"
MCAP = "recording.mcap"
RECORDING_FILE = "hardware.rec"
"""Name of the recording of hardware exchanges."""
SOLVE_TIMES, NPY_SOLVE_TIMES = "solve_times.csv", "solve_times.npy"
EXPERIMENT = "experiment.zip"
"""Name of the archive with the experiment, robot files and visual meshes."""

Contents = dict[str, str | bytes]


def metadata_files(run: RunData, *, is_large: bool = False) -> Contents:
    """Return the files with units, summary, and computation times if known.

    Args:
        is_large: Whether computation times are an array (.npy) instead of CSV.
    """
    files: Contents = {
        UNITS: json_text(dict(run.units), indent=1) + "\n",
        SUMMARY: json_text(run.summary, indent=1) + "\n",
    }
    if len(run.solve_times) and is_large:
        memory = io.BytesIO()
        np.save(memory, run.solve_times)
        files[NPY_SOLVE_TIMES] = memory.getvalue()
    elif len(run.solve_times):
        files[SOLVE_TIMES] = csv_text(("time", "solve_time"), run.solve_times)
    return files
