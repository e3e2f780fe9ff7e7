"""Custom controllers: a class in a Python file next to the experiment."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.experiments import copy_arm
from support.robots.robots import EXAMPLES

from addin_sdfusion.robot import CardsflowError, InputError, SimulationError
from cardsflow_fmu import Experiment, run
from cardsflow_fmu.experiment.writer import experiment_resources
from cardsflow_fmu.results.saved_run import opened_run
from cardsflow_fmu.simulation.run import simulate

CODE = '''"""Computed torque with gains of its own, and some that are wrong."""

import numpy as np

from controllers import JointSpaceController, OperationalSpaceController


class Stiff(JointSpaceController):
    def required_torque(self, q, qd, q_d, qd_d, qdd_d, *, w_e=None, correction=None):
        own = 2000.0 * (q_d - q) + 90.0 * (qd_d - qd)
        return super().required_torque(q, qd, q, qd, qdd_d + own, w_e=w_e, correction=correction)


class Forces(JointSpaceController):
    def solve(self, q, qd, q_d, qd_d, qdd_d, *, w_e=None, correction=None):
        return np.array([20.0, 200.0, 30.0, 40.0])


class Hand(OperationalSpaceController):
    pass


class Divides(JointSpaceController):
    def solve(self, q, qd, q_d, qd_d, qdd_d, *, w_e=None, correction=None):
        return np.ones(4) / (1 // 0)


class NoNumbers(JointSpaceController):
    def solve(self, *state, **loads):
        return np.full(4, np.nan)


class TooFew(JointSpaceController):
    def solve(self, *state, **loads):
        return np.ones(3)


class Nothing:
    pass
'''
LINE_OF_DIVIDES = 1 + CODE[: CODE.index("1 // 0")].count("\n")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return copy_arm(tmp_path, mine=CODE)


def with_law(folder: Path, name: str, **settings: Any) -> Experiment:
    changes = {"controller.type": f"mine.py:{name}", "run.duration": 0.2} | settings
    return Experiment.load(folder, changes)


@pytest.mark.slow
def test_custom_controller_equals_the_built_in_one_with_equal_gains(folder: Path) -> None:
    ours = simulate(Experiment.load(folder, {"run.duration": 0.2}), coupling="direct")
    own = simulate(with_law(folder, "Stiff"), coupling="direct")
    np.testing.assert_allclose(own["q.joint_1"], ours["q.joint_1"], atol=1e-12)


def test_only_forces_are_clipped_at_the_limits(folder: Path) -> None:
    result = simulate(with_law(folder, "Forces"), coupling="direct")
    assert (result["f.cable_1"][1:] == 20.0).all()
    assert (result["f.cable_2"][1:] == 100.0).all()
    assert result.summary["infeasible_ticks"] == result.summary["ticks"]


@pytest.mark.slow
def test_custom_law_is_packed_in_fmus_and_results(folder: Path, tmp_path: Path) -> None:
    experiment = with_law(folder, "Stiff")
    direct = simulate(experiment, coupling="direct")
    result = run(experiment, tmp_path / "out", coupling="fmu")
    np.testing.assert_array_equal(result["q.joint_1"], direct["q.joint_1"])
    shutil.rmtree(folder)
    with opened_run(tmp_path / "out") as again:
        law = again.experiment.controller.custom_law
        assert law is not None
        assert law.file.read_text() == CODE


def test_no_file_outside_the_allowed_folders_is_packed(folder: Path, tmp_path: Path) -> None:
    """As for meshes, files that the user names explicitly are packed."""
    (tmp_path / "secret.py").write_text(CODE)
    text = (folder / "experiment.toml").read_text()
    text = text.replace('type = "joint_space"', 'type = "../secret.py:Stiff"')
    (folder / "experiment.toml").write_text(text)
    with pytest.raises(InputError, match=r"secret\.py"):
        experiment_resources(Experiment.load(folder))


def test_loading_does_not_execute_custom_code(folder: Path) -> None:
    (folder / "mine.py").write_text(f"open({str(folder / 'ran')!r}, 'w')\nclass A:\n    pass\n")
    with_law(folder, "A")
    assert not (folder / "ran").exists()


def test_custom_controller_in_task_space_requires_a_space(folder: Path) -> None:
    arm = folder.parent / "roboy"
    shutil.copytree(EXAMPLES / "roboy_left_arm", arm, ignore=shutil.ignore_patterns("results"))
    shutil.copy(folder / "mine.py", arm)
    settings = {"controller.type": "mine.py:Hand", "run.duration": 0.02}
    with pytest.raises(InputError, match="cannot follow a reference in operational space"):
        Experiment.load(arm, settings)
    own = simulate(
        Experiment.load(arm, settings | {"controller.space": "operational"}), coupling="direct"
    )
    ours = simulate(Experiment.load(arm, {"run.duration": 0.02}), coupling="direct")
    np.testing.assert_array_equal(own["f.motor1"], ours["f.motor1"])


@pytest.mark.parametrize(
    ("name", "error", "message"),
    [
        ("Divides", CardsflowError, f"mine.py:{LINE_OF_DIVIDES}: ZeroDivisionError"),
        ("NoNumbers", SimulationError, "NoNumbers.solve returned forces that are not finite"),
        ("TooFew", SimulationError, "TooFew.solve returned forces of shape (3,), not (4,)"),
        ("Nothing", InputError, "Nothing is not a subclass of controllers.JointSpaceController"),
        ("Hand", InputError, 'set controller.space = "operational"'),
        ("Stif", InputError, "no class 'Stif'; did you mean 'Stiff'?"),
    ],
)
def test_error_during_a_run_is_one_line_with_file_and_line(
    folder: Path, name: str, error: type[CardsflowError], message: str
) -> None:
    with pytest.raises(error) as caught:
        simulate(with_law(folder, name), coupling="direct")
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("code", "message"),
    [
        ("class Mine(:\n    pass\n", "mine.py:1: is not valid Python: "),
        ("import nothing_of_this_name\nclass Mine:\n    pass\n", "mine.py:1: ModuleNotFound"),
        ("raise SystemError('odd')\nclass Mine:\n    pass\n", "mine.py:1: SystemError: odd"),
        ("\0", "mine.py: is not valid Python: "),
    ],
)
def test_invalid_custom_controller_is_rejected(folder: Path, code: str, message: str) -> None:
    (folder / "mine.py").write_text(code)
    with pytest.raises(InputError) as caught:
        simulate(with_law(folder, "Mine"), coupling="direct")
    assert message in str(caught.value)


def test_gains_of_a_custom_controller_are_optional(folder: Path) -> None:
    text = (folder / "experiment.toml").read_text()
    lines = [line for line in text.splitlines() if not line.startswith(("kp", "kd"))]
    (folder / "experiment.toml").write_text("\n".join(lines))
    assert with_law(folder, "Stiff").controller.kp == (100.0, 100.0)
    assert with_law(folder, "Stiff", **{"controller.kp": 7.0}).controller.kp == (7.0, 7.0)
    with pytest.raises(InputError, match=r"controller\.kp: missing"):
        Experiment.load(folder)


def test_external_controller_requires_no_gains(folder: Path) -> None:
    """It does not require a table [controller] either."""
    text = (folder / "experiment.toml").read_text()
    begin, end = text.index("[controller]"), text.index("[plant]")
    (folder / "experiment.toml").write_text(text[:begin] + text[end:])
    (folder / "theirs.fmu").write_bytes(b"")
    experiment = Experiment.load(folder, {"fmus.controller": "theirs.fmu"})
    assert experiment.controller.type == "joint_space"
