"""Files of an optimal motion: the reference, its figure and its report."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from addin_sdfusion.robot import InputError
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.experiment.motion.feedback import force_names, gains_file
from cardsflow_fmu.experiment.start import OPTIMISED_MOTION
from cardsflow_fmu.results.report.figures import image
from cardsflow_fmu.results.report.motion import motion_figure, motion_page
from cardsflow_fmu.results.run_data import ExperimentRunData
from cardsflow_fmu.results.viewer.view import act_of
from cardsflow_fmu.utils.arrays import FloatArray
from cardsflow_fmu.utils.csv_table import csv_text
from cardsflow_fmu.utils.overwrite import NOT_OWN, output_file, write_output

from .diagnosis import active_bounds
from .feedback import control_signals
from .optimise import MARK_COLUMN, OptimisedMotion

_ROBOT = Path("sdf", "cardsflow.xml")


def robot_folder(motion: Path) -> Path:
    """Return the folder of the robot with the parameters of a motion, such as `motion_robot`."""
    return motion.with_name(f"{motion.stem}_robot")


def motion_file(experiment: Experiment, file: Path | None, *, overwrite: bool = False) -> Path:
    """Check the file of the motion before the work starts.

    Args:
        experiment: The experiment.
        file: The file (default: `motion.csv` next to the experiment).
        overwrite: Whether to replace files that CARDSFlow did not write.

    Raises:
        InputError: The file, its figure or the folder of its robot exists, and CARDSFlow did not
            write it.
    """
    target = experiment.file.parent / OPTIMISED_MOTION if file is None else file
    output_file(target, [".csv"], overwrite=overwrite)
    output_file(gains_file(target), [".csv"], overwrite=overwrite)
    output_file(target.with_suffix(".svg"), [".svg"], overwrite=overwrite)
    folder = robot_folder(target)
    has_parameters = experiment.motion is not None and experiment.motion.parameters
    if has_parameters and not overwrite and folder.exists() and not (folder / _ROBOT).exists():
        raise InputError(NOT_OWN, file=folder)
    return target


def write_motion_files(
    motion: OptimisedMotion, file: Path, *, overwrite: bool = False
) -> tuple[Path, ...]:
    """Write a motion and its gains as CSV, and its figure with the same name as SVG."""
    _write_table(file, {"time": motion.times, **motion.columns})
    gains = motion.feedback.columns(force_names(motion.problem.dynamics.robot))
    last = np.arange(len(motion.feedback.times), dtype=float)
    _write_table(gains_file(file), {**gains, MARK_COLUMN: last})
    drawn = output_file(file.with_suffix(".svg"), [".svg"], overwrite=overwrite)
    figure = motion_figure(motion.times, motion.columns, _outcome(motion), _bounds(motion))
    return file, gains_file(file), write_output(drawn, image(figure, "svg"))


def write_motion_report(
    motion: OptimisedMotion, experiment: Experiment, file: Path, *, overwrite: bool = False
) -> Path:
    """Write a page with a replay of a motion, figures, active bounds and iterations.

    Args:
        motion: The motion.
        experiment: The experiment with the found parameters.
        file: The HTML page.
        overwrite: Whether to replace files that CARDSFlow did not write.
    """
    rows = np.stack([motion.times, *motion.columns.values()], axis=1)
    names, summary = ("time", *motion.columns), {"warnings": motion.warnings}
    data = ExperimentRunData(names, rows, {}, summary, experiment=experiment)
    history = [
        (each.iteration, each.cost, each.violation, each.share, substeps, each.seconds)
        for each, substeps in motion.history
    ]
    text = motion_page(
        experiment.name,
        _outcome(motion),
        motion.warnings,
        act_of(data),
        motion_figure(motion.times, motion.columns, "", _bounds(motion)),
        active_bounds(motion.problem, motion.solution),
        history,
    )
    return write_output(output_file(file, [".html"], overwrite=overwrite), text)


def _outcome(motion: OptimisedMotion) -> str:
    solution = motion.solution
    return f"{solution.status}: cost {solution.cost:.6g}, {motion.duration:.4g} s"


def _bounds(motion: OptimisedMotion) -> dict[str, tuple[float, float]]:
    """Return the bounds of controls and states between start and goals, by name."""
    problem = motion.problem.problem
    low = [*problem.u_low.min(axis=0).tolist(), *problem.x_low[1:-1].min(axis=0).tolist()]
    high = [*problem.u_high.max(axis=0).tolist(), *problem.x_high[1:-1].max(axis=0).tolist()]
    names = (*control_signals(motion.problem), *problem.state_names)
    return dict(zip(names, zip(low, high, strict=True), strict=True))


def _write_table(file: Path, columns: Mapping[str, FloatArray]) -> None:
    write_output(file, csv_text(list(columns), np.stack(list(columns.values()), axis=1)))
