"""Custom muscle laws: a class in a Python file next to the experiment."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.command_line import CommandLine
from support.experiments import copy_arm

from addin_sdfusion.robot import CardsflowError, InputError, SimulationError
from cardsflow_fmu import Experiment, run
from cardsflow_fmu.results.saved_run import opened_run
from cardsflow_fmu.simulation.run import simulate

CODE = '''"""An elastic cable once more, and muscles that are wrong."""

from sim_dart import MuscleLaw


class Elastic(MuscleLaw):
    command = ("rest_length", "m", 0.0, 4.0)

    def __init__(self, k, d=0.0):
        self.k, self.d = k, d

    def tension(self, u, length, rate):
        return self.k * (length - u) + self.d * rate if length > u else 0.0


class Spring(MuscleLaw):
    def tension(self, u, length, rate):
        return 100.0 * (length - 0.5)


class Divides(MuscleLaw):
    command = ("force", "N", 0.0, 100.0)

    def tension(self, u, length, rate):
        return u / (1 // 0)


class NoNumber(MuscleLaw):
    command = ("force", "N", 0.0, 100.0)

    def tension(self, u, length, rate):
        return float("nan")


class Nothing:
    command = ("force", "N", 0.0, 100.0)


class NoTension(MuscleLaw):
    command = ("force", "N", 0.0, 100.0)


class Computed(MuscleLaw):
    command = ("force", "N", 0.0, 10.0 * 10.0)


class Furlongs(MuscleLaw):
    command = ("rest_length", "furlong", 0.0, 1.0)


class Reversed(MuscleLaw):
    command = ("rest_length", "m", 1.0, 1.0)
'''


def line(text: str) -> int:
    return 1 + CODE[: CODE.index(text)].count("\n")


K, D = 2000.0, 5.0
SHIPPED = {"kind": "elastic_cable", "stiffness": K, "damping": D}
OWN = {"kind": "mine.py:Elastic", "parameters": {"k": K, "d": D}}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return copy_arm(tmp_path, mine=CODE)


def with_law(folder: Path, model: Any, pattern: str = "*", **settings: Any) -> Experiment:
    changes = {f'muscles."{pattern}".model': model, "run.duration": 0.2}
    return Experiment.load(folder, settings | changes)


@pytest.mark.parametrize(
    "settings", [{}, pytest.param({"plant.substeps": 2}, marks=pytest.mark.slow)]
)
def test_built_in_law_in_python_has_the_same_results(
    folder: Path, settings: dict[str, Any]
) -> None:
    """Motion, tensions and commands are compared, with the law on all muscles or on some."""
    dart = {"plant.engine": "dart", **settings}
    shipped = simulate(with_law(folder, SHIPPED, **dart), coupling="direct")
    assert shipped.summary["tracking"]["max"] < 0.1
    for pattern in ("*", "cable_1"):
        rest = {} if pattern == "*" else {'muscles."*".model': SHIPPED}
        own = simulate(with_law(folder, OWN, pattern, **rest, **settings), coupling="direct")
        assert own.names == shipped.names
        assert own.summary["engine"]["plant"] == "dart"
        for name in shipped.names:
            np.testing.assert_allclose(own[name], shipped[name], rtol=1e-9, atol=1e-9, err_msg=name)


def test_passive_muscle_has_no_command(folder: Path) -> None:
    result = simulate(with_law(folder, "mine.py:Spring", "cable_1"), coupling="direct")
    assert "u.cable_1" not in result.names
    expected = np.maximum(100.0 * (result["l.cable_1"] - 0.5), 0.0)
    np.testing.assert_allclose(result["tension.cable_1"], expected, atol=1e-12)


@pytest.mark.slow
def test_custom_law_is_packed_in_fmus_and_results(folder: Path, tmp_path: Path) -> None:
    experiment = with_law(folder, OWN)
    direct = simulate(experiment, coupling="direct")
    result = run(experiment, tmp_path / "out", compute="python")
    np.testing.assert_array_equal(result["q.joint_1"], direct["q.joint_1"])
    shutil.rmtree(folder)
    with opened_run(tmp_path / "out") as again:
        own = again.experiment.robot.muscles[0].model.custom
        assert own is not None
        assert Path(own.file).read_text() == CODE


def test_no_file_outside_the_allowed_folders_is_packed(folder: Path, tmp_path: Path) -> None:
    """As for meshes, files that the user names explicitly are packed."""
    (tmp_path / "secret.py").write_text(CODE)
    with (folder / "experiment.toml").open("a") as file:
        file.write('\n[muscles.cable_1]\nmodel = "../secret.py:Spring"\n')
    with pytest.raises(InputError, match=r"secret\.py"):
        run(Experiment.load(folder), tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_loading_does_not_execute_custom_code(folder: Path) -> None:
    (folder / "mine.py").write_text(f"open({str(folder / 'ran')!r}, 'w')\nclass A:\n    pass\n")
    with_law(folder, "mine.py:A")
    assert not (folder / "ran").exists()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["build", "--compute", "c"], "does not support muscle laws in Python (Elastic of cable_"),
        (
            ["run", "--coupling", "direct", "--set", "plant.engine=core"],
            'the engine "core" does not support muscle laws in Python (Elastic',
        ),
    ],
)
def test_c_only_features_reject_a_custom_law_by_name(
    folder: Path, tmp_path: Path, words: list[str], message: str, cardsflow: CommandLine
) -> None:
    model = 'muscles."*".model={kind="mine.py:Elastic", parameters={k=2000.0}}'
    command, *others = words
    words = [command, folder, "--set", model, "-o", tmp_path / "out", *others]
    assert message in cardsflow.error_line(*words)


@pytest.mark.parametrize(
    ("model", "message"),
    [
        ("mine.py:Divides", f"mine.py:{line('1 // 0')}: ZeroDivisionError"),
        ("mine.py:NoNumber", "mine.py: NoNumber.tension(0.0, "),
        ("mine.py:NoTension", "TypeError: Can't instantiate abstract class NoTension"),
        ("mine.py:Nothing", "Nothing is not a subclass of sim_dart.MuscleLaw"),
        ("mine.py:Elastc", "no class 'Elastc'; did you mean 'Elastic'?"),
        ("mine.py:Elastic", "mine.py: TypeError: Elastic.__init__() missing 1 required"),
        (
            "mine.py:Computed",
            f"mine.py:{line('10.0 * 10')}: muscles.*: Computed.command must be a literal",
        ),
        ("mine.py:Furlongs", "Furlongs.command: no unit 'furlong'"),
        ("mine.py:Reversed", "the minimum 1.0 must be below the maximum 1.0"),
        ("nowhere.py:Elastic", "nowhere.py"),
        ({"kind": "mine.py:Elastic", "stiffness": 1.0}, "model.stiffness: is not for custom laws"),
        ({"kind": "elastic_cable", "parameters": {"k": 1.0}}, "model.parameters: is only for"),
    ],
    ids=str,
)
def test_error_is_one_line_with_file_and_line(folder: Path, model: Any, message: str) -> None:
    with pytest.raises(CardsflowError) as caught:
        simulate(with_law(folder, model), coupling="direct")
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)
    assert isinstance(caught.value, InputError | SimulationError)
