from __future__ import annotations

import hashlib
import json
import zipfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import fmpy
import pytest
from fmpy.validation import validate_fmu
from toy_model import PORTS, ToyModel

from addin_sdfusion.robot import InputError
from cardsflow_fmu.fmu_file import write_fmu
from cardsflow_fmu.ports import Port
from cardsflow_fmu.runtime.library import library_path, platform_name

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


def test_fmpy_finds_nothing_to_complain_about(tmp_path: Path) -> None:
    assert validate_fmu(str(write(tmp_path / "toy.fmu"))) == []


def test_every_unit_is_valid(tmp_path: Path) -> None:
    ports = [
        Port(f"u{i}", unit, "input", "continuous", f"In {unit}") for i, unit in enumerate(UNITS)
    ]
    assert validate_fmu(str(write(tmp_path / "toy.fmu", ports=ports))) == []


def test_contents(tmp_path: Path) -> None:
    mesh = tmp_path / "mesh.stl"
    mesh.write_bytes(b"solid")
    resources = {"x_start.txt": b"0.25", "robot/meshes/a.stl": mesh}
    path = write(tmp_path / "toy.fmu", resources=resources)
    with zipfile.ZipFile(path) as archive:
        assert archive.testzip() is None
        binary = f"binaries/{platform_name()}/toy{library_path().suffix}"
        assert set(archive.namelist()) == {
            "modelDescription.xml",
            binary,
            "resources/model.json",
            "resources/ports.bin",
            "resources/x_start.txt",
            "resources/robot/meshes/a.stl",
        }
        assert archive.read(binary) == library_path().read_bytes()
        assert archive.read("resources/robot/meshes/a.stl") == b"solid"
        assert json.loads(archive.read("resources/model.json"))["class"] == "toy_model:ToyModel"


def test_same_input_same_bytes(tmp_path: Path) -> None:
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


def test_nothing_but_the_fmu_is_left(tmp_path: Path) -> None:
    write(tmp_path / "toy.fmu")
    write(tmp_path / "toy.fmu", step=2e-3)
    assert [path.name for path in tmp_path.iterdir()] == ["toy.fmu"]


@pytest.mark.parametrize(
    "name", ["", ".", "/etc/x", "../x", "a/../../x", "a\\b", "C:x", "model.json", "ports.bin"]
)
def test_refuses_resource_names(tmp_path: Path, name: str) -> None:
    with pytest.raises(InputError, match="resource"):
        write(tmp_path / "toy.fmu", resources={name: b""})


def test_says_which_resource_is_missing(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"gone\.stl: cannot be read: No such file"):
        write(tmp_path / "toy.fmu", resources={"a": tmp_path / "gone.stl"})


def test_says_where_it_cannot_write(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"toy\.fmu: cannot be written: No such file"):
        write(tmp_path / "no such folder" / "toy.fmu")


def test_refuses_a_class_that_cannot_be_imported(tmp_path: Path) -> None:
    class Local(ToyModel):
        pass

    with pytest.raises(InputError, match="define the class in a module"):
        write(tmp_path / "toy.fmu", model_class=Local)


def test_says_what_to_do_without_a_library(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CARDSFLOW_LIBRARY_DIR", str(tmp_path))
    with pytest.raises(InputError, match="hatch_build"):
        write(tmp_path / "toy.fmu")


def test_says_which_machines_have_no_name_in_fmi(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("platform.machine", lambda: "riscv64")
    with pytest.raises(InputError, match="riscv64"):
        platform_name()
