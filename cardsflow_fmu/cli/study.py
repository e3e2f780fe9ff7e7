"""`cardsflow study` and `optimise`: many runs of one experiment, and optimal motions."""

from __future__ import annotations

import argparse
import shlex
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from addin_sdfusion.robot.json_text import json_text

from .common import (
    FAILED,
    GOOD,
    add_experiment,
    add_json,
    add_output,
    add_overwrite,
    parse_settings,
    print_files,
    use_one_thread,
)
from .parser import Commands
from .terminal.messages import print_note, print_warning
from .terminal.progress import show_progress

if TYPE_CHECKING:
    from cardsflow_fmu.experiment.experiment import Experiment
    from cardsflow_fmu.simulation.optimal.optimise import OptimisedMotion
    from cardsflow_fmu.studies.run import StudyResult
    from controllers.optimal.sqp import Progress


_MAX_ERRORS = 5  # lines about failed runs, and bounds of a motion
_SLOW = 2.0  # time of an iteration with which a note states faster settings, in [s]


def add_study(commands: Commands) -> None:
    """Add `study`."""
    parser = commands.add(
        "study",
        _study,
        "Run many variants of an experiment, or optimise its parameters.",
        "cardsflow study examples/design_study/attachments.toml -j 2",
        "It writes a table, a report, and a file for each run, so that it can be resumed.",
    )
    parser.add_argument("study", type=Path, help="a study.toml or its folder")
    text = "number of parallel runs (default: one per core)"
    parser.add_argument("-j", "--jobs", type=int, metavar="N", help=text)
    text = "folder for runs, table and report (default: next to the study)"
    add_output(parser, text, metavar="FOLDER")
    parser.add_argument(
        "--resume", action="store_true", help="continue a study; keep finished runs (default: off)"
    )
    text = "repeat only the run whose hash starts with HASH; write nothing (default: all runs)"
    parser.add_argument("--only", metavar="HASH", help=text)
    add_json(parser, "the summary")


def _study(options: argparse.Namespace) -> int:
    from cardsflow_fmu.studies.analysis.summary import summary_text
    from cardsflow_fmu.studies.definition.study import Study
    from cardsflow_fmu.studies.run import run_study

    study = Study.load(options.study)
    if options.only is not None:
        return _only(options)
    with show_progress("study", "runs") as update:
        result = run_study(
            study,
            jobs=options.jobs,
            resume=options.resume,
            output=options.output,
            progress=update,
        )
    if options.json:
        print(summary_text(result.summary), end="")
    else:
        for warning in result.summary["warnings"]:
            print_warning(warning)
        _print(result)
    has_found = study.optimise is None or result.summary["best"] is not None
    return GOOD if result.summary["complete"] and has_found else FAILED


def _only(options: argparse.Namespace) -> int:
    from cardsflow_fmu.studies.definition.study import Study
    from cardsflow_fmu.studies.run import repeat_run

    command, outcome = repeat_run(Study.load(options.study), options.only, options.output)
    print(command, file=sys.stderr)
    row = {"status": "complete" if outcome.complete else "failed", "error": outcome.error}
    print(json_text(row | {"metrics": outcome.metrics}, indent=1))
    return GOOD if outcome.complete else FAILED


def _print(result: StudyResult) -> None:
    summary = result.summary
    print(f"{summary['study']}: {summary['runs']} runs, {summary['failed']} failed")
    if others := summary.get("other_runs"):
        print(f"  {others} other runs in the folder belong to another study and are not used")
    for error, count in list(summary["failures"].items())[:_MAX_ERRORS]:
        print(f"  {count} failed: {error}")
    for name, numbers in summary["metrics"].items():
        print(
            f"  {name:<24} median {numbers['median']:.4g}, 5 to 95 % {numbers['p05']:.4g} to "
            f"{numbers['p95']:.4g}, {numbers['min']:.4g} to {numbers['max']:.4g}"
        )
    if "best" in summary:
        best = summary["best"]
        line = "best: no run meets the constraints"
        if best is not None:
            run = f"run {best['run']} ({best['hash']})"
            line = f"best: {best['objective']:.6g} in {run}; robot: best/"
        print(line)
    for name, path in sorted(result.files.items()):
        print(f"{name:<18} {path}")


def add_optimise(commands: Commands) -> None:
    """Add `optimise`."""
    parser = commands.add(
        "optimise",
        _optimise,
        "Compute the optimal motion of an experiment with [motion].",
        "cardsflow optimise examples/co_design -o motion.csv",
        "It writes the motion, its feedback gains, and a figure. An experiment follows it with "
        '`reference.type = "optimised"`. Ctrl-C keeps the motion if it nearly satisfies '
        "the constraints.",
    )
    add_experiment(parser)
    text = "file of the motion (default: motion.csv next to the experiment)"
    add_output(parser, text, metavar="FILE")
    text = "start from the motion in this file, also after Ctrl-C (default: off)"
    parser.add_argument("--resume", action="store_true", help=text)
    text = "write a report with a replay as a self-contained HTML page (default: none)"
    parser.add_argument("--html", type=Path, metavar="FILE", help=text)
    add_overwrite(parser)
    add_json(parser, "cost, duration, iterations, active bounds and files")


def _optimise(options: argparse.Namespace) -> int:
    use_one_thread()
    from cardsflow_fmu.simulation.optimal.diagnosis import active_bounds
    from cardsflow_fmu.simulation.optimal.files import motion_file, write_motion_files
    from cardsflow_fmu.simulation.optimal.optimise import load_for_motion, optimise
    from cardsflow_fmu.utils.overwrite import output_file

    experiment = load_for_motion(options.experiment, parse_settings(options.set))
    file = motion_file(experiment, options.output, overwrite=options.overwrite)
    if options.html is not None:
        output_file(options.html, [".html"], overwrite=options.overwrite)
    iterations = _Iterations(experiment)
    motion = optimise(experiment, iterations, resume=file if options.resume else None)
    for note in motion.notes:
        print_note(note)
    files: tuple[Path, ...] = write_motion_files(motion, file, overwrite=options.overwrite)
    if options.html is not None:
        files = (*files, _write_report(options, motion))
    if motion.parameters:
        files = (*files, _write_robot(options, motion.parameters, file))
    solution = motion.solution
    active = active_bounds(motion.problem, solution)
    bounds = {name: float(is_at.mean()) for name, (_, is_at) in active.items()}
    if not options.json:
        _print_motion(motion)
        _print_bounds(bounds)
    numbers: dict[str, Any] = {"cost": solution.cost, "duration": motion.duration}
    numbers |= {"iterations": motion.iterations, "active_bounds": bounds}
    if motion.parameters:
        numbers["parameters"] = motion.parameters
    warnings = list(motion.warnings)
    print_files(files, options.json, status=solution.status, warnings=warnings, **numbers)
    if not options.json:
        print(f"next        {shlex.join(_next_command(options, files, motion))}")
    return FAILED if motion.warnings else GOOD


def _write_robot(options: argparse.Namespace, parameters: Mapping[str, Any], motion: Path) -> Path:
    """Write the robot with found parameters, and an experiment in which it follows the motion."""
    from cardsflow_fmu.experiment.experiment import Experiment
    from cardsflow_fmu.simulation.optimal.files import robot_folder
    from cardsflow_fmu.studies.analysis.best_robot import EXPERIMENT, MUSCLES, write_best

    folder = robot_folder(motion)
    reference = {"type": "optimised", "file": str(motion.resolve())}
    settings = {**parse_settings(options.set), **parameters, "reference": reference}
    for note in write_best(Experiment.load(options.experiment, settings), folder):
        is_lost = note.startswith(("sdf: not written", EXPERIMENT))
        (print_warning if is_lost else print_note)(note)
    file = folder / EXPERIMENT
    return file if file.exists() else folder / MUSCLES


def _write_report(options: argparse.Namespace, motion: OptimisedMotion) -> Path:
    """Write the report of a motion, for the robot with the found parameters."""
    from cardsflow_fmu.simulation.optimal.files import write_motion_report
    from cardsflow_fmu.simulation.optimal.optimise import load_for_motion

    settings = {**parse_settings(options.set), **motion.parameters}
    experiment = load_for_motion(options.experiment, settings)
    return write_motion_report(motion, experiment, options.html, overwrite=options.overwrite)


def _next_command(
    options: argparse.Namespace, files: Sequence[Path], motion: OptimisedMotion
) -> list[str]:
    """Return the command that simulates the motion; with loops, the controller of the file."""
    from cardsflow_fmu.experiment.reader import follows_motion

    if files[-1].suffix == ".json":
        return ["cardsflow", "run", str(files[-1])]
    file = "" if options.output is None else f", file={json_text(str(files[0].resolve()))}"
    settings = [f'reference={{type="optimised"{file}}}']
    if not motion.problem.dynamics.robot.loops:
        settings.append('controller={type="trajectory_feedback"}')
    if not file and follows_motion(options.experiment, parse_settings(options.set)):
        settings = []
    options_given = [word for setting in (options.set or []) for word in ("--set", setting)]
    new = [word for setting in settings for word in ("--set", setting)]
    return ["cardsflow", "run", str(options.experiment), *options_given, *new]


class _Iterations:
    """Printer of iterations, below a heading, with the longest time that is left for them."""

    def __init__(self, experiment: Experiment) -> None:
        motion = experiment.motion
        self._most, self._has_heading = 0 if motion is None else motion.max_iterations, False
        self._has_laws, self._is_quick = motion is not None and motion.muscles == "laws", True

    def __call__(self, row: Progress, substeps: int) -> None:
        if not self._has_heading:
            heads = f"{'iteration':>9} {'cost':>13} {'infeasibility':>13} {'step':>6}"
            print_note(f"{heads} {'substeps':>8} {'time':>8} {'left <':>8}", prefix="")
            self._has_heading = True
        line = f"{row.iteration:>9} {row.cost:>13.6g} {row.violation:>13.2e} {row.share:>6.2g}"
        left = row.seconds / max(row.iteration, 1) * max(self._most - row.iteration, 0)
        line += f" {substeps:>8} {row.seconds:>6.2f} s {left:>6.0f} s"
        print_note(line, prefix="")
        if self._is_quick and row.seconds > _SLOW * row.iteration > _SLOW:
            from controllers.optimal.sqp import ROUGH

            self._is_quick = False
            forces = ' or motion.muscles = "forces"' if self._has_laws else ""
            text = f"for faster iterations, set fewer motion.intervals{forces}; Ctrl-C keeps the"
            print_note(f"{text} motion if its infeasibility is below {ROUGH:g}")


def _print_motion(motion: OptimisedMotion) -> None:
    for warning in motion.warnings:
        print(f"warning     {warning}")
    iterations = f"{motion.iterations} iterations, {motion.seconds:.2f} s"
    print(f"cost        {motion.solution.cost:.6g} after {iterations}")
    print(f"duration    {motion.duration:.6g} s")
    for line in motion.parameter_lines():
        print(f"parameter   {line}")


def _print_bounds(bounds: Mapping[str, float]) -> None:
    """Print the bounds at which the motion is for the longest time."""
    shown = [f"{name} {share:.0%}" for name, share in bounds.items()][:_MAX_ERRORS]
    rest = len(bounds) - len(shown)
    if shown:
        more = f", and {rest} more; use --json" if rest else ""
        print(f"at bounds   {', '.join(shown)}{more}")
