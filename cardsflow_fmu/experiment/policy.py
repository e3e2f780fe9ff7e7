"""Policies: multilayer perceptrons that compute the commands of a controller, as JSON files."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from addin_sdfusion.robot import InputError, Robot, UnknownNameError
from addin_sdfusion.robot.files import write_files
from addin_sdfusion.robot.json_text import json_text
from addin_sdfusion.robot.model.muscle_laws import states_of
from addin_sdfusion.robot.model.trajectory import Space
from cardsflow_fmu.cosim.signals.muscles import driven_muscles, ideal_muscles, state_order
from cardsflow_fmu.utils.arrays import FloatArray

from .config.file import read_settings

FORMAT = "cardsflow-policy-1"

PARTS = ("q", "qd", "y", "error", "rate", "activations")
"""Parts of observations, in the order of `enum policy_part`."""

ACTIVATIONS = ("linear", "tanh", "relu", "elu", "sigmoid")
"""Functions of layers, in the order of `enum policy_activation`."""

MAPS = ("range", "sigmoid")


@dataclass(frozen=True, eq=False)
class Layer:
    """Layer: activation(weights x + bias).

    Attributes:
        weights: Weights, shape (outputs, inputs).
        bias: Bias, shape (outputs,).
        activation: Name from `ACTIVATIONS`.
    """

    weights: FloatArray
    bias: FloatArray
    activation: str


@dataclass(frozen=True, eq=False)
class Policy:
    """Policy from observations to commands.

    Attributes:
        step: Time between two ticks, in [s]; velocities in the observation are multiplied by it.
        parts: Names from `PARTS`, in the order of the observation.
        mean: Means of the observation, shape (k,).
        sd: Standard deviations of the observation, shape (k,).
        max_input: Largest sound normalised input; beyond it, the outputs are the fallback.
        layers: The layers. The last one computes actions from -1 to 1.
        map: Map from actions to commands, see `MAPS` and `cardsflow_fmu.gym.actions.Actions`.
        outputs: Names of muscles and of coordinates with motors.
        low: Smallest commands, shape (outputs,).
        high: Largest commands, shape (outputs,).
        fallback: Commands if an input is not sound, shape (outputs,).
    """

    step: float
    parts: tuple[str, ...]
    mean: FloatArray
    sd: FloatArray
    max_input: float
    layers: tuple[Layer, ...]
    map: str
    outputs: tuple[str, ...]
    low: FloatArray
    high: FloatArray
    fallback: FloatArray

    def numbers(self, robot: Robot, space: Space) -> FloatArray:
        """Return the numbers of the policy for the C library; see `policy_open` in policy.h.

        Raises:
            InputError: The policy does not fit the robot.
        """
        columns = activation_inputs(robot)
        self._require_inputs(robot, space, len(columns))
        sizes = [self.mean.size, len(self.outputs), len(self.layers), len(self.parts), len(columns)]
        settings = [self.step, self.max_input, float(self.map == "sigmoid")]
        targets = [number for name in self.outputs for number in _target(robot, name)]
        network = [
            number
            for layer in self.layers
            for number in (
                *layer.weights.shape,
                ACTIVATIONS.index(layer.activation),
                *layer.weights.reshape(-1),
                *layer.bias,
            )
        ]
        parts = [PARTS.index(part) for part in self.parts]
        normal = [*self.mean, *(1.0 / self.sd)]
        ends = [*self.low, *self.high, *self.fallback]
        return np.array([*sizes, *settings, *parts, *columns, *targets, *normal, *network, *ends])

    def _require_inputs(self, robot: Robot, space: Space, activations: int) -> None:
        n, k = len(robot.coordinates), sum(len(f.axes) for f in robot.task_frames)
        followed = n if space == "joint" else k
        sizes = {"q": n, "qd": n, "error": followed, "rate": followed, "activations": activations}
        if space == "operational":
            sizes["y"] = k
        for part in self.parts:
            if part not in sizes:
                raise InputError(f"input {part!r} needs a reference in operational space")
        expected = sum(sizes[part] for part in self.parts)
        if expected != self.mean.size:
            raise InputError(
                f"has {self.mean.size} inputs, but {', '.join(self.parts)} of this robot with a "
                f"reference in {space} space have {expected}"
            )


def activation_inputs(robot: Robot) -> list[int]:
    """Return the indices of the activations among the states that a controller reads."""
    names = [state.name for muscle in robot.muscles for state in states_of(muscle.model)]
    return [k for k, i in enumerate(state_order(robot)) if names[i] == "activation"]


def _target(robot: Robot, name: str) -> tuple[int, int]:
    """Return whether an output is a command of a muscle law, and its index."""
    muscles = [muscle.name for muscle in robot.muscles]
    driven, motors = driven_muscles(robot), [c.name for c in robot.coordinates if c.actuated]
    if name in muscles and muscles.index(name) in driven:
        return 1, driven.index(muscles.index(name))
    if name in muscles and muscles.index(name) in ideal_muscles(robot):
        return 0, muscles.index(name)
    if name in motors:
        return 0, len(muscles) + motors.index(name)
    raise UnknownNameError("muscle or motor", name, [*muscles, *motors])


def write_policy(policy: Policy, file: Path) -> Path:
    """Write a policy as JSON."""
    data = {
        "format": FORMAT,
        "step": policy.step,
        "inputs": list(policy.parts),
        "mean": policy.mean.tolist(),
        "sd": policy.sd.tolist(),
        "max_input": policy.max_input,
        "layers": [
            {
                "activation": layer.activation,
                "weights": layer.weights.tolist(),
                "bias": layer.bias.tolist(),
            }
            for layer in policy.layers
        ],
        "map": policy.map,
        "outputs": [
            {"name": name, "low": low, "high": high, "fallback": fallback}
            for name, low, high, fallback in zip(
                policy.outputs,
                policy.low.tolist(),
                policy.high.tolist(),
                policy.fallback.tolist(),
                strict=True,
            )
        ],
    }
    return write_files(file.parent, {file.name: json_text(data, indent=1) + "\n"})[0]


def read_policy(file: Path) -> Policy:
    """Read a policy from JSON.

    Raises:
        InputError: The file cannot be read, or is not a valid policy.
    """
    data = read_settings(file)
    if data.get("format") != FORMAT:
        raise InputError(f"is not a policy: its format must be {FORMAT!r}", file=file)
    try:
        return make_policy(data)
    except InputError as error:
        error.file = file
        raise
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise InputError(f"is not a valid policy: {error!r}", file=file) from None


def make_policy(data: dict[str, Any]) -> Policy:
    """Return a policy from plain data, as in a file.

    Raises:
        InputError: A value is invalid.
    """
    outputs = data["outputs"]
    policy = Policy(
        float(data["step"]),
        tuple(map(str, data["inputs"])),
        _array("mean", data["mean"], 1),
        _array("sd", data["sd"], 1),
        float(data.get("max_input", 100.0)),
        tuple(
            Layer(
                _array("weights", one["weights"], 2),
                _array("bias", one["bias"], 1),
                str(one["activation"]),
            )
            for one in data["layers"]
        ),
        str(data["map"]),
        tuple(str(one["name"]) for one in outputs),
        *(_array(key, [one[key] for one in outputs], 1) for key in ("low", "high", "fallback")),
    )
    _check(policy)
    return policy


def _array(label: str, values: Any, dimensions: int) -> FloatArray:
    try:
        array = np.array(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError(f"{label} must be numbers in rows of equal length") from None
    if array.ndim != dimensions or not array.size or not np.isfinite(array).all():
        raise InputError(f"{label} must be finite numbers with {dimensions} dimensions")
    return array


def _check(policy: Policy) -> None:
    """Check sizes and ranges."""
    for part in policy.parts:
        if part not in PARTS:
            raise UnknownNameError("input", part, PARTS)
    if policy.map not in MAPS:
        raise UnknownNameError("map", policy.map, MAPS)
    if not (policy.step > 0 and math.isfinite(policy.step)):
        raise InputError(f"step must be a positive time in s, not {policy.step}")
    if not policy.max_input > 0:
        raise InputError(f"max_input must be positive, not {policy.max_input}")
    if policy.sd.shape != policy.mean.shape or not (policy.sd > 0).all():
        raise InputError("sd must be positive and have the size of mean")
    size = policy.mean.size
    for k, layer in enumerate(policy.layers):
        if layer.activation not in ACTIVATIONS:
            raise UnknownNameError("activation", layer.activation, ACTIVATIONS)
        rows, columns = layer.weights.shape
        if columns != size or layer.bias.shape != (rows,):
            raise InputError(
                f"layer {k}: weights have shape {layer.weights.shape} and bias "
                f"{layer.bias.shape}, but the layer has {size} inputs"
            )
        size = rows
    if not policy.layers or size != len(policy.outputs):
        raise InputError(f"the last layer has {size} outputs, but {len(policy.outputs)} are named")
    if len({*policy.outputs}) != len(policy.outputs):
        raise InputError("outputs must have different names")
    inside = (policy.low <= policy.fallback) & (policy.fallback <= policy.high)
    if not inside.all():
        name = policy.outputs[int(np.argmin(inside))]
        raise InputError(f"output {name!r} must have low <= fallback <= high")
