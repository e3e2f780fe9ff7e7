"""FMUs compute in C if the experiment permits it, otherwise in Python; commands report which."""

from __future__ import annotations

import json
import zipfile
from pathlib import Path

import pytest
from support.command_line import CommandLine
from support.robots.robots import EXAMPLES, PLANAR_2R

from cardsflow_fmu import Experiment
from cardsflow_fmu.simulation.build import build

SHORT = ("--set", "run.duration=0.05")
PICK_UP = EXAMPLES / "pick_up"


def kinds(folder: Path) -> dict[str, bool]:
    """Return for each model whether its FMU computes in C."""
    found = {}
    for file in folder.glob("*.fmu"):
        with zipfile.ZipFile(file) as archive:
            found[file.stem] = "resources/native.bin" in archive.namelist()
    return found


IN_C = {"plant": True, "controller": True, "reference": True, "hardware": False}


@pytest.mark.parametrize(
    ("words", "expected", "said"),
    [
        ((PLANAR_2R,), IN_C, ""),
        ((PLANAR_2R, "--compute", "python"), dict.fromkeys(IN_C, False), ""),
        ((PLANAR_2R, "--compute", "c"), {k: v for k, v in IN_C.items() if v}, ""),
        (
            (PICK_UP,),
            IN_C | {"plant": False},
            "plant.fmu uses Python; the C engine does not support worlds with contacts",
        ),
        ((PLANAR_2R, "--set", "controller.type=lyapunov"), IN_C, ""),
        (
            (PLANAR_2R, "--set", "controller.solver=daqp"),
            IN_C | {"controller": False},
            "controller.fmu uses Python; the C engine does not support the QP solver 'daqp'",
        ),
        (
            (PLANAR_2R, "--set", "plant.engine=dart"),
            IN_C | {"plant": False},
            'plant.fmu uses Python; the C engine does not support the engine "dart"',
        ),
    ],
)
def test_build_reports_how_fmus_compute(
    words: tuple, expected: dict[str, bool], said: str, tmp_path: Path, cardsflow: CommandLine
) -> None:
    code, _, err = cardsflow("build", *words, *SHORT, "-o", tmp_path)
    assert code == 0
    assert kinds(tmp_path) == expected
    assert said in err
    for model in ("plant", "controller"):
        assert (f"{model} native" in err) == expected[model]


@pytest.mark.parametrize(
    ("setting", "named"),
    [
        ("controller.solver=daqp", "the QP solver 'daqp'"),
        ("plant.engine=dart", 'the engine "dart"'),
        ("controller.engine=dart", 'the engine "dart"'),
    ],
)
def test_compute_c_requires_that_all_fmus_are_native(
    setting: str, named: str, tmp_path: Path, cardsflow: CommandLine
) -> None:
    out = tmp_path / "out"
    said = cardsflow.error_line("build", PLANAR_2R, "--compute", "c", "--set", setting, "-o", out)
    assert named in said
    assert not out.exists()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("words", "engine"),
    [
        ((PLANAR_2R,), {"plant": "native", "controller": "native"}),
        ((PLANAR_2R, "--compute", "python"), {"plant": "core", "controller": "core"}),
        ((PICK_UP,), {"plant": "dart", "controller": "native"}),
    ],
)
def test_run_reports_how_fmus_compute(
    words: tuple, engine: dict[str, str], tmp_path: Path, cardsflow: CommandLine
) -> None:
    code, out, _ = cardsflow("run", *words, *SHORT, "-o", tmp_path)
    assert code == 0
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert summary["engine"] == engine
    native = {name for name, is_native in kinds(tmp_path).items() if is_native}
    assert native >= {role for role, kind in engine.items() if kind == "native"}
    (line,) = (line for line in out.splitlines() if line.startswith("engine"))
    assert ("plant in Python: not in C: worlds with contacts" in line) == (words[0] == PICK_UP)


@pytest.mark.slow
def test_fmus_of_both_kinds_contain_libraries_for_other_platforms(tmp_path: Path) -> None:
    """Also if the current platform is requested by name."""
    from cardsflow_fmu.runtime.library import this_platform

    experiment = Experiment.load(PICK_UP, {"run.duration": 0.05})
    files = build(experiment, tmp_path, platforms=[this_platform().tuple])
    sizes = {}
    for name in ("plant", "controller"):
        with zipfile.ZipFile(files[name]) as archive:
            (binary,) = (i for i in archive.infolist() if i.filename.startswith("binaries/"))
            sizes[name] = binary.file_size
    assert sizes["plant"] != sizes["controller"]
