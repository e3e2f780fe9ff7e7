"""Policies: multilayer perceptrons that compute the commands of a controller, as JSON files."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Annotated, Any, Literal, Self, get_args

import numpy as np
from pydantic import ConfigDict, PlainSerializer, PlainValidator, model_validator

from addin_sdfusion.robot import InputError, Robot, UnknownNameError
from addin_sdfusion.robot.files import write_files
from addin_sdfusion.robot.json_text import json_text
from addin_sdfusion.robot.model.muscle_laws import states_of
from addin_sdfusion.robot.model.trajectory import Space
from cardsflow_fmu.cosim.signals.muscles import driven_muscles, ideal_muscles, state_order
from cardsflow_fmu.utils.arrays import FloatArray

from .config.file import read_settings
from .config.messages import SettingError
from .config.table import Context, Listed, Positive, Table, setting

Format = Literal["cardsflow-policy-1"]
(FORMAT,) = get_args(Format)

Part = Literal["q", "qd", "y", "error", "rate", "activations"]
"""Part of observations, in the order of `enum policy_part`."""

Activation = Literal["linear", "tanh", "relu", "elu", "sigmoid"]
"""Function of a layer, in the order of `enum policy_activation`."""


def _array(dimensions: int, values: Any) -> FloatArray:
    try:
        array = np.array(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise SettingError("must be numbers in rows of equal length") from None
    if array.ndim != dimensions or not array.size or not np.isfinite(array).all():
        raise SettingError(f"must be finite numbers with {dimensions} dimensions")
    return array


_AS_LISTS = PlainSerializer(lambda array: array.tolist())
Vector = Annotated[FloatArray, PlainValidator(partial(_array, 1)), _AS_LISTS]
Matrix = Annotated[FloatArray, PlainValidator(partial(_array, 2)), _AS_LISTS]


class _PolicyTable(Table):
    """Table of a policy; other keys are ignored."""

    model_config = ConfigDict(extra="ignore")


class Layer(_PolicyTable):
    """Layer: activation(weights x + bias)."""

    activation: Activation = setting("function of the layer")
    weights: Matrix = setting("weights, shape (outputs, inputs)")
    bias: Vector = setting("bias, shape (outputs,)")


class Output(_PolicyTable):
    """Command of a muscle, or of the motor of a coordinate."""

    name: str = setting("name of the muscle or coordinate")
    low: float = setting("smallest command")
    high: float = setting("largest command")
    fallback: float = setting("command if an input is not sound")


class Policy(_PolicyTable):
    """Policy from observations to commands."""

    format: Format = setting("version of the file format", FORMAT)
    step: Positive = setting(
        "time between two ticks, in s; velocities in the observation are multiplied by it"
    )
    inputs: Annotated[tuple[Part, ...], Listed] = setting("parts of the observation", kind="input")
    mean: Vector = setting("means of the observation, shape (k,)")
    sd: Vector = setting("standard deviations of the observation, shape (k,)")
    max_input: Positive = setting(
        "largest sound normalised input; beyond it, the outputs are the fallback", 100.0
    )
    layers: Annotated[tuple[Layer, ...], Listed] = setting(
        "layers; the last one computes actions from -1 to 1"
    )
    map: Literal["range", "sigmoid"] = setting(
        "map from actions to commands, see `cardsflow_fmu.gym.actions.Actions`"
    )
    outputs: Annotated[tuple[Output, ...], Listed] = setting("muscles and motors")

    @model_validator(mode="after")
    def _check_sizes(self) -> Self:
        if self.sd.shape != self.mean.shape or not (self.sd > 0).all():
            raise SettingError("sd must be positive and have the size of mean")
        size = self.mean.size
        for k, layer in enumerate(self.layers):
            rows, columns = layer.weights.shape
            if columns != size or layer.bias.shape != (rows,):
                raise SettingError(
                    f"layer {k}: weights have shape {layer.weights.shape} and bias "
                    f"{layer.bias.shape}, but the layer has {size} inputs"
                )
            size = rows
        if not self.layers or size != len(self.outputs):
            problem = f"the last layer has {size} outputs, but {len(self.outputs)} are named"
            raise SettingError(problem)
        if len({output.name for output in self.outputs}) != len(self.outputs):
            raise SettingError("outputs must have different names")
        for output in self.outputs:
            if not output.low <= output.fallback <= output.high:
                raise SettingError(f"output {output.name!r} must have low <= fallback <= high")
        return self

    def numbers(self, robot: Robot, space: Space) -> FloatArray:
        """Return the numbers of the policy for the C library; see `policy_open` in policy.h.

        Raises:
            InputError: The policy does not fit the robot.
        """
        columns = activation_inputs(robot)
        self._require_inputs(robot, space, len(columns))
        sizes = [
            self.mean.size,
            len(self.outputs),
            len(self.layers),
            len(self.inputs),
            len(columns),
        ]
        settings = [self.step, self.max_input, float(self.map == "sigmoid")]
        targets = [number for output in self.outputs for number in _target(robot, output.name)]
        network = [
            number
            for layer in self.layers
            for number in (
                *layer.weights.shape,
                get_args(Activation).index(layer.activation),
                *layer.weights.reshape(-1),
                *layer.bias,
            )
        ]
        parts = [get_args(Part).index(part) for part in self.inputs]
        normal = [*self.mean, *(1.0 / self.sd)]
        ends = [getattr(o, key) for key in ("low", "high", "fallback") for o in self.outputs]
        return np.array([*sizes, *settings, *parts, *columns, *targets, *normal, *network, *ends])

    def _require_inputs(self, robot: Robot, space: Space, activations: int) -> None:
        n, k = len(robot.coordinates), sum(len(f.axes) for f in robot.task_frames)
        followed = n if space == "joint" else k
        sizes = {"q": n, "qd": n, "error": followed, "rate": followed, "activations": activations}
        if space == "operational":
            sizes["y"] = k
        for part in self.inputs:
            if part not in sizes:
                raise InputError(f"input {part!r} needs a reference in operational space")
        expected = sum(sizes[part] for part in self.inputs)
        if expected != self.mean.size:
            raise InputError(
                f"has {self.mean.size} inputs, but {', '.join(self.inputs)} of this robot with a "
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
    text = json_text(policy.model_dump(), indent=1) + "\n"
    return write_files(file.parent, {file.name: text})[0]


def read_policy(file: Path) -> Policy:
    """Read a policy from JSON.

    Raises:
        InputError: The file cannot be read, or is not a valid policy.
    """
    data = read_settings(file)
    if data.get("format") != FORMAT:
        raise InputError(f"is not a policy: its format must be {FORMAT!r}", file=file)
    return Policy.read(data, Context(file))
