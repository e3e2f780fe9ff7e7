"""Policies as controllers in C: they compute what their networks compute, without Python."""

from __future__ import annotations

import json
import runpy
from collections.abc import Callable
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from support.policies import actions_of, random_network, ranges
from support.robots.robots import EXAMPLES

import cardsflow_fmu.gym as gym
from addin_sdfusion.robot import InputError
from cardsflow_fmu import Experiment, build, run
from cardsflow_fmu.experiment.policy import Policy, read_policy
from cardsflow_fmu.gym.export import export_network, export_policy
from cardsflow_fmu.models.controller import ControllerModel

PLANAR, FLOWER = EXAMPLES / "planar_2r", EXAMPLES / "roboy_left_arm"
HILL = EXAMPLES / "hill_arm"


def _export(env: Any, file: Path, activation: str = "tanh", **options: Any) -> Policy:
    inputs, outputs = env.observation_space.shape[0], env.action_space.shape[0]
    return export_policy(
        env, random_network([inputs, 16, 8, outputs]), file, activation=activation, **options
    )


def _settings(file: Path, env: Any, **more: Any) -> dict[str, Any]:
    task = env.episodes.task
    space = {} if task.space == "joint" else {"controller.space": task.space}
    return {"controller.type": "policy", "controller.policy": str(file), **space, **more}


@pytest.mark.native
@pytest.mark.parametrize(
    ("example", "activation"),
    [(PLANAR, "tanh"), (PLANAR, "relu"), (FLOWER, "elu"), (HILL, "sigmoid")],
    ids=["planar-tanh", "planar-relu", "flower-elu", "hill-sigmoid"],
)
def test_commands_of_a_run_are_those_of_the_network(
    example: Path, activation: str, tmp_path: Path
) -> None:
    """The observations of the environment, from the columns of a run, lead to its commands."""
    env = gym.from_experiment(example)
    size = env.observation_space.shape[0]
    normal = {"mean": np.linspace(-0.2, 0.2, size), "sd": np.linspace(0.5, 2.0, size)}
    file = tmp_path / "policy.json"
    policy = _export(env, file, activation, **normal)
    period = {"controller.period": 0.02, "run.duration": 0.4}
    experiment = Experiment.load(example, _settings(file, env, **period))
    result = run(experiment, tmp_path / "run", coupling="direct")
    rows = [int(np.argmin(np.abs(result["time"] - 0.02 * k))) for k in range(1, 12)]
    table = {name: result[name][rows] for name in result.names}

    def columns(*prefixes: str) -> np.ndarray:
        chosen = [name for p in prefixes for name in table if name.startswith(f"{p}.")]
        return np.stack([table[name] for name in chosen], axis=1)

    space = env.episodes.task.space
    at, wanted, rate = ("q", "q_d", "qd_d") if space == "joint" else ("y", "y_d", "yd_d")
    parts = [columns("q"), 0.02 * columns("qd")]
    parts += [] if space == "joint" else [columns("y")]
    parts += [columns(wanted) - columns(at), 0.02 * columns(rate)]
    if example == HILL:
        parts.append(columns("activation"))
    actions = actions_of(policy, np.concatenate(parts, axis=1))
    low, high, _ = ranges(policy)
    if policy.map == "range":
        expected = low + 0.5 * (1.0 + actions) * (high - low)
    else:
        expected = 1.0 / (1.0 + np.exp(-5.0 * (actions - 0.5)))
        expected = np.clip(expected, low, high)
    assert np.ptp(actions, axis=0).max() > 1e-3
    np.testing.assert_allclose(columns("u" if example == HILL else "f"), expected, rtol=1e-9)
    if example != HILL:  # whose muscles start at rest in the environment
        observation, _ = env.reset(seed=0)
        for q in columns("q"):
            action = actions_of(policy, observation.astype(float))
            observation, *_ = env.step(action.astype(np.float32))
            np.testing.assert_allclose(env.episodes.batch.q[0], q, atol=2e-5)


@pytest.mark.native
def test_a_policy_fmu_computes_the_network_without_python(tmp_path: Path) -> None:
    env = gym.from_experiment(PLANAR, task="pose")
    layers = random_network([6, 12, 4])
    policy = export_policy(env, layers, tmp_path / "policy.json", max_input=5.0)

    files = export_network(tmp_path / "policy.json", PLANAR, tmp_path / "out", task="pose")
    description = fmpy.read_model_description(str(files[1]))
    unpacked = fmpy.extract(str(files[1]), str(tmp_path / "unpacked"))
    assert not list(Path(unpacked).rglob("*.py"))
    references = {v.name: v.valueReference for v in description.modelVariables}
    fmu = fmpy.instantiate_fmu(unpacked, description, "CoSimulation")
    fmu.setupExperiment(startTime=0.0)
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    rng, t = np.random.default_rng(1), 0.0
    low, high, fallback = ranges(policy)
    names = [f"{n}.joint_{i}" for n in ("q", "qd", "q_d") for i in (1, 2)]
    outputs = [references[f"f.cable_{i}"] for i in range(1, 5)]
    for k in range(30):
        q, qd, q_d = rng.uniform(-1.0, 1.0, (3, 2)) * (1.0 if k < 29 else 50.0)
        fmu.setReal([references[name] for name in names], [*q, *qd, *q_d])
        fmu.doStep(t, 0.02)
        t += 0.02
        actions = actions_of(policy, np.array([*q, *(0.02 * qd), *(q_d - q)]))
        expected = low + 0.5 * (1.0 + actions) * (high - low)
        is_fallback = fmu.getBoolean([references["infeasible"]])[0]
        assert bool(is_fallback) == (k == 29)
        expected = fallback if is_fallback else expected
        np.testing.assert_allclose(fmu.getReal(outputs), expected, rtol=1e-12)
    fmu.terminate()
    fmu.freeInstance()


@pytest.mark.native
def test_fmpy_as_the_master_moves_the_robot_as_the_environment_does(tmp_path: Path) -> None:
    """The environment rounds observations and actions to 24 bits; the motion amplifies this."""
    env, file = gym.from_experiment(PLANAR), tmp_path / "policy.json"
    size = env.observation_space.shape[0]
    policy = export_policy(env, random_network([size, 4]), file)
    settings = _settings(file, env, **{"controller.period": 0.02, "run.duration": 0.4})
    build(Experiment.load(PLANAR, settings), tmp_path / "fmus")
    cosimulate = runpy.run_path(str(EXAMPLES / "fmpy_script/cosimulate.py"))["cosimulate"]
    rows = cosimulate(tmp_path / "fmus")[::20]
    observation, _ = env.reset(seed=0)
    for row in rows:
        q = [row[f"q.{c.name}"] for c in env.episodes.setup.robot.coordinates]
        np.testing.assert_allclose(env.episodes.batch.q[0], q, atol=2e-6)
        observation, *_ = env.step(actions_of(policy, observation.astype(float)).astype("f4"))
    assert len(rows) == 21
    assert abs(rows[-1]["q.joint_1"] - rows[0]["q.joint_1"]) > 0.1


@pytest.mark.parametrize("example", [PLANAR, FLOWER], ids=["own joint space", "flower"])
def test_policies_are_exported_for_references_that_the_own_controller_cannot_follow(
    example: Path, tmp_path: Path
) -> None:
    points = [{"time": t, "y": [0.3, 1.95]} for t in (0, 2)]
    given = {"reference": {"points": points}} if example == PLANAR else {}
    task = "reach" if example == PLANAR else "track"
    settings = {**given, "controller.type": "operational_space"} if example == PLANAR else {}
    env = gym.from_experiment(example, settings, task=task)
    _export(env, tmp_path / "policy.json")
    files = export_network(tmp_path / "policy.json", example, tmp_path / "out", given, task=task)
    assert [file.name for file in files] == ["policy.json", "controller.fmu"]


WRONG: dict[str, tuple[Callable[[dict[str, Any]], object], str]] = {
    "format": (lambda d: d.update(format="x"), "is not a policy"),
    "missing": (lambda d: d.pop("layers"), "layers: missing"),
    "part": (lambda d: d.update(inputs=["q", "speed"]), "input 'speed'"),
    "size": (lambda d: d.update(inputs=["q", "qd"]), "has 6 inputs, but q, qd of this robot"),
    "space": (lambda d: d.update(inputs=["q", "qd", "y"]), "input 'y' needs a reference in op"),
    "sd": (lambda d: d.update(sd=[0.0] * 6), "sd must be positive"),
    "nan": (lambda d: d.update(mean=[None] * 6), "mean: must be finite numbers"),
    "ragged": (lambda d: d["layers"][0].update(weights=[[1], [1, 2]]), "rows of equal length"),
    "layer": (lambda d: d["layers"].pop(0), "layer 0: weights have shape"),
    "outputs": (lambda d: d["outputs"].pop(), "the last layer has 4 outputs, but 3 are named"),
    "muscle": (lambda d: d["outputs"][0].update(name="cable_9"), "muscle or motor 'cable_9'"),
    "fallback": (lambda d: d["outputs"][1].update(fallback=-1.0), "'cable_2' must have low <="),
    "activation": (lambda d: d["layers"][0].update(activation="cos"), "activation 'cos'"),
    "map": (lambda d: d.update(map="log"), "map 'log'"),
    "step": (lambda d: d.update(step=0.01), "controller.period: must be 0.01 s, the step of the"),
}


@pytest.mark.parametrize(("change", "message"), WRONG.values(), ids=WRONG)
def test_wrong_policies_are_rejected_with_one_line(
    change: Callable[[dict[str, Any]], object], message: str, tmp_path: Path
) -> None:
    env = gym.from_experiment(PLANAR, task="pose")
    file = tmp_path / "policy.json"
    export_policy(env, random_network([6, 8, 4]), file)
    data = json.loads(file.read_text())
    change(data)
    file.write_text(json.dumps(data))
    experiment = Experiment.load(PLANAR, _settings(file, env, **{"controller.period": 0.02}))
    with pytest.raises(InputError, match=message) as caught:
        ControllerModel(experiment)
    assert "\n" not in str(caught.value)


def test_networks_that_do_not_fit_are_rejected(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="must be an environment"):
        export_policy("planar_2r", random_network([5, 4]), tmp_path / "a.json")
    env = gym.from_experiment(PLANAR, task="pose", targets={"joint_1": (0.0, 1.0)})
    with pytest.raises(InputError, match="not those of a controller"):
        export_policy(env, random_network([5, 4]), tmp_path / "a.json")
    env = gym.from_experiment(PLANAR, task="pose")
    with pytest.raises(InputError, match="layer 0: weights have shape"):
        export_policy(env, random_network([5, 4]), tmp_path / "a.json")
    for name, what in (
        ("a.txt", "is not a network"),
        ("a.onnx", "needs the package|cannot be read"),
    ):
        with pytest.raises(InputError, match=what):
            export_network(tmp_path / name, PLANAR, tmp_path / "out", task="pose")


def test_a_policy_is_saved_with_runs_and_needs_its_type(tmp_path: Path) -> None:
    env = gym.from_experiment(PLANAR, task="pose")
    file = tmp_path / "policy.json"
    export_policy(env, random_network([6, 4]), file)
    settings = _settings(file, env, **{"controller.period": 0.02, "run.duration": 0.1})
    result = run(Experiment.load(PLANAR, settings), tmp_path / "run")
    assert read_policy(result.experiment.controller.policy).outputs[0].name == "cable_1"
    with pytest.raises(InputError, match=r"controller\.policy: missing"):
        Experiment.load(PLANAR, {"controller.type": "policy"})
    with pytest.raises(InputError, match=r"controller\.policy: is only for the type 'policy'"):
        Experiment.load(PLANAR, {"controller.policy": str(file)})
