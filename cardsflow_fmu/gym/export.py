"""Trained networks as policies for controllers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from addin_sdfusion.robot import InputError
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.experiment.policy import Policy, read_policy, write_policy
from cardsflow_fmu.simulation.build import build_fmus
from cardsflow_fmu.utils.folder_lock import create_new_folder

from .env import CardsflowEnv
from .experiments import TaskKind, from_experiment
from .networks import layer_pairs, read_network

MIN_SD = 1e-4


def export_policy(
    env: Any,
    layers: Sequence[tuple[Any, Any]] | Mapping[str, Any],
    file: str | Path,
    *,
    activation: str = "tanh",
    last: str = "linear",
    mean: Any = None,
    sd: Any = None,
    max_input: float = 100.0,
) -> Policy:
    """Write a trained network as a policy file, for `controller.type = "policy"`.

    Args:
        env: The environment in which it was trained.
        layers: Weights, shape (outputs, inputs), and bias of each layer; or a state dictionary of
            PyTorch that contains only these, in order.
        file: JSON file to write.
        activation: Function of the inner layers: `tanh`, `relu`, `elu`, `sigmoid` or `linear`.
        last: Function of the last layer.
        mean: Means of the observations by which the network's inputs were normalised (default: 0).
        sd: Standard deviations of the observations (default: 1).
        max_input: Largest sound normalised input. Beyond it, the controller applies the fallback,
            the smallest commands.

    Raises:
        InputError: The network does not fit the environment, or the environment's observations are
            not those of a controller.
    """
    episodes = getattr(getattr(env, "unwrapped", None), "episodes", None)
    if episodes is None:
        raise InputError(
            f"env must be an environment of cardsflow_fmu.gym, not {type(env).__name__}"
        )
    task, actions, batch = episodes.task, episodes.actions, episodes.batch
    if task.columns is not None:
        raise InputError(
            "the observations of this task are not those of a controller; choose targets for all "
            "coordinates, or for all points of the operational space"
        )
    size = episodes.observations().shape[1]
    pairs = layer_pairs(layers)
    has_activations = bool(task.activation_columns(batch))
    parts = ("q", "qd", *task.layout, *(("activations",) if has_activations else ()))
    names, low, high, rest = actions.ranges()
    functions = [activation] * (len(pairs) - 1) + [last]
    stack: Any = [
        {"weights": weights, "bias": bias, "activation": function}
        for (weights, bias), function in zip(pairs, functions, strict=True)
    ]
    outputs: Any = [
        {"name": name, "low": a, "high": b, "fallback": c}
        for name, a, b, c in zip(names, low, high, rest, strict=True)
    ]
    policy = Policy(
        step=batch.step_size,
        inputs=parts,
        mean=np.zeros(size) if mean is None else mean,
        sd=np.ones(size) if sd is None else np.maximum(np.asarray(sd), MIN_SD),
        max_input=max_input,
        layers=stack,
        map="sigmoid" if actions.is_sigmoid else "range",
        outputs=outputs,
    )
    policy.numbers(episodes.setup.robot, task.space)  # checks the sizes
    write_policy(policy, Path(file))
    return policy


def export_network(
    network: str | Path,
    experiment: str | Path,
    folder: str | Path,
    settings: Mapping[str, Any] | None = None,
    *,
    task: TaskKind = "track",
    step: float = 0.02,
    activation: str = "tanh",
) -> list[Path]:
    """Build controller.fmu of a trained network, in C, and write its policy.json next to it.

    Args:
        network: State dictionary of PyTorch (.pt, .pth), ONNX (.onnx), or a policy (.json).
        experiment: The experiment.toml, or its folder.
        folder: New or empty folder.
        settings: Changes of the experiment by full key.
        task: Task of `from_experiment` in which the network was trained.
        step: Length of its step, in [s].
        activation: Function of the inner layers of a state dictionary.

    Returns:
        Paths of policy.json and controller.fmu.

    Raises:
        InputError: The network cannot be read, or does not fit the experiment.
    """
    file, overrides = Path(network), dict(settings or {})
    target = Path(folder)
    with create_new_folder(target, "policy"):
        written = target / "policy.json"
        spaces = {"pose": "joint", "reach": "operational"}
        space = spaces.get(task) or Experiment.load(experiment, overrides).reference.space
        changes = {"type": "policy", "policy": str(written.absolute()), "period": step}
        if space != "joint":
            changes["space"] = space
        overrides |= {f"controller.{key}": value for key, value in changes.items()}
        env = from_experiment(experiment, overrides, task=task, step=step)
        assert isinstance(env, CardsflowEnv)
        if file.suffix == ".json":
            write_policy(read_policy(file), written)
        else:
            layers, functions = read_network(file)
            inner, last = (functions[0], functions[-1]) if functions else (activation, "linear")
            export_policy(env, layers, written, activation=inner, last=last)
        loaded = Experiment.load(experiment, overrides)
        return [written, *build_fmus(loaded, target, ["controller"], native=True).values()]
