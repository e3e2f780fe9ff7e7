"""Recordings of runs and of hardware, as MCAP with messages of ROS 2."""

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
from .scene_topics import SceneTopics, Shown
from .topics import RowTopics, nanoseconds

SUFFIX = ".mcap"

_NO_ROBOT = (
    "the robot is not known: without description, frames, cables, efforts and rates of lengths; "
    f"beside an {EXPERIMENT} they are there"
)
_EXTRA = {"age": "s", "round_trip_time": "s", "seq": "", "flags": ""}
"""What a recording of hardware has next to the signals, with units."""

_BLOCK = 4096
"""Rows whose messages are in memory at once."""


class Recorded(NamedTuple):
    """What a recording holds.

    Attributes:
        file: The recording.
        topics: Names of its topics.
        notes: What of the run it does not hold, a line each.
    """

    file: Path
    topics: tuple[str, ...]
    notes: tuple[str, ...]


def convert_run(path: str | Path, file: str | Path) -> Recorded:
    """Write what a run has left as a recording.

    Args:
        path: The folder of a run, its table, or a hardware.rec.
        file: The recording; one of ours is replaced.

    Raises:
        InputError: There is no run, a package of the extra `ros2` is missing, or the file cannot be
            written.
    """
    require_ros("--to")
    place = output_file(file, (SUFFIX,))
    with _opened(Path(path)) as run:
        return write_recording(run, place)


@np.errstate(over="ignore", invalid="ignore")  # of a run that diverged
def write_recording(run: RunData, file: Path) -> Recorded:
    """Write a run as a recording; see `convert_run`.

    Args:
        run: The run; what needs its robot is left out if that is not known.
        file: The recording.
    """
    if not len(run.rows):
        raise InputError("the run gave no rows: there is nothing to record")
    robot = run.experiment.robot if isinstance(run, ExperimentRunData) else None
    rows = RowTopics(run, robot)
    scene = SceneTopics(Shown.of(run.experiment)) if isinstance(run, ExperimentRunData) else None
    frames = scene.frame_rows(run) if scene else np.zeros(0, dtype=np.int64)
    highest = scene.highest(run, frames) if scene else 0.0
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
            here = frames[slice(*np.searchsorted(frames, [first, end]))]
            seen = scene.batches(run, here, highest) if scene else ()
            writer.write(chain(diagnostics[:due], rows.batches(first, end), seen))
            del diagnostics[:due]
    notes = [str(finding) for finding in scene.findings] if scene else [_NO_ROBOT]
    return Recorded(file, tuple(topic.name for topic in topics), tuple(notes))


@contextlib.contextmanager
def _opened(path: Path) -> Iterator[RunData]:
    if path.suffix != ".rec":
        with open_results(path) as run:
            yield run
        return
    run = hardware_run(read_recording(path))
    if not (path.parent / EXPERIMENT).is_file():
        yield run
        return
    with opened_run(path.parent) as own:
        yield ExperimentRunData(**vars(run), experiment=own.experiment)


def hardware_run(recording: HardwareRecording) -> RunData:
    """Return a recording of hardware as data of a run."""
    about = recording.header
    names = ("time", *about.command_names, *about.state_names, *_EXTRA)
    units = ("s", *about.command_units, *about.state_units, *_EXTRA.values())
    extra = (recording.age, recording.round_trip, recording.seq, recording.flags)
    rows = np.column_stack([recording.t, recording.commands, recording.states, *extra])
    summary = {"status": "complete"}
    if recording.lost_bytes:
        what = f"{recording.lost_bytes} bytes behind the last whole record are lost"
        summary = {"status": "incomplete", "error": what}
    return RunData(names, rows, dict(zip(names, units, strict=True)), summary)
