"""Files of an optimal motion: the reference and its figure."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.experiment.start import OPTIMISED_MOTION
from cardsflow_fmu.results.report.figures import image
from cardsflow_fmu.results.report.motion import motion_figure
from cardsflow_fmu.utils.csv_table import csv_text
from cardsflow_fmu.utils.overwrite import output_file, write_output

from .optimise import OptimisedMotion


def motion_file(experiment: Experiment, file: Path | None, *, overwrite: bool = False) -> Path:
    """Check the file of the motion before the work starts.

    Args:
        experiment: The experiment.
        file: The file (default: `motion.csv` next to the experiment).
        overwrite: Whether to replace files that CARDSFlow did not write.
    """
    own = experiment.file.parent / OPTIMISED_MOTION if file is None else file
    output_file(own, [".csv"], overwrite=overwrite)
    output_file(own.with_suffix(".svg"), [".svg"], overwrite=overwrite)
    return own


def write_motion_files(
    motion: OptimisedMotion, file: Path, *, overwrite: bool = False
) -> tuple[Path, Path]:
    """Write a motion as CSV, and its figure with the same name as SVG."""
    rows = np.stack([motion.times, *motion.columns.values()], axis=1)
    write_output(file, csv_text(["time", *motion.columns], rows))
    own = motion.solution
    title = f"{own.status}: cost {own.cost:.6g}, {motion.duration:.4g} s"
    figure = motion_figure(motion.times, motion.columns, title)
    drawn = output_file(file.with_suffix(".svg"), [".svg"], overwrite=overwrite)
    return file, write_output(drawn, image(figure, "svg"))
