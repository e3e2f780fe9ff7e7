"""Studies with FMUs."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import pytest
from support.small_studies import PLANAR, ROOT, SHORT, run_here, small_study

from cardsflow_fmu import Experiment
from cardsflow_fmu.studies import Study
from cardsflow_fmu.studies.execution import fmu_cache as fmu_store
from cardsflow_fmu.studies.execution.fmu_cache import prepared_fmus

HILL = ROOT / "examples" / "hill_arm"

PARAMETERS = """
[[vary]]
path = "controller.kp.joint_2"
values = [500.0, 2000.0]
[[vary]]
path = "muscles.cable_1.f_max"
values = [45.0, 35.0]
[[vary]]
path = "plant.step"
values = [0.01, 0.002]
"""
ROBOTS = """
[[vary]]
path = "plant.mass_scale.link_2"
values = [0.8, 1.1]
[[vary]]
path = "robot.muscles.cable_1.points[1].position[0]"
values = [0.1, 0.15]
"""
TOP = "metrics = ['tracking.rms', 'tracking.max', 'force.peak.*', 'force.rms', 'energy']\n"


LAWS = """
[[vary]]
path = "muscles.*.model.max_isometric_force"
values = [0.9, 1.1]
relative = "factor"
together = true
"""


def numbers(folder: Path) -> list[list[float]]:
    with (folder / "table.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert {row["status"] for row in rows} == {"complete"}
    names = [n for n in rows[0] if n not in ("run", "hash", "status", "error")]
    return [[float(row[name]) for name in names] for row in rows]


@pytest.mark.cases(1)
@pytest.mark.slow
@pytest.mark.parametrize("text", [PARAMETERS, ROBOTS])
def test_fmus_and_the_c_engine_match_python(tmp_path: Path, text: str) -> None:
    ways = {"direct": ("python", "direct"), "fmu": ("c", "fmu"), "native": ("c", "direct")}
    for way, (compute, coupling) in ways.items():
        top = f"{TOP}compute = '{compute}'\ncoupling = '{coupling}'"
        run_here(small_study(tmp_path, text, top), tmp_path / way)
    direct, fmu, native = (numbers(tmp_path / way) for way in ways)
    assert len(direct) >= 4
    for one, other, in_c in zip(direct, fmu, native, strict=True):
        assert one == pytest.approx(other, rel=1e-9, abs=1e-9)
        assert one == pytest.approx(in_c, rel=1e-9, abs=1e-9)
    assert len({tuple(row[-3:]) for row in direct}) > 1


@pytest.mark.slow
def test_muscle_laws_run_with_fmus(tmp_path: Path) -> None:
    """A robot with these muscle laws has no hardware.fmu."""
    rows = []
    for coupling in ("direct", "fmu"):
        top = f"experiment = '{HILL}'\ncoupling = '{coupling}'\nmetrics = ['force.peak.*']\n"
        file = tmp_path / "study.toml"
        file.write_text(f"{top}[settings]\nrun.duration = 0.02\n{LAWS}")
        run_here(Study.load(file), tmp_path / coupling)
        rows.append(numbers(tmp_path / coupling))
    assert rows[0] == [pytest.approx(row, rel=1e-9, abs=1e-9) for row in rows[1]]
    assert rows[0][0] != rows[0][1]


@pytest.mark.slow
def test_parameter_variations_reuse_the_fmus(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    built: list[Any] = []
    build = fmu_store.build

    def counting(experiment: Experiment, folder: Path) -> Any:
        built.append(experiment)
        return build(experiment, folder)

    monkeypatch.setattr(fmu_store, "build", counting)
    base = Experiment.load(PLANAR, {"run.step": 0.01, "controller.period": 0.02})
    settings = {"run.step": 0.01, "controller.period": 0.02, "start.q": [-0.4, 0.4]}
    changed = {**settings, "controller.kd": 80.0, "muscles.cable_3.f_min": 5.0}
    first = prepared_fmus(base, base, tmp_path / "nowhere")
    second = prepared_fmus(base, Experiment.load(PLANAR, changed), tmp_path / "nowhere")
    assert len(built) <= 1
    assert [fmu.folder for fmu in first.values()] == [fmu.folder for fmu in second.values()]
    assert not any(fmu.start_values for fmu in first.values())
    assert second["plant"].start_values == {"q_start.joint_1": -0.4, "q_start.joint_2": 0.4}
    assert second["controller"].start_values == {
        "kd.joint_1": 80.0,
        "kd.joint_2": 80.0,
        "f_min.cable_3": 5.0,
    }
    heavier = Experiment.load(PLANAR, {**settings, "plant.mass_scale": 1.1})
    third = prepared_fmus(base, heavier, tmp_path / "nowhere")
    assert third["plant"].folder != first["plant"].folder


@pytest.mark.slow
def test_the_number_of_cached_fmus_is_limited(tmp_path: Path) -> None:
    base = Experiment.load(PLANAR, {"run.step": 0.01, "controller.period": 0.02})
    for scale in (1.1, 1.2, 1.3, 1.4, 1.5, 1.6):
        settings = {"run.step": 0.01, "controller.period": 0.02, "plant.mass_scale": scale}
        last = prepared_fmus(base, Experiment.load(PLANAR, settings), tmp_path)["plant"].file
    cached = list(last.parents[1].iterdir())
    assert len(cached) <= fmu_store.MAX_CACHED
    assert last.is_file()


@pytest.mark.slow
def test_fmus_of_the_experiment_are_built_once(tmp_path: Path) -> None:
    study = small_study(tmp_path, PARAMETERS, "coupling = 'fmu'", SHORT)
    run_here(study, tmp_path / "out")
    assert {file.name for file in (tmp_path / "out" / "fmus").iterdir()} == {
        "system.ssp",
        "plant.fmu",
        "hardware.fmu",
        "controller.fmu",
        "reference.fmu",
    }
