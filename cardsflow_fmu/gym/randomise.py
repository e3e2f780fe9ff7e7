"""Random robots of environments: by variations of studies, or as uncertain as a calibration."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

import numpy as np

from addin_sdfusion.robot import InputError, Robot, check
from cardsflow_fmu.experiment.config.file import read_settings
from cardsflow_fmu.experiment.config.table import Context
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.experiment.settings.estimator import CALIBRATION_FILE
from cardsflow_fmu.studies.definition.path_check import PathCheck
from cardsflow_fmu.studies.definition.sampling import sample
from cardsflow_fmu.studies.definition.tables import VarySettings
from cardsflow_fmu.studies.definition.variation_reader import read_variations
from sim_dart.batch.arguments import integer
from sim_dart.calibration.parameters import calibrated_robot, free_parameters

Randomise = Literal["calibration"] | Sequence[Mapping[str, Any]]

_ATTEMPTS = 50


def random_robots(
    path: Path, settings: Mapping[str, Any], randomise: Randomise, count: int, seed: int
) -> list[Robot]:
    """Return random robots of an experiment.

    Args:
        path: The experiment.toml, or its folder.
        settings: Changes of the experiment by full key.
        randomise: Tables with the keys of [[vary]] in a study; or `calibration`, for deviations
            with the standard deviations of the calibration.json next to the robot.
        count: Number of robots.
        seed: Seed of the random numbers.

    Raises:
        InputError: A variation is invalid, or the calibration does not exist.
    """
    integer("variants", count, 1)
    integer("seed", seed, 0)
    if randomise == "calibration":
        return _deviating_robots(Experiment.load(path, settings), count, seed)
    if isinstance(randomise, str | Mapping) or not randomise:
        problem = (
            f"must be 'calibration' or a list of tables as [[vary]] of studies, not {randomise!r}"
        )
        raise InputError(problem, key="randomise")
    context = Context(Path("randomise"))
    tables = [
        VarySettings.read(dict(table), context, f"vary[{k}]") for k, table in enumerate(randomise)
    ]
    variations = read_variations(tables, PathCheck(path, settings), context)
    points = sample("latin_hypercube", len(variations), count, seed)
    robots = []
    for point in points.tolist():
        changes = dict(settings)
        for variation, u in zip(variations, point, strict=True):
            changes |= variation.settings(variation.range.at(u))
        robots.append(Experiment.load(path, changes).plant_robot)
    return robots


def _deviating_robots(experiment: Experiment, count: int, seed: int) -> list[Robot]:
    """Return robots whose calibrated parameters deviate by their standard deviations.

    The deviations are independent, since calibration.json does not contain correlations.
    """
    file, robot = experiment.folder / CALIBRATION_FILE, experiment.plant_robot
    if not file.is_file():
        raise InputError("does not exist; run `cardsflow calibrate` and use its robot", file=file)
    try:
        sd = {str(row["name"]): float(row["sd"]) for row in read_settings(file)["parameters"]}
    except (ValueError, KeyError, TypeError) as error:
        raise InputError(f"is not the result of a calibration ({error!r})", file=file) from None
    # names of via points and inertias continue after the word that patterns match
    words = {re.sub(r"(\.via_points|\.inertia)\b.*", r"\1", name) for name in sd}
    kinds = [word for word in words if not word.startswith("markers.")]
    torque = np.zeros(len(robot.coordinates))
    parameters, _ = free_parameters(robot, kinds, torque)
    chosen = [one for one in parameters if one.name in sd]
    spread = np.array([sd[one.name] for one in chosen])
    low = np.array([one.low - one.value for one in chosen])
    high = np.array([one.high - one.value for one in chosen])
    rng, robots = np.random.default_rng(seed), []
    for _ in range(_ATTEMPTS * count):
        theta = np.clip(spread * rng.standard_normal(len(chosen)), low, high)
        one = _possible_robot(robot, chosen, theta)
        robots += [] if one is None else [one]
        if len(robots) == count:
            return robots
    raise InputError(
        "the standard deviations are so large that most robots have impossible inertias; "
        "calibrate fewer parameters",
        file=file,
    )


def _possible_robot(robot: Robot, parameters: Sequence[Any], theta: Any) -> Robot | None:
    try:
        changed = calibrated_robot(robot, parameters, theta)
    except (InputError, ValueError, np.linalg.LinAlgError):
        return None
    return None if any(finding.is_error for finding in check(changed)) else changed
