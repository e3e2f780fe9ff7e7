from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from dataclasses import replace

import pytest
from toy_model import PORTS

from addin_sdfusion.robot import InputError
from cardsflow_fmu.cosim.signals.ports import Port
from cardsflow_fmu.cosim.signals.variables import scalar_variables
from cardsflow_fmu.fmu.description import FmuDescription
from cardsflow_fmu.fmu.model_description import model_description

INPUT = Port("f.biceps", "N", "input", "continuous", "Force of biceps", 0.1)


def describe(*ports: Port, **changes: object) -> ET.Element:
    arguments: dict = {"model_name": "toy", "description": "A toy", "step": 1e-3, **changes}
    fmu = FmuDescription(scalar_variables(ports), **arguments)
    return ET.fromstring(model_description(fmu, "{1}"))


def variable(root: ET.Element, name: str) -> ET.Element:
    found = root.find(f"ModelVariables/ScalarVariable[@name='{name}']")
    assert found is not None
    return found


def test_variables_have_the_attributes_of_their_ports() -> None:
    root = describe(*PORTS)
    assert len(root.findall("ModelVariables/ScalarVariable")) == len(PORTS)
    for reference, port in enumerate(PORTS):
        found = variable(root, port.name)
        assert found.get("valueReference") == str(reference)
        assert found.get("causality") == port.causality
        assert found.get("variability") == port.variability
        assert found.get("description") == port.description
        assert found[0].tag == ("Boolean" if port.boolean else "Real")


def test_start_values_are_exact() -> None:
    root = describe(replace(INPUT, start=0.1 + 0.2))
    assert float(variable(root, "f.biceps")[0].get("start", "")) == 0.1 + 0.2


def test_boolean_start_values_are_words() -> None:
    root = describe(Port("on", "", "input", "discrete", "", 1.0, boolean=True))
    assert variable(root, "on")[0].get("start") == "true"


def test_outputs_are_calculated_and_listed_as_unknowns() -> None:
    root = describe(*PORTS)
    outputs = [str(i) for i, port in enumerate(PORTS, 1) if port.causality == "output"]
    for path in ("ModelStructure/Outputs/Unknown", "ModelStructure/InitialUnknowns/Unknown"):
        assert [unknown.get("index") for unknown in root.findall(path)] == outputs
    assert variable(root, "x").get("initial") == "calculated"
    assert variable(root, "x")[0].get("start") is None


def test_units_are_defined_by_base_units() -> None:
    root = describe(INPUT)
    (unit,) = root.findall("UnitDefinitions/Unit")
    assert unit.get("name") == "N"
    assert unit[0].attrib == {"kg": "1", "m": "1", "s": "-2"}


def test_angles_and_lengths_have_display_units() -> None:
    """A tool displays 2 rad as 114.6 deg, and 2 m as 2000 mm."""
    ports = [replace(INPUT, name=f"x{k}", unit=unit) for k, unit in enumerate(("rad", "m", "N"))]
    root = describe(*ports)
    shown = {
        unit.get("name"): (unit.find("DisplayUnit").get("name"), 2 * factor(unit))
        for unit in root.findall("UnitDefinitions/Unit[DisplayUnit]")
    }
    assert shown == {"rad": ("deg", pytest.approx(360 / math.pi)), "m": ("mm", 2000.0)}
    types = {t.get("name"): t[0].get("displayUnit") for t in root.iter("SimpleType")}
    assert types == {"Angle": "deg", "Length": "mm", "Force": None}


def factor(unit: ET.Element) -> float:
    return float(unit.find("DisplayUnit").get("factor"))


def test_capabilities_are_declared() -> None:
    slave = describe(*PORTS).find("CoSimulation")
    assert slave is not None
    flags = {name for name, value in slave.attrib.items() if value == "true"}
    assert flags == {"needsExecutionTool", "canGetAndSetFMUstate", "canSerializeFMUstate"}


def test_the_default_experiment_is_declared() -> None:
    experiment = describe(*PORTS, stop_time=8).find("DefaultExperiment")
    assert experiment is not None
    assert experiment.attrib == {"startTime": "0.0", "stopTime": "8.0", "stepSize": "0.001"}


def test_only_model_exchange_has_a_tolerance() -> None:
    """Co-simulation uses fixed steps."""
    ports = [Port("der(x.a)", "1/s", "local", "continuous", ""), replace(INPUT, name="x.a")]
    experiment = describe(*ports, is_continuous=True).find("DefaultExperiment")
    assert experiment is not None
    assert experiment.get("tolerance") == "1e-06"


def test_texts_about_the_fmu_are_attributes() -> None:
    about = {"author": "Ä. & B.", "copyright": "", "license": "MIT"}
    root = describe(INPUT, about=about, generated="2026-01-02T03:04:05Z")
    assert (root.get("author"), root.get("license")) == ("Ä. & B.", "MIT")
    assert root.get("generationDateAndTime") == "2026-01-02T03:04:05Z"
    assert root.get("copyright") is None
    with pytest.raises(InputError, match="characters that XML does not allow"):
        describe(INPUT, about={"author": "\x07"})


@pytest.mark.parametrize("name", ["q.elbow", "a.b.c", "a[1].b[2,3]", "q.'left arm'", "q.'it\\'s'"])
def test_structured_names_are_accepted(name: str) -> None:
    assert variable_names(describe(replace(INPUT, name=name))) == [name]


def variable_names(root: ET.Element) -> list[str | None]:
    return [found.get("name") for found in root.findall("ModelVariables/ScalarVariable")]


REFUSED: list[tuple[list[Port], str]] = [
    ([replace(INPUT, name="q.left arm")], "not a structured"),
    ([replace(INPUT, name="q.")], "not a structured"),
    ([replace(INPUT, name="q.Arm\n")], "not a structured"),
    ([replace(INPUT, unit="kN")], "unit of f.biceps"),
    ([replace(INPUT, variability="fixed")], "input cannot be fixed"),
    ([replace(INPUT, causality="parameter")], "parameter cannot be continuous"),
    ([replace(INPUT, boolean=True)], "cannot be continuous"),
    ([replace(INPUT, boolean=True, variability="discrete")], "must be 0 or 1, not 0.1"),
    ([replace(INPUT, start=float("nan"))], "start value nan is not finite"),
    ([replace(INPUT, start=float("inf"))], "start value inf is not finite"),
    ([replace(INPUT, description="\x07")], "characters that XML does not allow"),
    ([INPUT, INPUT], r"same name: f\.biceps"),
    ([], "at least one variable"),
]


@pytest.mark.parametrize(("ports", "message"), REFUSED, ids=[row[1] for row in REFUSED])
def test_ports_that_fmi_does_not_allow_are_rejected(ports: list[Port], message: str) -> None:
    with pytest.raises(InputError, match=message):
        describe(*ports)


@pytest.mark.parametrize("name", ["left arm", "1st", "", "ä"])
def test_model_names_that_are_not_identifiers_are_rejected(name: str) -> None:
    with pytest.raises(InputError, match="model name"):
        describe(INPUT, model_name=name)
