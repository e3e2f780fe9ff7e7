"""Reference results in FMUs equal the results of FMPy, which only reads the FMU."""

from __future__ import annotations

import io
import xml.etree.ElementTree as ET
import zipfile
from pathlib import Path

import numpy as np
import pytest
from fmpy import read_model_description, simulate_fmu
from support.robots.robots import EXAMPLES, PLANAR_2R

from addin_sdfusion.robot import SimulationError
from cardsflow_fmu import Experiment, build
from cardsflow_fmu.models.plant import PlantModel
from cardsflow_fmu.simulation.build import build_fmus

FOLDER = "extra/org.fmi-standard.fmi-ls-ref"


def related(file: Path) -> tuple[np.ndarray, str]:
    """Return the table of reference results in an FMU, and its description in the manifest."""
    with zipfile.ZipFile(file) as archive:
        root = ET.fromstring(archive.read(f"{FOLDER}/fmi-ls-manifest.xml"))
        (entry,) = root
        assert root.tag == "fmiReferences"
        assert entry.tag == "Related"
        assert (entry.get("type"), entry.get("role")) == ("text/csv", "result")
        text = archive.read(f"{FOLDER}/{entry.get('source')}").decode()
    return np.genfromtxt(io.StringIO(text), delimiter=",", names=True), entry.get("description", "")


def simulated(file: Path, reference: np.ndarray, **options: object) -> list[np.ndarray]:
    """Return the columns of FMPy's simulation with the start values of the FMU."""
    outputs = [v.name for v in read_model_description(str(file)).modelVariables]
    outputs = [name for name in outputs if name.replace(".", "") in reference.dtype.names]
    times = reference["time"]
    given = {"stop_time": times[-1], "output_interval": times[1], "output": outputs, **options}
    found = simulate_fmu(str(file), **given)
    assert len(outputs) == len(reference.dtype.names) - 1
    return [found[name] for name in outputs]


@pytest.mark.parametrize("example", ["planar_2r", "hill_arm"])
def test_fmpy_computes_the_reference_results(example: str, tmp_path: Path) -> None:
    experiment = Experiment.load(EXAMPLES / example)
    names = ["plant", "controller", "reference"]
    for file in build_fmus(experiment, tmp_path, names, sources=False, with_results=True).values():
        reference, what = related(file)
        assert len(reference) == 101
        assert what.endswith(f"steps of {float(reference['time'][1])!r} s")
        found = simulated(file, reference, step_size=reference["time"][1])
        for name, column in zip(reference.dtype.names[1:], found, strict=True):
            np.testing.assert_allclose(column, reference[name], 1e-12, 1e-15, err_msg=name)


def test_a_solver_computes_the_reference_results_for_model_exchange(tmp_path: Path) -> None:
    file = build(Experiment.load(PLANAR_2R), tmp_path, kind="me", with_results=True)["plant"]
    reference, _ = related(file)
    found = simulated(file, reference, fmi_type="ModelExchange", relative_tolerance=1e-10)
    for name, column in zip(reference.dtype.names[1:], found, strict=True):
        np.testing.assert_allclose(column, reference[name], atol=1e-6, err_msg=name)


def test_reference_results_end_at_a_failure(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The manifest contains the message."""

    def step(model: PlantModel, t: float, h: float) -> None:
        if t > 1.5e-3:
            raise SimulationError("the robot diverged")

    monkeypatch.setattr(PlantModel, "step", step)
    experiment = Experiment.load(PLANAR_2R)
    file = build_fmus(experiment, tmp_path, ["plant"], sources=False, with_results=True)["plant"]
    reference, what = related(file)
    assert reference["time"].tolist() == [0.0, 1e-3, 2e-3]
    assert what.endswith("; the next step fails: the robot diverged")
