"""Views of results and robots, in the browser or as HTML page."""

from __future__ import annotations

import time
import webbrowser
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from addin_sdfusion.robot import Finding, InputError, Robot
from addin_sdfusion.robot.formats.read import holds_robot, read
from cardsflow_fmu.cosim.signals.ports import muscle_signals
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.experiment.packed_files import omitted_meshes
from cardsflow_fmu.results.estimation import describe_event
from cardsflow_fmu.results.run_data import ExperimentRunData, RunData
from cardsflow_fmu.results.saved_run import is_run, opened_run, require_not_experiment
from cardsflow_fmu.results.verdict import failure_text
from cardsflow_fmu.utils.interrupts import collect_interrupts
from cardsflow_fmu.utils.overwrite import output_file, write_output

from .html.page import replay_page
from .html.play_page import robot_page
from .live.page_server import Action, Page, page_server
from .scene.act import Act
from .scene.meshes import link_meshes
from .scene.motion import Motion, motion_of, shown_signals
from .scene.stage import Stage

PAGES = (".html", ".htm")
"""Suffixes of HTML pages."""

NoteFindings = Callable[[Sequence[Finding]], object]


def run_act(path: str | Path, *, full_scale: bool = False) -> Act:
    """Return the motion of the run in a results folder; `full_scale` as for `acts_of`."""
    with opened_run(path) as result:
        return act_of(result, full_scale=full_scale)


def act_of(result: ExperimentRunData, *, full_scale: bool = False) -> Act:
    """Return the motion of a run."""
    experiment = result.experiment
    meshes = link_meshes(experiment.robot, experiment.folder, experiment.roots)
    world = experiment.scene
    motion = motion_of(experiment.robot, result, world=world)
    stage = Stage(experiment.robot, motion, meshes, world=world, full_scale=full_scale)
    title = str(result.summary.get("experiment", experiment.name))
    faults = result.summary.get("faults") or ()
    events = tuple((event["time"], describe_event(event)) for event in faults)
    return Act(stage, title, notes(result), shown_signals(result), events)


def experiment_act(experiment: Experiment) -> Act:
    """Return the robot of an experiment in its initial state, with its surroundings."""
    robot, world = experiment.robot, experiment.scene
    meshes = link_meshes(robot, experiment.folder, experiment.roots)
    stage = Stage(robot, Motion.still(experiment.start.q), meshes, world=world)
    return Act(stage, experiment.name, tuple(experiment.warnings()))


def robot_act(
    path: str | Path, cable_set: str | None = None, *, note: NoteFindings | None = None
) -> Act:
    """Return a robot in its initial pose.

    Args:
        path: Robot file or its folder.
        cable_set: Name of the cable set (default: as in the robot file).
        note: Called with notes on the files, such as missing meshes.
    """
    reading = read(path, cable_set)
    robot = reading.require()
    if note is not None:
        note(reading.findings)
    return still_act(robot, reading.files[0].parent)


def still_act(robot: Robot, folder: Path | None = None) -> Act:
    """Return a robot in its initial pose."""
    meshes = {} if folder is None else link_meshes(robot, folder)
    hidden = () if folder is None else tuple(omitted_meshes(robot, folder, [folder]))
    stage = Stage(robot, Motion.initial(robot), meshes)
    lengths = dict(zip(muscle_signals("l", robot), stage.muscle_lengths.T, strict=True))
    return Act(stage, robot.name, hidden, lengths)


def notes(result: RunData) -> tuple[str, ...]:
    """Return notes on a run: warnings, tracking error, completeness."""
    failed = failure_text(result.summary)
    lines = [] if failed is None else [failed]
    lines += [f"warning: {warning}" for warning in result.summary.get("warnings") or ()]
    tracking = result.summary.get("tracking") or {}
    if tracking.get("rms") is not None:
        lines.append(f"RMS tracking error {tracking['rms']:.3g} {tracking.get('unit', '')}")
    if result.summary.get("status") == "incomplete":
        lines.append("incomplete run")
    return tuple(lines)


def page_of(acts: Sequence[Act]) -> str:
    """Return the page of motions, side by side, or of a robot at rest with joint sliders."""
    act = acts[0]
    if act.stage.motion.tensions is not None or not act.stage.robot.coordinates:
        return replay_page(acts)
    try:
        return robot_page(act)
    except InputError as error:
        note = f"warning: the joints cannot be moved: {error.problem}"
        return replay_page([replace(act, notes=(note, *act.notes))])


def write_page(acts: Sequence[Act], file: str | Path, *, overwrite: bool = False) -> Path:
    """Write a self-contained HTML page that shows motions side by side, or a robot."""
    return write_html(page_of(acts), file, overwrite=overwrite)


def write_html(page: str, file: str | Path, *, overwrite: bool = False) -> Path:
    """Write a page."""
    return write_output(output_file(file, PAGES, overwrite=overwrite), page)


def serve(
    page: Page,
    *,
    port: int | None = None,
    browser: bool = True,
    report: Callable[[str], object] = print,
    actions: Mapping[str, Action] | None = None,
    token: str = "",
) -> None:
    """Serve a page on loopback until Ctrl-C; see `page_server`.

    Args:
        port: The port (default: the first free port from 8080).
        report: Called with a line that contains the address.
    """
    with collect_interrupts() as received, page_server(page, port, actions, token) as server:
        announce(server.address, browser=browser, report=report)
        wait_for_interrupt(received)


def announce(address: str, *, browser: bool, report: Callable[[str], object]) -> None:
    """Report the address of a page, and open it in the browser."""
    report(f"{address}  (press Ctrl-C to stop)")
    if browser:
        webbrowser.open(address)


def wait_for_interrupt(received: Sequence[int]) -> None:
    """Wait until Ctrl-C is pressed; see `collect_interrupts`."""
    while not received:
        time.sleep(0.1)


def acts_of(
    paths: Sequence[str | Path],
    *,
    cable_set: str | None = None,
    full_scale: bool = False,
    note: NoteFindings | None = None,
) -> list[Act]:
    """Return the motions of one or two runs, or a robot.

    Args:
        paths: Results folders, or a single robot.
        cable_set: Name of the cable set of a robot (default: as in the robot file).
        full_scale: Whether colours range to f_max instead of the maximum tension of the run.
        note: As for `robot_act`.
    """
    for path in paths:
        if Path(path).suffix == ".ssp":
            raise InputError("is a system of FMUs; run it, and view its results", file=path)
        if not is_run(Path(path)) and not holds_robot(Path(path)):
            require_not_experiment(Path(path))
    runs = [is_run(Path(path)) for path in paths]
    if len(paths) > 1 and not all(runs):
        odd = paths[runs.index(False)]
        raise InputError(
            "is not a results folder; only results can be shown side by side", file=odd
        )
    if all(runs):
        if cable_set is not None:
            problem = "is only for a robot; a run shows its own cable set"
            raise InputError(problem, key="--cable-set")
        return [run_act(path, full_scale=full_scale) for path in paths]
    return [robot_act(paths[0], cable_set, note=note)]
