from __future__ import annotations

import hashlib
import json
import xml.etree.ElementTree as ET
import zipfile
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import fmpy
import pytest
from fmpy.validation import validate_fmu
from support.robots.robots import PLANAR_2R
from toy_model import PORTS, ToyModel

from addin_sdfusion.robot import InputError, UnknownNameError
from cardsflow_fmu import Experiment
from cardsflow_fmu.cosim.signals.ports import Port
from cardsflow_fmu.experiment.writer import experiment_resources
from cardsflow_fmu.fmu.writer import write_fmu
from cardsflow_fmu.runtime.library import find_platform, library_path, this_platform
from cardsflow_fmu.simulation.build import build_fmus
from cardsflow_fmu.utils.archive import read_contents

pytestmark = pytest.mark.native

UNITS = ("rad", "rad/s", "rad/s2", "m", "m/s", "m/s2", "N", "N.m", "s", "1/s", "1/s2", "")


def write(path: Path, **changes: Any) -> Path:
    arguments: dict[str, Any] = {
        "model_class": ToyModel,
        "model_name": "toy",
        "ports": PORTS,
        "resources": {"x_start.txt": b"0.25"},
        "step": 1e-3,
    }
    return write_fmu(path, **{**arguments, **changes})


def digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def test_fmpy_validates_the_fmu(tmp_path: Path) -> None:
    assert validate_fmu(str(write(tmp_path / "toy.fmu"))) == []


def test_every_unit_is_valid(tmp_path: Path) -> None:
    ports = [
        Port(f"u{i}", unit, "input", "continuous", f"In {unit}") for i, unit in enumerate(UNITS)
    ]
    assert validate_fmu(str(write(tmp_path / "toy.fmu", ports=ports))) == []


def test_the_fmu_contains_all_files(tmp_path: Path) -> None:
    mesh = tmp_path / "mesh.stl"
    mesh.write_bytes(b"solid")
    resources = {"x_start.txt": b"0.25", "robot/meshes/a.stl": mesh}
    path = write(tmp_path / "toy.fmu", resources=resources)
    with zipfile.ZipFile(path) as archive:
        assert archive.testzip() is None
        binary = f"binaries/{this_platform().fmi2}/toy{library_path().suffix}"
        assert set(archive.namelist()) == {
            "modelDescription.xml",
            "model.png",
            "documentation/index.html",
            "documentation/licenses/license.txt",
            binary,
            "resources/model.json",
            "resources/ports.bin",
            "resources/python.txt",
            "resources/python/toy_model.py",
            "resources/x_start.txt",
            "resources/robot/meshes/a.stl",
        }
        assert archive.read(binary) == library_path().read_bytes()
        assert archive.read("resources/robot/meshes/a.stl") == b"solid"
        assert json.loads(archive.read("resources/model.json"))["class"] == "toy_model:ToyModel"


def test_equal_input_creates_equal_bytes(tmp_path: Path) -> None:
    one = write(tmp_path / "one.fmu", resources={"x_start.txt": b"1", "b": b""})
    two = write(tmp_path / "two.fmu", resources={"b": b"", "x_start.txt": b"1"})
    assert digest(one) == digest(two)


@pytest.mark.parametrize(
    "changes",
    [
        {"resources": {"x_start.txt": b"0.5"}},
        {"resources": {"x_start": b"0.25"}},
        {"ports": [replace(PORTS[0], start=1.0), *PORTS[1:]]},
        {"model_name": "toy2"},
        {"step": 2e-3},
        {"stop_time": 1.0},
    ],
)
def test_other_contents_have_another_guid(tmp_path: Path, changes: dict[str, Any]) -> None:
    one = fmpy.read_model_description(str(write(tmp_path / "one.fmu")))
    two = fmpy.read_model_description(str(write(tmp_path / "two.fmu", **changes)))
    assert one.guid != two.guid


def test_no_temporary_files_remain(tmp_path: Path) -> None:
    write(tmp_path / "toy.fmu")
    write(tmp_path / "toy.fmu", step=2e-3)
    assert [path.name for path in tmp_path.iterdir()] == ["toy.fmu"]


@pytest.mark.parametrize(
    "name", ["", ".", "/etc/x", "../x", "a/../../x", "a\\b", "C:x", "model.json", "ports.bin"]
)
def test_invalid_resource_names_are_rejected(tmp_path: Path, name: str) -> None:
    with pytest.raises(InputError, match="resource"):
        write(tmp_path / "toy.fmu", resources={name: b""})


def test_a_missing_resource_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"gone\.stl: cannot be read: No such file"):
        write(tmp_path / "toy.fmu", resources={"a": tmp_path / "gone.stl"})


def test_a_path_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match=r"cannot be written: (Not a directory|File exists)"):
        write(tmp_path / "file" / "toy.fmu")


def test_a_class_that_cannot_be_imported_is_rejected(tmp_path: Path) -> None:
    class Local(ToyModel):
        pass

    with pytest.raises(InputError, match="define the class in a module"):
        write(tmp_path / "toy.fmu", model_class=Local)


def test_a_missing_library_is_reported_with_a_remedy(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CARDSFLOW_LIBRARY_DIR", str(tmp_path))
    with pytest.raises(InputError, match="hatch_build"):
        write(tmp_path / "toy.fmu")


def test_machines_without_a_name_in_fmi_are_rejected(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("platform.machine", lambda: "riscv64")
    with pytest.raises(InputError, match="riscv64"):
        this_platform()


def test_platforms_that_fmi_2_does_not_name_are_rejected() -> None:
    with pytest.raises(InputError, match=r"FMI 2.0 has no name for the platform aarch64-linux"):
        find_platform("aarch64-linux").folder("2.0")
    assert find_platform("aarch64-linux").folder("3.0") == "aarch64-linux"
    assert find_platform("linux64") is find_platform("x86_64-linux")
    with pytest.raises(UnknownNameError, match="amiga"):
        find_platform("amiga")


def test_an_fmu_may_contain_libraries_for_several_platforms(tmp_path: Path) -> None:
    other = tmp_path / "library.dll"
    other.write_bytes(b"MZ")
    libraries = {"x86_64-linux": library_path(), "x86_64-windows": other}
    for fmi, folders in (
        ("2.0", ("linux64", "win64")),
        ("3.0", ("x86_64-linux", "x86_64-windows")),
    ):
        path = write(tmp_path / "toy.fmu", libraries=libraries, fmi=fmi)
        with zipfile.ZipFile(path) as archive:
            names = {name for name in archive.namelist() if name.startswith("binaries/")}
            assert names == {f"binaries/{folders[0]}/toy.so", f"binaries/{folders[1]}/toy.dll"}


def built(path: Path) -> tuple[str | None, str | None]:
    """Build an FMU; return its GUID and the time of its build."""
    description = fmpy.read_model_description(str(write(path)))
    return description.guid, description.generationDateAndTime


def test_the_time_of_the_build_is_not_part_of_the_guid(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "86400")
    guid, when = built(tmp_path / "one.fmu")
    assert when == "1970-01-02T00:00:00Z"
    monkeypatch.delenv("SOURCE_DATE_EPOCH")
    began = datetime.now(UTC).replace(microsecond=0)
    same_guid, when = built(tmp_path / "two.fmu")
    assert same_guid == guid
    assert when
    assert began <= datetime.fromisoformat(when) <= datetime.now(UTC)
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "today")
    with pytest.raises(InputError, match="SOURCE_DATE_EPOCH: 'today' is not a time"):
        write(tmp_path / "three.fmu")


def test_an_experiment_specifies_author_and_licence(tmp_path: Path) -> None:
    about = {"about.author": "A. Designer", "about.copyright": "© A", "about.license": "MIT"}
    experiment = Experiment.load(PLANAR_2R, about)
    again = Experiment.from_resources(unpacked_resources(experiment, tmp_path))
    assert again.about == experiment.about
    file = build_fmus(again, tmp_path, ["reference"], sources=False)["reference"]
    with zipfile.ZipFile(file) as archive:
        root = ET.fromstring(archive.read("modelDescription.xml"))
    assert [root.get(key.removeprefix("about.")) for key in about] == list(about.values())


def unpacked_resources(experiment: Experiment, folder: Path) -> Path:
    """Write the resources of the experiment's FMUs to a folder."""
    for name, content in experiment_resources(experiment).items():
        path = folder / "resources" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(read_contents(content))
    return folder / "resources"
