"""Ranges, nominal values and display units of variables in model descriptions."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections.abc import Sequence
from dataclasses import replace

import pytest
from support.robots.robots import EXAMPLES

from addin_sdfusion.robot import InputError
from cardsflow_fmu import Experiment
from cardsflow_fmu.cosim.signals.port import Port
from cardsflow_fmu.cosim.signals.variables import array_variables, scalar_variables
from cardsflow_fmu.fmu.description import FmiVersion, FmuDescription
from cardsflow_fmu.fmu.model_description import model_description
from cardsflow_fmu.models.by_role import model_class
from cardsflow_fmu.models.plant import ContinuousPlantModel
from cardsflow_fmu.simulation.run import simulate

A = Port("q.a", "m", "input", "continuous", "", 0.1, lower=-0.2, upper=0.3, nominal=0.1)
B = replace(A, name="q.b", lower=0.0, upper=math.inf, nominal=2.0)
FMI = ("2.0", "3.0")
SHOWN = ("min", "max", "nominal", "displayUnit")


def numbers(
    ports: Sequence[Port], fmi: FmiVersion, *, arrays: bool = False, is_continuous: bool = False
) -> dict[str, dict[str, str]]:
    """Return the attributes of all real variables in a model description."""
    variables = (array_variables if arrays else scalar_variables)(ports)
    fmu = FmuDescription(variables, "toy", "A toy", 1e-3, is_continuous=is_continuous)
    root = ET.fromstring(model_description(fmu, "{1}", fmi))
    if fmi == "3.0":
        return {e.get("name", ""): e.attrib for e in root.iter("Float64")}
    return {e.get("name", ""): e[0].attrib for e in root.iter("ScalarVariable")}


def test_variables_have_the_range_and_the_nominal_value_of_their_ports(fmi: FmiVersion) -> None:
    found = numbers([A, B], fmi)
    assert [found["q.a"].get(key) for key in SHOWN] == ["-0.2", "0.3", "0.1", None]
    assert [found["q.b"].get(key) for key in SHOWN] == ["0.0", None, "2.0", None]
    found = numbers([replace(A, name="Length")], fmi)  # the name of the type
    assert found["Length"].get("displayUnit") == "mm"


def test_an_array_has_a_range_that_contains_all_elements() -> None:
    found = numbers([A, B], "3.0", arrays=True)["q"]
    assert [found.get(key) for key in SHOWN[:3]] == ["-0.2", None, "0.1"]


def test_a_start_value_outside_the_range_is_rejected() -> None:
    with pytest.raises(InputError, match=r"q\.a: the start value 0\.4 is outside -0\.2 to 0\.3"):
        numbers([replace(A, start=0.4)], "2.0")


def test_states_for_model_exchange_have_the_attributes_of_outputs(fmi: FmiVersion) -> None:
    ports = ContinuousPlantModel.table(Experiment.load(EXAMPLES / "hill_arm"))
    found = numbers(ports, fmi, is_continuous=True)
    assert [found["l.biceps"].get(key) for key in SHOWN[:3]] == ["0.0", None, "0.1"]
    for name in ("activation.biceps", "u.biceps"):
        assert [found[name].get(key) for key in SHOWN[:3]] == ["0.0", "1.0", None]
    assert found["der(activation.biceps)"].get("min") is None


def test_the_nominal_pressure_is_the_largest_pressure(fmi: FmiVersion) -> None:
    experiment = Experiment.load(EXAMPLES / "pneumatic_elbow")
    muscle = experiment.robot.muscles[0]
    found = numbers(ContinuousPlantModel.table(experiment), fmi, is_continuous=True)
    largest = repr(dict(muscle.model.parameters)["max_pressure"])
    pressure = found[f"pressure.{muscle.name}"]
    assert [pressure.get(key) for key in SHOWN[:3]] == ["0.0", largest, largest]
    assert found[f"u.{muscle.name}"].get("max") == largest


@pytest.mark.parametrize("name", ["planar_2r", "hill_arm"])
def test_results_are_within_the_ranges(name: str) -> None:
    """The ranges are the joint limits, force limits and command limits of the robot."""
    experiment = Experiment.load(EXAMPLES / name, {"run.duration": 0.1})
    result = simulate(experiment, coupling="direct")
    ports = {p.name: p for r in ("controller", "plant") for p in model_class(r).table(experiment)}
    muscle, joint = experiment.robot.muscles[0], experiment.robot.coordinates[0]
    assert (ports[f"f.{muscle.name}"].lower, ports[f"f.{muscle.name}"].upper) == (0, muscle.f_max)
    assert (ports[f"q.{joint.name}"].lower, ports[f"q.{joint.name}"].upper) == (
        joint.lower,
        joint.upper,
    )
    limited = 0
    for column, values in zip(result.names, result.rows.T, strict=True):
        if (port := ports.get(column.rpartition(":")[2])) is not None:
            limited += math.isfinite(port.lower)
            assert port.lower <= values.min() <= values.max() <= port.upper
    assert limited > 10
