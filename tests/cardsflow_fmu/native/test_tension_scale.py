"""Scaled tensions of the plant: weak muscles and cut cables."""

from pathlib import Path

import numpy as np
import pytest

from addin_sdfusion.robot import InputError
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.models.plant import PlantModel

EXAMPLES = Path(__file__).parents[3] / "examples"


def moved(example: str, settings: dict[str, object], commands: float) -> PlantModel:
    plant = PlantModel(Experiment.load(EXAMPLES / example, settings))
    plant.views["commands"][:] = commands
    plant.initialize()
    for k in range(20):
        plant.step(0.001 * k, 0.001)
    return plant


def test_half_of_a_tension_is_the_tension_of_half_the_command() -> None:
    half = moved("planar_2r", {"plant.tension_scale": 0.5}, 40.0)
    np.testing.assert_array_equal(half.views["q"], moved("planar_2r", {}, 20.0).views["q"])


@pytest.mark.parametrize(("key", "value"), [("tension_scale", 0.0), ("break_time", 1e-4)])
def test_cut_muscle_has_no_tension_and_the_arm_falls(key: str, value: float) -> None:
    """A cable that breaks within half a step is broken from the start."""
    name = Experiment.load(EXAMPLES / "hill_arm").robot.muscles[0].name
    cut = moved("hill_arm", {f"plant.{key}.{name}": value}, 0.5)
    assert cut.views["tensions"][0] == 0.0
    assert np.abs(cut.views["q"] - moved("hill_arm", {}, 0.5).views["q"]).max() > 1e-4


@pytest.mark.parametrize("key", ["tension_scale", "break_time"])
def test_scaled_tensions_require_the_core(key: str) -> None:
    settings = {f"plant.{key}": 0.5, "plant.engine": "dart"}
    with pytest.raises(InputError, match=rf"plant\.{key}: requires the engine core"):
        PlantModel(Experiment.load(EXAMPLES / "planar_2r", settings))
