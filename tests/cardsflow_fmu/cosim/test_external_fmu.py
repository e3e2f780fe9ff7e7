"""External FMUs in an experiment: names, units, sizes, parameters, errors."""

from __future__ import annotations

import math
import os
import zipfile
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from xml.sax.saxutils import escape

import numpy as np
import pytest
from support.fmu.external_fmus import FMI2, FMI3, MAPS, exchange_only, external_fmu
from support.robots.robots import PLANAR_2R

from addin_sdfusion.robot import CardsflowError, InputError
from cardsflow_fmu import Experiment, Result, build
from cardsflow_fmu.cosim.described_fmu import DescribedFmu
from cardsflow_fmu.cosim.signals.variables import ELEMENTS, ELEMENTS_FILE
from cardsflow_fmu.experiment.writer import experiment_data
from cardsflow_fmu.fmu.description import FmiVersion
from cardsflow_fmu.simulation.run import RunError, simulate

LEVERS = np.array([[0.1, -0.1, 0.05, -0.05], [0.0, 0.02, 0.1, -0.1]])
STEP = 1e-3


@pytest.fixture(scope="session")
def bodies(tmp_path_factory: pytest.TempPathFactory, compiler: str) -> dict[str, Path]:
    """Build the external plant in both versions of FMI."""
    folder = tmp_path_factory.mktemp("external")
    return {fmi: external_fmu(folder / f"body_{fmi[0]}.fmu", compiler, fmi) for fmi in MAPS}


def experiment(plant: object, **settings: Any) -> Experiment:
    changes = {
        "fmus.plant": plant,
        "wiring.plant.brake": 0.0,
        "run.duration": 0.05,
        **{key.replace("__", "."): value for key, value in settings.items()},
    }
    return Experiment.load(PLANAR_2R, changes)


def direct(experiment: Experiment) -> Result:
    """Run the external FMU with the other models as plain Python objects."""
    return simulate(experiment, coupling="direct")


def body(file: Path, fmi: str, **changes: Any) -> dict[str, Any]:
    return {"path": str(file), **MAPS[fmi], **changes}


def expected(result: Result, inertia: float) -> tuple[np.ndarray, np.ndarray]:
    """Return angles and rates under the recorded forces, in [rad] and [rad/s]."""
    forces = result.columns([f"f.cable_{k}" for k in range(1, 5)])
    q, qd = [np.array([-0.5, 0.5])], [np.zeros(2)]
    for force in forces[:-1]:
        qd.append(qd[-1] + STEP * LEVERS @ force / inertia)
        q.append(q[-1] + STEP * qd[-1])
    return np.array(q), np.array(qd)


@pytest.mark.slow
@pytest.mark.parametrize("version", MAPS)
def test_an_external_plant_with_other_units(bodies: dict[str, Path], version: str) -> None:
    plant = body(bodies[version], version, parameters={"inertia": 4.0})
    result = direct(experiment(plant))
    q, qd = expected(result, inertia=4.0)
    assert np.ptp(q[:, 0]) > 1e-4
    np.testing.assert_allclose(result.columns(["q.joint_1", "q.joint_2"]), q, rtol=1e-12)
    np.testing.assert_allclose(result.columns(["qd.joint_1", "qd.joint_2"]), qd, atol=1e-12)
    assert result.units["q.joint_1"] == "rad"
    assert result.summary["tracking"]["per_signal"]["q.joint_1"]["unit"] == "rad"
    assert "l.cable_1" not in result.names


def test_both_versions_of_fmi_have_equal_results(bodies: dict[str, Path]) -> None:
    rows = [direct(experiment(body(bodies[fmi], fmi))).rows for fmi in MAPS]
    np.testing.assert_array_equal(*rows)


def test_unmapped_variables_keep_name_and_unit(bodies: dict[str, Path]) -> None:
    plant = body(bodies["2.0"], "2.0")
    plant["inputs"] = {k: v for k, v in MAPS["2.0"]["inputs"].items() if k != "f.cable_1"}
    wiring = {"wiring.plant.pull_1": "controller.f.cable_1"}
    result = direct(experiment(plant, **wiring))
    np.testing.assert_array_equal(result.rows, direct(experiment(body(bodies["2.0"], "2.0"))).rows)


def test_a_boolean_input_can_be_constant(bodies: dict[str, Path]) -> None:
    for fmi in MAPS:
        result = direct(experiment(body(bodies[fmi], fmi), wiring__plant__brake=1.0))
        assert np.ptp(result["q.joint_1"]) == 0.0


@pytest.mark.parametrize("scheme", ["jacobi", "gauss_seidel"])
def test_versions_mixed_under_every_coupling(bodies: dict[str, Path], scheme: str) -> None:
    """Controller and reference of FMI 2.0 run with an external plant of FMI 3.0."""
    order = {"run__order": ["reference", "controller", "plant"]}
    settings = {"run__scheme": scheme, **(order if scheme == "gauss_seidel" else {})}
    through = {fmi: direct(experiment(body(bodies[fmi], fmi), **settings)).rows for fmi in MAPS}
    assert len(through["3.0"]) == 51
    np.testing.assert_array_equal(through["2.0"], through["3.0"])


@pytest.mark.parametrize(
    ("version", "inertia", "message"),
    [
        ("2.0", 1e6, "no message"),
        ("3.0", 1e6, "no message"),
        ("3.0", 1e7, "the FMU requested to terminate the simulation"),
    ],
)
def test_a_failing_step_ends_the_run_with_its_rows(
    bodies: dict[str, Path], version: str, inertia: float, message: str
) -> None:
    plant = body(bodies[version], version, parameters={"inertia": inertia})
    with pytest.raises(RunError) as caught:
        direct(experiment(plant))
    assert str(caught.value) == f"body_{version[0]}.fmu failed at t = 0.01 s: {message}"
    assert len(caught.value.result.rows) == 11


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"outputs": {"q": "angles", "qd": "angles"}}, "is mapped twice"),
        (
            {"outputs": {"q": "rates", "qd": "angles"}},
            "angles[1] -> qd.joint_1: 'deg' is not compatible",
        ),
        ({"inputs": {"f": "angles"}}, "no input of the FMU 'angles'"),
        (
            {"inputs": {"f.cable_1": "pulls"}},
            "sizes do not match: f.cable_1 has 1, pulls of the FMU 4",
        ),
        ({"inputs": {"g": "pulls"}}, "fmus.plant.inputs: no input 'g'"),
        ({"outputs": {"q": "angels"}}, "no output of the FMU 'angels'"),
        ({"units": {"angles": "mm"}}, "'mm' is not compatible with 'rad'"),
        ({"units": {"angles": "furlong"}}, "no unit 'furlong'"),
        ({"units": {"angel": "deg"}}, "no variable of the FMU 'angel'"),
        ({"parameters": {"mass": 1.0}}, "no variable 'mass'"),
        ({"parameters": {"inertia": "big"}}, "must be a number"),
        ({"parameters": {"inertia": -1.0}}, "failed at the start"),
        ({"path": "nowhere.fmu"}, "nowhere.fmu does not exist"),
        ({"wheels": 3}, "no key 'wheels'"),
    ],
)
def test_an_invalid_map_is_an_error_before_the_first_step(
    bodies: dict[str, Path], changes: dict[str, Any], message: str
) -> None:
    with pytest.raises(CardsflowError) as caught:
        direct(experiment(body(bodies["3.0"], "3.0", **changes)))
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.slow
def test_a_missing_unit_is_assumed_with_a_warning_or_set_explicitly(
    tmp_path: Path, compiler: str
) -> None:
    text = FMI3.replace('name="angles" valueReference="2" causality="output" unit="deg"', "X")
    text = text.replace("X", 'name="angles" valueReference="2" causality="output"')
    silent = external_fmu(tmp_path / "silent.fmu", compiler, "3.0", text)
    assumed = direct(experiment(body(silent, "3.0")))
    assert assumed["q.joint_1"][0] == pytest.approx(np.degrees(-0.5))
    (line,) = [w for w in assumed.summary["warnings"] if w.startswith("fmus.plant: ")]
    assert "no units for angles[1] in rad, angles[2] in rad" in line
    stated = direct(experiment(body(silent, "3.0", units={"angles": "deg"})))
    assert stated["q.joint_1"][0] == pytest.approx(-0.5)
    assert not [w for w in stated.summary["warnings"] if w.startswith("fmus.")]


def test_an_fmu_for_model_exchange_is_an_error(tmp_path: Path) -> None:
    file = exchange_only(tmp_path / "exchange.fmu")
    with pytest.raises(InputError, match=r"exchange\.fmu: is for model exchange only"):
        direct(experiment(str(file)))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("old", "new"), [('fmiVersion="2.0"', 'fmiVersion="1.0"'), ("<ModelVariables>", "<Models>")]
)
def test_a_file_that_is_not_an_fmu_is_an_error(
    tmp_path: Path, compiler: str, old: str, new: str
) -> None:
    file = external_fmu(tmp_path / "odd.fmu", compiler, "2.0", FMI2.replace(old, new))
    with pytest.raises(InputError, match=r"odd\.fmu"):
        direct(experiment(str(file)))


@pytest.mark.slow
@pytest.mark.parametrize("version", MAPS)
def test_fmus_of_this_package_need_no_map(tmp_path: Path, version: FmiVersion) -> None:
    """Tested in both versions of FMI, with arrays, together with a reference of FMI 2.0."""
    settings = {"run.duration": 0.05}
    built = build(Experiment.load(PLANAR_2R, settings), tmp_path, fmi=version)
    named = settings | {f"fmus.{role}": str(built[role]) for role in ("plant", "controller")}
    result = simulate(Experiment.load(PLANAR_2R, named))
    np.testing.assert_array_equal(result.rows, simulate(Experiment.load(PLANAR_2R, settings)).rows)
    assert math.isfinite(result.summary["tracking"]["rms"])


def test_a_coupling_is_part_of_the_packed_experiment() -> None:
    order = ("reference", "controller", "plant")
    settings = {"run.scheme": "gauss_seidel", "run.order": list(order)}
    data = experiment_data(Experiment.load(PLANAR_2R, settings))["run"]
    assert (data["scheme"], data["order"]) == ("gauss_seidel", list(order))


@pytest.mark.parametrize(
    ("rows", "reason"),
    [
        ("[" * 20_000, "recursion"),
        ("[{", "Expecting"),
        ("3", "not iterable"),
        ('[{"unit": "N"}]', "it does not contain 'name'"),
        ('[{"name": "a"}]', "it does not contain 'unit'"),
    ],
)
def test_invalid_element_names_are_an_error(rows: str, reason: str, tmp_path: Path) -> None:
    """External FMUs may contain the annotation with element names too."""
    note = f"<Annotations><Annotation type='{ELEMENTS}'>{escape(rows)}</Annotation></Annotations>"
    file = tmp_path / "odd.fmu"
    with zipfile.ZipFile(file, "w") as archive:
        text = FMI3.replace("<Dimension", f"{note}<Dimension", 1)
        archive.writestr("modelDescription.xml", text)
    with pytest.raises(InputError, match=rf"odd\.fmu: is not an FMU: .*{reason}"):
        DescribedFmu("plant", file, tmp_path / "unpacked")


@pytest.mark.parametrize("rows", ["[", "3", "[4]", '{"q": [{"name": "a"}]}', '{"q": 4}'])
def test_an_invalid_file_of_element_names_is_an_error(rows: str, tmp_path: Path) -> None:
    file = tmp_path / "odd.fmu"
    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr("modelDescription.xml", FMI3)
        archive.writestr(ELEMENTS_FILE, rows)
    with pytest.raises(InputError, match=r"odd\.fmu: is not an FMU: "):
        DescribedFmu("plant", file, tmp_path / "unpacked")


@pytest.mark.slow
def test_a_start_value_that_is_not_a_number_is_an_error(tmp_path: Path, compiler: str) -> None:
    text = FMI2.replace('start="', 'start="q', 1)
    file = external_fmu(tmp_path / "odd.fmu", compiler, "2.0", text)
    with pytest.raises(InputError, match=r"odd\.fmu: is not an FMU: could not convert"):
        simulate(Experiment.load(PLANAR_2R, {"fmus.plant": str(file)}))


@pytest.mark.slow
def test_a_library_that_cannot_be_loaded_does_not_change_the_current_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    built = build(Experiment.load(PLANAR_2R), tmp_path / "built")
    file, here = tmp_path / "odd.fmu", Path.cwd()
    with zipfile.ZipFile(built["plant"]) as good, zipfile.ZipFile(file, "w") as bad:
        for name in good.namelist():
            bad.writestr(name, b"?" if name.startswith("binaries/") else good.read(name))
    experiment = Experiment.load(PLANAR_2R, {"fmus.plant": str(file)})
    with pytest.raises(InputError, match=r"odd\.fmu: cannot be loaded") as caught:
        simulate(experiment)
    assert Path.cwd() == here
    assert "TMPDIR" not in str(caught.value)
    noexec = SimpleNamespace(f_flag=os.ST_NOEXEC)
    monkeypatch.setattr("cardsflow_fmu.cosim.fmu_instance.os.statvfs", lambda _: noexec)
    with pytest.raises(InputError, match="is mounted with noexec: set TMPDIR to another folder"):
        simulate(experiment)
