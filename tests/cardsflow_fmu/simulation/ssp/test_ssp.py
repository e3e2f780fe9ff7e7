"""Systems of FMUs in .ssp files: written, read back, run, and rejected."""

from __future__ import annotations

import contextlib
import io
import json
import math
import zipfile
from collections.abc import Callable
from pathlib import Path

import fmpy.ssp
import numpy as np
import pytest
from lxml import etree
from support.fmu.external_fmus import external_fmu
from support.robots.robots import PLANAR_2R
from support.ssp_runs import simulate_system

from addin_sdfusion.robot import InputError
from cardsflow_fmu import Experiment, Result, build
from cardsflow_fmu.cli.main import main
from cardsflow_fmu.cosim.signals.units import KNOWN_UNITS, conversion
from cardsflow_fmu.simulation.run import simulate
from cardsflow_fmu.simulation.ssp.reader import read_system, unpack_ssp

SCHEMAS = Path(fmpy.ssp.__file__).parent / "schema"
SETTINGS = {"run.duration": 0.05}

Change = Callable[[dict[str, bytes]], None]


@pytest.fixture(scope="module")
def system(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return build_ssp(Experiment.load(PLANAR_2R, SETTINGS), tmp_path_factory.mktemp("ssp"))


def build_ssp(experiment: Experiment, folder: Path) -> Path:
    """Build the FMUs of an experiment; return their .ssp."""
    build(experiment, folder, compute="python")
    return folder / "system.ssp"


def contents(path: Path) -> dict[str, bytes]:
    with zipfile.ZipFile(path) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def change_archive(path: Path, copy: Path, change: Change) -> Path:
    files = contents(path)
    change(files)
    with zipfile.ZipFile(copy, "w") as archive:
        for name, data in files.items():
            archive.writestr(name, data)
    return copy


def replace_text(name: str, old: str, new: str) -> Change:
    def change(files: dict[str, bytes]) -> None:
        assert old.encode() in files[name]
        files[name] = files[name].replace(old.encode(), new.encode(), 1)

    return change


SSD = "SystemStructure.ssd"


@pytest.mark.slow
def test_written_ssp_matches_the_ssp_schemas(system: Path) -> None:
    files = contents(system)
    assert [name for name in files if name.endswith(".fmu")] == [
        f"resources/{name}.fmu" for name in ("controller", "hardware", "plant", "reference")
    ]
    schemas = {".ssd": "Description", ".ssv": "ParameterValues"}
    checked = 0
    for name, data in files.items():
        if Path(name).suffix in schemas:
            schema = SCHEMAS / f"SystemStructure{schemas[Path(name).suffix]}.xsd"
            etree.XMLSchema(file=str(schema)).assertValid(etree.parse(io.BytesIO(data)))
            checked += 1
    assert checked == 5


def test_ssp_of_an_experiment_is_reproducible(system: Path, tmp_path: Path) -> None:
    again = build_ssp(Experiment.load(PLANAR_2R, SETTINGS), tmp_path)
    assert again.read_bytes() == system.read_bytes()


def test_written_system_is_read_back_unchanged(system: Path, tmp_path: Path) -> None:
    structure = read_system(unpack_ssp(system, tmp_path / "x"))
    assert [c.name for c in structure.components] == ["reference", "controller", "plant"]
    assert (structure.name, structure.step, structure.stop_time) == ("planar_2r", 1e-3, 0.05)
    plant = structure.components[2]
    assert {c.name: c.unit and c.unit.name for c in plant.connectors}["q.joint_1"] == "rad"
    assert ("plant.step", 1e-3) in [(f"plant.{p.name}", p.value) for p in plant.parameters]
    assert len(structure.connections) == 14


@pytest.mark.parametrize("scheme", ["sampled", "jacobi", "gauss_seidel"])
def test_system_has_the_results_of_its_experiment(system: Path, scheme: str) -> None:
    order = {"run.order": ["reference", "controller", "plant"]} if scheme[0] == "g" else {}
    settings = {"run.scheme": scheme, **order}
    ours = simulate(
        Experiment.load(PLANAR_2R, SETTINGS | settings), compute="python", coupling="direct"
    )
    result = simulate_system(system, settings)
    assert set(result.names) == set(ours.names)
    for name in result.names:
        np.testing.assert_array_equal(result[name], ours[name], err_msg=name)
    assert result.units == {name: ours.units[name] for name in result.names}
    for key in ("tracking", "infeasible_ticks", "ticks", "status", "scheme", "engine"):
        assert result.summary[key] == ours.summary[key]


@pytest.mark.slow
def test_system_step_is_the_controller_period(tmp_path: Path) -> None:
    settings = SETTINGS | {"controller.period": 0.005, "plant.step": 0.001, "run.step": 0.001}
    path = build_ssp(Experiment.load(PLANAR_2R, settings), tmp_path)
    result = simulate_system(path)
    ours = simulate(Experiment.load(PLANAR_2R, settings), compute="python", coupling="direct")
    assert result.summary["step"] == 0.005
    np.testing.assert_array_equal(result["q.joint_1"], ours["q.joint_1"][::5])


@pytest.mark.slow
def test_parameter_sets_and_settings_change_start_values(system: Path, tmp_path: Path) -> None:
    value = '<ssv:Real value="-0.5" unit="rad" />'
    degrees = f'<ssv:Real value="{math.degrees(-0.4)!r}" unit="deg" />'
    file = change_archive(
        system, tmp_path / "a.ssp", replace_text("resources/plant.ssv", value, degrees)
    )
    assert simulate_system(file)["q.joint_1"][0] == pytest.approx(-0.4, rel=1e-15)
    assert simulate_system(system, {"plant.q_start.joint_1": -0.3})["q.joint_1"][0] == -0.3
    both = simulate_system(system, {"plant.q_start": -0.3, "plant.q_start.joint_2": 0.4})
    assert (both["q.joint_1"][0], both["q.joint_2"][0]) == (-0.3, 0.4)


def test_command_runs_a_system(
    system: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    assert main(["run", str(system), "--set", "run.duration=0.01", "-o", str(out)]) == 0
    assert "tracking" in capsys.readouterr().out
    assert (out / "results.csv").read_text().count("\n") == 12
    assert json.loads((out / "summary.json").read_text())["status"] == "complete"
    page = tmp_path / "page.html"
    assert main(["view", str(out), "--html", str(page)]) == 0
    assert "cable_1" in Result.load(out).experiment.robot.muscles[0].name
    assert main(["report", str(out), "-o", str(tmp_path / "report.html")]) == 0
    assert main(["view", str(system), "--html", str(page)]) == 2
    assert main(["run", str(system), "--coupling", "direct"]) == 2
    assert main(["run", str(tmp_path / "none.ssp")]) == 2


@pytest.mark.slow
def test_variant_with_hardware_replaces_the_plant(tmp_path: Path) -> None:
    """Any FMU with the ports of the plant can be the hardware, here another plant."""
    folder = tmp_path / "other"
    other = build(Experiment.load(PLANAR_2R, SETTINGS | {"start.q": [0.1, 0.2]}), folder)["plant"]
    with_hardware = SETTINGS | {"fmus.hardware": str(other)}
    path = build_ssp(Experiment.load(PLANAR_2R, with_hardware), tmp_path / "built")
    assert {"hardware.ssd", "resources/hardware.fmu"} < set(contents(path))
    assert simulate_system(path)["q.joint_1"][0] == -0.5
    assert simulate_system(path, {"variant": "hardware"})["q.joint_1"][0] == 0.1
    with pytest.raises(InputError, match="no system structure 'hardwear'; did you mean"):
        simulate_system(path, {"variant": "hardwear"})


@pytest.mark.slow
def test_external_fmu_is_packed_with_its_units(tmp_path: Path, compiler: str) -> None:
    file = external_fmu(tmp_path / "body.fmu", compiler, "2.0")
    plant = {
        "path": str(file),
        "parameters": {"inertia": 4.0},
        "inputs": {f"f.cable_{k}": f"pull_{k}" for k in range(1, 5)},
        "outputs": {
            f"{name}.joint_{k}": f"{own}_{k}"
            for name, own in (("q", "angle"), ("qd", "rate"))
            for k in (1, 2)
        },
    }
    settings = SETTINGS | {"fmus.plant": plant, "wiring.plant.brake": 0.0}
    experiment = Experiment.load(PLANAR_2R, settings)
    ours = simulate(experiment, compute="python", coupling="direct")
    result = simulate_system(build_ssp(experiment, tmp_path / "built"))
    np.testing.assert_allclose(np.radians(result["angle_1"]), ours["q.joint_1"], rtol=1e-13)
    assert result.units["angle_1"] == "deg"


@pytest.mark.slow
def test_arrays_are_rejected_as_connectors(tmp_path: Path, compiler: str) -> None:
    file = external_fmu(tmp_path / "body.fmu", compiler, "3.0")
    plant = {"path": str(file), "inputs": {"f": "pulls"}, "outputs": {"q": "angles"}}
    experiment = Experiment.load(PLANAR_2R, SETTINGS | {"fmus.plant": plant})
    with pytest.raises(InputError, match="input pulls must be a scalar number in SSP"):
        build(experiment, tmp_path / "built")


Q_CONNECTION = (
    '<ssd:Connection startElement="plant" startConnector="q.joint_1" '
    'endElement="controller" endConnector="q.joint_1" />'
)


def test_units_of_connectors_and_transformations_are_converted(
    system: Path, tmp_path: Path
) -> None:
    def change(files: dict[str, bytes]) -> None:
        replace_text(SSD, Q_CONNECTION, f"{Q_CONNECTION[:-2]}>{linear}</ssd:Connection>")(files)
        replace_text(SSD, '<ssc:Real unit="rad" />', '<ssc:Real unit="deg" />')(files)

    linear = '<ssc:LinearTransformation factor="2.0" offset="0.5"/>'
    structure = read_system(
        unpack_ssp(change_archive(system, tmp_path / "a.ssp", change), tmp_path / "x")
    )
    changes = {".".join(c.target): c.change for c in structure.connections}
    assert (changes["controller.q.joint_1"].factor, changes["controller.q.joint_1"].offset) == (
        2.0,
        0.5,
    )
    turned = conversion(KNOWN_UNITS["deg"], KNOWN_UNITS["rad"])
    assert changes["controller.q_d.joint_1"] == turned


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (replace_text(SSD, 'startElement="plant"', 'startElement="plan"'), "no connector 'plan.q"),
        (
            replace_text(SSD, 'endConnector="q.joint_1"', 'endConnector="q.joint_2"'),
            "cannot be connected to",
        ),
        (replace_text(SSD, 'name="reference"', 'name="plant"'), "the same name"),
        (
            replace_text(SSD, "resources/plant.fmu", "resources/plan.fmu"),
            "resources/plan.fmu' does not exist",
        ),
        (replace_text(SSD, "resources/plant.fmu", "../plant.fmu"), "a path outside"),
        (replace_text(SSD, '"resources/plant.ssv"', '"../plant.ssv"'), "is outside of the archive"),
        (replace_text(SSD, "<ssd:Elements>", '<ssd:Elements><ssd:System name="s"/>'), "only flat"),
        (replace_text(SSD, "x-fmu-sharedlibrary", "x-ssp-package"), "is not an FMU"),
        (
            replace_text(SSD, '<ssc:Real unit="rad" />', '<ssc:Real unit="N" />'),
            "is not compatible with",
        ),
        (replace_text(SSD, '<ssc:Real unit="rad" />', '<ssc:Real unit="ell" />'), "no unit 'ell'"),
        (replace_text(SSD, 'startTime="0.0"', 'startTime="1.0"'), "start time"),
        (replace_text(SSD, 'baseStepSize="0.001"', 'baseStepSize="x"'), "must be a finite number"),
        (replace_text(SSD, 'baseStepSize="0.001"', 'baseStepSize="-1"'), "must be above 0"),
        (replace_text(SSD, 'stopTime="0.05"', ""), "does not specify its duration"),
        (replace_text(SSD, "<ssd:System ", "<ssd:System <"), "is not well-formed XML"),
        (replace_text(SSD, 'name="q_d.joint_1"', 'name="q_d.joint_9"'), "no connector"),
        (replace_text("resources/plant.ssv", 'name="step"', 'name="steps"'), "no variable 'steps'"),
        (
            replace_text("resources/plant.ssv", "ssv:Real", "ssv:String"),
            "q_start.joint_1 is String",
        ),
        (lambda files: files.pop(SSD), "no system structure 'SystemStructure'"),
        (lambda files: files.update({"../evil": b""}), "a path outside of the archive"),
        (lambda files: files.update({"a/" * 3000 + "b": b""}), "a file name with 6001 characters"),
        (lambda files: files.update({"resources/plant.fmu": b"no zip"}), "is not a valid FMU"),
    ],
)
def test_invalid_ssp_is_rejected_in_one_line(
    system: Path, tmp_path: Path, change: Change, message: str
) -> None:
    file = change_archive(system, tmp_path / "bad.ssp", change)
    with pytest.raises(InputError) as caught:
        simulate_system(file)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)
    assert str(caught.value).startswith(str(file))


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"run.scheme": "strong"}, "no scheme 'strong'"),
        ({"run.order": ["plan"]}, "no participant 'plan'"),
        ({"run.order": 3}, "must be a list of names"),
        ({"run.steps": 3}, "no key 'steps'"),
        ({"run.duration": 0.0505}, "duration"),
        ({"plan.step": 1.0}, "no component 'plan'"),
        ({"plant.step": "small"}, "must be a number"),
        ({"plant.stop": 1.0}, "no variable 'stop'"),
    ],
)
def test_invalid_settings_are_rejected(
    system: Path, settings: dict[str, object], message: str
) -> None:
    with pytest.raises(InputError, match=message):
        simulate_system(system, settings)


def test_invalid_archive_is_rejected(tmp_path: Path) -> None:
    file = tmp_path / "a.ssp"
    file.write_bytes(b"PK nothing")
    with pytest.raises(InputError, match=r"a\.ssp: is not a valid \.ssp"):
        simulate_system(file)


@pytest.mark.parametrize("name", ["{folder}/outside", "system", "a" * 400])
def test_component_names_with_paths_are_rejected(system: Path, tmp_path: Path, name: str) -> None:
    name = name.format(folder=tmp_path)

    def rename(files: dict[str, bytes]) -> None:
        files[SSD] = files[SSD].replace(b'"plant"', f'"{name}"'.encode())

    file = change_archive(system, tmp_path / "a.ssp", rename)
    assert simulate_system(file).complete
    assert [one.name for one in tmp_path.iterdir()] == ["a.ssp"]


@pytest.mark.parametrize(
    ("new", "message"),
    [
        ('rad="x"', "rad must be a finite number, not 'x'"),
        ('rad="0.5"', "exponents of units must be integers"),
        ('rad="1" factor="q"', "factor must be a finite number, not 'q'"),
        ('rad="1" offset="nan"', "offset must be a finite number, not 'nan'"),
        ('rad="1" factor="0"', "'rad' has the invalid factor 0 or offset 0"),
    ],
)
def test_invalid_units_are_rejected(system: Path, tmp_path: Path, new: str, message: str) -> None:
    file = change_archive(system, tmp_path / "a.ssp", replace_text(SSD, 'rad="1"', new))
    with pytest.raises(InputError, match=message):
        simulate_system(file)


def test_entities_are_rejected(system: Path, tmp_path: Path) -> None:
    def declare(files: dict[str, bytes]) -> None:
        name = "resources/plant.ssv"
        begin, rest = files[name].split(b"?>", 1)
        declared = b'<!DOCTYPE x [<!ENTITY e SYSTEM "file:///etc/passwd">]>'
        rest = rest.replace(b"<ssv:Real", b"&e;<ssv:Real", 1)
        files[name] = begin + b"?>" + declared + rest

    file = change_archive(system, tmp_path / "a.ssp", declare)
    with pytest.raises(InputError, match=r"plant\.ssv:1: uses XML entities"):
        simulate_system(file)


@pytest.mark.slow
def test_damaged_archives_are_rejected(system: Path, tmp_path: Path) -> None:
    good, file = system.read_bytes(), tmp_path / "a.ssp"
    generator = np.random.default_rng(5)
    for k in range(300):
        data = bytearray(good)
        for place in generator.integers(len(data), size=1 + k % 20):
            data[place] = generator.integers(256)
        file.write_bytes(data[: generator.integers(len(data))] if k % 5 == 0 else data)
        with contextlib.suppress(InputError):
            read_system(unpack_ssp(file, tmp_path / f"{k}"))
