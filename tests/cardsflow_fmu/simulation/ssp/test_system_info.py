"""Information about systems of FMUs: components, connections, engines."""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import Any

import pytest
from support.command_line import CommandLine
from support.robots.robots import PLANAR_2R
from support.run_modes import COMPUTE
from support.ssp_runs import simulate_system

from addin_sdfusion.robot import InputError
from cardsflow_fmu import Experiment, build
from cardsflow_fmu.results.engines import system_engines
from cardsflow_fmu.simulation.ssp.info import describe_system, system_info

SHORT = {"run.duration": 0.01}


@pytest.fixture(scope="module")
def system(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("system")
    build(Experiment.load(PLANAR_2R, SHORT), folder)
    return folder / "system.ssp"


@pytest.mark.slow
def test_info_of_a_system_lists_its_participants(system: Path) -> None:
    info = system_info(system)
    assert info["name"] == "planar_2r"
    assert (info["step"], info["stop_time"]) == (0.001, 0.01)
    assert info["variants"] == ["hardware"]
    plant = next(c for c in info["components"] if c["name"] == "plant")
    assert plant["inputs"][0] == "f.cable_1"
    assert "q.joint_1" in plant["outputs"]
    assert {"from": "controller.f.cable_2", "to": "plant.f.cable_2"} in info["connections"]
    text = describe_system(info)
    assert text.startswith("planar_2r: a system of 3 FMUs, step 0.001 s, until 0.01 s\n")
    assert "variants: hardware" in text


def test_info_command_describes_systems(
    system: Path, tmp_path: Path, cardsflow: CommandLine
) -> None:
    assert "resources/controller.fmu" in cardsflow("info", system)[1]
    assert cardsflow.json("info", system) == system_info(system)
    broken = tmp_path / "broken.ssp"
    broken.write_bytes(system.read_bytes()[:3000])
    assert "broken.ssp: is not a valid .ssp" in cardsflow.error_line("info", broken)
    assert "none.ssp: cannot be read" in cardsflow.error_line("info", tmp_path / "none.ssp")


def test_invalid_system_structure_is_reported_with_its_archive(tmp_path: Path) -> None:
    path = tmp_path / "empty.ssp"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("SystemStructure.ssd", "<nothing")
    with pytest.raises(InputError, match=r"empty\.ssp/SystemStructure\.ssd"):
        system_info(path)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("settings", "native", "engines"),
    [
        ({}, False, ("core", "core")),
        ({"plant.engine": "dart"}, False, ("dart", "core")),
        ({"controller.engine": "dart"}, False, ("core", "dart")),
        ({}, True, ("native", "native")),
    ],
)
def test_summary_of_a_system_contains_its_engines(
    settings: dict[str, Any], native: bool, engines: tuple[str, str], tmp_path: Path
) -> None:
    build(Experiment.load(PLANAR_2R, SHORT | settings), tmp_path, compute=COMPUTE[native])
    summary = simulate_system(tmp_path / "system.ssp").summary
    assert summary["engine"] == dict(zip(("plant", "controller"), engines, strict=True))
    assert summary["master"] == "C, over FMUs"


def test_external_fmu_is_selected_by_name(system: Path, tmp_path: Path) -> None:
    other = tmp_path / "other.fmu"
    other.write_bytes(b"no FMU at all")
    hardware = system.parent / "hardware.fmu"
    files = {"plant": hardware, "controller": other, "reference": other}
    assert system_engines(files) == {"plant": "hardware", "controller": "other.fmu"}
