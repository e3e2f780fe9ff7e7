"""Conversion of runs and hardware recordings to MCAP files with ROS 2 messages."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from itertools import chain
from pathlib import Path
from typing import NamedTuple

import numpy as np

from addin_sdfusion.robot import InputError
from addin_sdfusion.robot.files import replace_file
from cardsflow_fmu.hardware.protocol.recording import HardwareRecording, read_recording
from cardsflow_fmu.results.files import EXPERIMENT
from cardsflow_fmu.results.run_data import ExperimentRunData, RunData
from cardsflow_fmu.results.saved_run import open_results, opened_run
from cardsflow_fmu.ros_interface.message_types import require_ros
from cardsflow_fmu.utils.overwrite import output_file

from .diagnostics import TOPIC as DIAGNOSTICS
from .diagnostics import run_diagnostics
from .mcap_file import McapWriter
from .scene_topics import SceneTopics, ShownRobot
from .topics import RowTopics, nanoseconds

SUFFIX = ".mcap"

_NO_ROBOT = (
    "the robot is unknown: the recording contains no description, frames, cables, efforts and "
    f"rates of lengths; an {EXPERIMENT} in the same folder specifies the robot"
)
_EXTRA = {"age": "s", "round_trip_time": "s", "seq": "", "flags": ""}
"""Additional columns of a hardware recording, with units."""

_BLOCK = 4096
"""Number of rows whose messages are in memory at the same time."""


class McapRecording(NamedTuple):
    """Summary of a written recording.

    Attributes:
        notes: Lines about parts of the run that the recording does not contain.
    """

    file: Path
    topics: tuple[str, ...]
    notes: tuple[str, ...]


def convert_run(path: str | Path, file: str | Path, *, overwrite: bool = False) -> McapRecording:
    """Convert the results of a run, or a hardware recording, to an MCAP file.

    Args:
        path: Results folder of a run, its table, or a hardware.rec.
        file: MCAP file to write. A file that CARDSFlow has written is overwritten.
        overwrite: Whether to replace a file that CARDSFlow did not write.

    Raises:
        InputError: There is no run, a package of the extra `ros2` is missing, or the file cannot be
            written.
    """
    require_ros("--to")
    target = output_file(file, (SUFFIX,), overwrite=overwrite)
    with _opened_run_data(Path(path)) as run:
        return write_recording(run, target)


@np.errstate(over="ignore", invalid="ignore")  # a run may have diverged
def write_recording(run: RunData, file: Path) -> McapRecording:
    """Write a run as an MCAP file; see `convert_run`."""
    if not len(run.rows):
        raise InputError("the run has no rows to record")
    robot = run.experiment.robot if isinstance(run, ExperimentRunData) else None
    rows = RowTopics(run, robot)
    scene = (
        SceneTopics(ShownRobot.from_experiment(run.experiment))
        if isinstance(run, ExperimentRunData)
        else None
    )
    frames = scene.frame_rows(run) if scene else np.zeros(0, dtype=np.int64)
    max_tension = scene.max_tension(run, frames) if scene else 0.0
    topics = (*(scene.topics if scene else ()), *rows.topics, DIAGNOSTICS)
    with replace_file(file) as stream, McapWriter(stream, topics) as writer:
        if scene is not None:
            writer.attach(scene.meshes)
            writer.write(scene.first(run["time"][:1]))
        diagnostics = list(run_diagnostics(run))
        for first in range(0, len(run.rows), _BLOCK):
            end = min(first + _BLOCK, len(run.rows))
            last = int(nanoseconds(run["time"][end - 1 : end])[0])
            due = sum(int(batch.time_ns[0]) <= last for batch in diagnostics)
            block_frames = frames[slice(*np.searchsorted(frames, [first, end]))]
            scene_batches = scene.batches(run, block_frames, max_tension) if scene else ()
            writer.write(chain(diagnostics[:due], rows.batches(first, end), scene_batches))
            del diagnostics[:due]
    notes = [str(finding) for finding in scene.findings] if scene else [_NO_ROBOT]
    return McapRecording(file, tuple(topic.name for topic in topics), tuple(notes))


@contextlib.contextmanager
def _opened_run_data(path: Path) -> Iterator[RunData]:
    if path.suffix != ".rec":
        with open_results(path) as run:
            yield run
        return
    run = hardware_run(read_recording(path))
    if not (path.parent / EXPERIMENT).is_file():
        yield run
        return
    with opened_run(path.parent) as saved:
        yield ExperimentRunData(**vars(run), experiment=saved.experiment)


def hardware_run(recording: HardwareRecording) -> RunData:
    """Return a hardware recording as run data."""
    header = recording.header
    names = ("time", *header.command_names, *header.state_names, *_EXTRA)
    units = ("s", *header.command_units, *header.state_units, *_EXTRA.values())
    extra = (recording.age, recording.round_trip, recording.seq, recording.flags)
    rows = np.column_stack([recording.t, recording.commands, recording.states, *extra])
    summary = {"status": "complete"}
    if recording.lost_bytes:
        problem = f"{recording.lost_bytes} bytes after the last valid record are lost"
        summary = {"status": "incomplete", "error": problem}
    return RunData(names, rows, dict(zip(names, units, strict=True)), summary)
