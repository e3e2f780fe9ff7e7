"""Files of the best robot of an optimisation."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from addin_sdfusion.muscles.csv_writer import csv_text
from addin_sdfusion.muscles.rows import PointRow
from addin_sdfusion.muscles.table import COLORS, MuscleTable
from addin_sdfusion.robot import CardsflowError, Robot
from addin_sdfusion.robot.files import write_files
from addin_sdfusion.robot.formats.convert import convert
from addin_sdfusion.robot.formats.read import read_trajectories
from addin_sdfusion.robot.json_text import json_text
from addin_sdfusion.snapshot import MuscleSnapshot
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.experiment.writer import experiment_data
from cardsflow_fmu.results.viewer.scene.link_poses import link_poses, moved_point

MUSCLES, EXPERIMENT = "muscles.csv", "experiment.json"
_GAINS = "motion.gains.csv"


def write_best(experiment: Experiment, folder: Path) -> list[str]:
    """Write the robot as SDF and CASPR, its via points as CSV, and an experiment with the robot.

    `cardsflow run FOLDER/experiment.json` runs the written robot. The Fusion add-in can import the
    CSV: its points are in the root frame, with all joints at zero.

    Returns:
        Notes on the parts of the robot that a format does not support, one line each.
    """
    robot, notes = experiment.robot, []
    trajectories, unread = read_trajectories(experiment.robot_path)
    for format_, moves in (("sdf", []), ("caspr", trajectories)):
        try:
            findings = convert(robot, format_, folder / format_, moves, overwrite=True).findings
            findings += unread if format_ == "caspr" else []
            notes += [f"{format_}: {finding}" for finding in findings]
        except CardsflowError as error:
            notes.append(f"{format_}: not written: {error}")
    files = {MUSCLES: csv_text(muscle_table(robot)).encode()}
    if experiment.fmus:
        notes.append(f"{EXPERIMENT}: not written, since the experiment has external FMUs")
    else:
        data = _experiment_data(experiment)
        if experiment.feedback is not None and experiment.controller.gains is not None:
            files[_GAINS] = experiment.controller.gains.read_bytes()
            data["controller"]["gains"] = _GAINS
        files[EXPERIMENT] = (json_text(data, indent=1) + "\n").encode()
    write_files(folder, files)
    return notes


def muscle_table(robot: Robot) -> MuscleTable:
    """Return the muscles for the Fusion add-in: points in the root frame, all joints at zero.

    Args:
        robot: The robot. Its wrap surfaces are omitted, since they are faces of the design.
    """
    poses = link_poses(robot, np.zeros((1, len(robot.coordinates))))
    points = []
    for muscle in robot.muscles:
        for k, point in enumerate(muscle.via_points):
            x, y, z = moved_point(poses[point.link], point.position)[0].tolist()
            points.append(PointRow("via", point.link, muscle.name, k + 1, position=(x, y, z)))
    rows = [
        MuscleSnapshot(
            m.name,
            COLORS[k % len(COLORS)],
            m.f_min,
            m.f_max,
            m.model.kind,
            dict(m.model.parameters),
        )
        for k, m in enumerate(robot.muscles)
    ]
    return MuscleTable(tuple(rows), tuple(points))


def _experiment_data(experiment: Experiment) -> dict[str, Any]:
    """Return the experiment with the written robot instead of a changed robot."""
    robot = experiment.robot
    data = {"path": "sdf/model.sdf", "cable_set": robot.cable_set, "gravity": list(robot.gravity)}
    if robot.task_set:
        data["operational_space"] = robot.task_set
    return experiment_data(experiment) | {"robot": data}
