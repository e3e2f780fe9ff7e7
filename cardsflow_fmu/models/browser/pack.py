"""Packed files of a simulation in a browser: module, models, loops of all modes.

The data are: length of the header as uint32, header as JSON, padding to 8 bytes, then arrays and
files. In the header, `[offset, size]` is a part of these bytes.
"""

from __future__ import annotations

import base64
import struct
import zlib
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from addin_sdfusion.robot import InputError, Robot
from addin_sdfusion.robot.json_text import json_text
from addin_sdfusion.robot.model.muscle_laws import command_range, law_of
from cardsflow_fmu.cosim.participant import WiredPorts
from cardsflow_fmu.cosim.signals.muscles import commanded_muscles
from cardsflow_fmu.cosim.signals.reaction import DECISIONS, FAULTS, PARTS
from cardsflow_fmu.cosim.signals.variables import scalar_variables
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.models.by_role import C_MODELS
from cardsflow_fmu.models.c_model import CModel
from cardsflow_fmu.models.native.fields import field_places
from cardsflow_fmu.models.native.loop_tables import loop_tables
from cardsflow_fmu.models.native_loop import missing_in_loop
from cardsflow_fmu.runtime.port_table import encode_port_table
from cardsflow_fmu.runtime.wasm import wasm_module
from cardsflow_fmu.version import __version__

from .drawing import drawing_tables, link_moments
from .modes import (
    MODES,
    Mode,
    experiment_in_mode,
    models_in_mode,
    stepping_in_mode,
    wiring_in_mode,
    with_wrenches,
)

_FIELDS = (
    *("gravity", "mass", "mass_centre", "inertia", "muscle_bends", "bend_friction", "noise"),
    *("tension_scale", "break_time", "stuck"),
)
"""Fields of files that a page changes while it simulates."""


def engine_text(experiment: Experiment, modes: Sequence[Mode] = MODES) -> str:
    """Return what a page needs to simulate an experiment, as base64 of compressed bytes.

    Args:
        modes: The drive modes of the page; impossible ones are omitted.

    Raises:
        InputError: The experiment requires Python, DART or hardware, or the module is missing.
    """
    return base64.b64encode(zlib.compress(engine_data(experiment, modes), 9)).decode()


def engine_data(experiment: Experiment, modes: Sequence[Mode] = MODES) -> bytes:
    """Return the same as `engine_text`, not compressed."""
    _require_support(experiment, ("plant",))
    experiment = with_wrenches(experiment)
    packer = _Packer(experiment)
    module = packer.add(wasm_module())
    loops, missing = {}, {}
    for mode in modes:
        try:
            loops[mode] = packer.add_loop(mode)
        except InputError as error:
            missing[mode] = error.problem
    robot, run = experiment.robot, experiment.run
    header = {
        "version": __version__,
        "module": module,
        "step": run.step,
        "controllerSteps": packer.every["controller"],
        "models": packer.models,
        "loops": loops,
        "missing": missing,
        "gains": [{"name": name, "value": value} for name, value in packer.gains.items()],
        "hasSensors": experiment.estimator is not None,
        "reports": {"parts": PARTS, "kinds": FAULTS, "decisions": DECISIONS},
        "space": experiment.controller.space,
        **_robot(robot),
        "inertias": packer.add_array(link_moments(experiment.robot)),
        "drawing": drawing_tables(robot, experiment.plant.wrenches, packer.add_array),
    }
    text = json_text(header, separators=(",", ":")).encode()
    start = struct.pack("<I", len(text)) + text
    return start + bytes(-len(start) % 8) + packer.contents


def _require_support(experiment: Experiment, names: Sequence[str]) -> None:
    feature = missing_in_loop(experiment, names)
    if feature is not None:
        problem = f"a page cannot simulate {feature}; use `cardsflow run --view`"
        raise InputError(problem, file=experiment.file)


class _Packer:
    """Models and loops of an experiment, without repetitions.

    Attributes:
        models: Header entries of the models.
        contents: Bytes of files and arrays.
        gains: Gains of all controllers, by the name of their parameter.
    """

    def __init__(self, experiment: Experiment) -> None:
        self._experiment = experiment
        self._numbers: dict[bytes, int] = {}
        self.models: list[dict[str, Any]] = []
        self.contents = b""
        self.gains: dict[str, float] = {}
        every = round(experiment.controller.period / experiment.run.step)
        self.every = dict.fromkeys(experiment.columns, 1) | {"controller": every}

    def add(self, contents: bytes) -> list[int]:
        """Add bytes and return their place; they begin at a multiple of 8."""
        place = [len(self.contents), len(contents)]
        self.contents += contents + bytes(-len(contents) % 8)
        return place

    def add_array(self, values: NDArray[Any]) -> list[int]:
        """Add an array of float64 or int32."""
        return self.add(np.ascontiguousarray(values).tobytes())

    def add_loop(self, mode: Mode) -> dict[str, Any]:
        """Add the models of a mode that are not there yet; return the tables of its loop."""
        experiment = experiment_in_mode(self._experiment, mode)
        names = models_in_mode(experiment, mode)
        _require_support(experiment, names)
        sources = names if mode == "pose" else experiment.columns
        models = {name: C_MODELS[name](experiment) for name in sources}
        parts = {
            name: WiredPorts(name, model.ports, model.inputs, model.outputs)
            for name, model in models.items()
        }
        wiring = wiring_in_mode(experiment, list(parts.values()), names)
        numbers = [self._add_model(name, experiment, models[name]) for name in names]
        stepping = stepping_in_mode(experiment, names)
        tables = loop_tables([parts[name] for name in names], wiring, stepping, self.every)
        return {
            "models": numbers,
            "values": [self.add_array(models[name].values) for name in names],
            "sizes": [len(tables.turns), len(tables.copies)],
            **{key: self.add_array(getattr(tables, key)) for key in ("turns", "copies", "changes")},
        }

    def _add_model(self, name: str, experiment: Experiment, model: CModel) -> int:
        """Add a model and return its number."""
        file = model.file(experiment)
        key = name.encode() + file
        if key not in self._numbers:
            table = encode_port_table(
                scalar_variables(model.ports),
                guid="",
                model_name="",
                package=__version__,
                step=experiment.run.step,
            )
            groups = model.groups(experiment)
            self._numbers[key] = len(self.models)
            for gain in (*groups.get("kp", ()), *groups.get("kd", ())):
                self.gains[gain.name] = gain.start
            places = field_places(name, file)
            places_of = {
                group: [place.start, place.stop - place.start]
                for group, place in model.places.items()
            }
            self.models.append(
                {
                    "role": name,
                    "file": self.add(file),
                    "ports": self.add(table),
                    "names": [port.name for port in model.ports],
                    "units": [port.unit or "" for port in model.ports],
                    "outputs": [model.inputs.size, model.outputs.size],
                    "groups": places_of,
                    "fields": {field: places[field] for field in _FIELDS if field in places},
                }
            )
        return self._numbers[key]


def _robot(robot: Robot) -> dict[str, Any]:
    """Return names, units and ranges for controls."""
    ranges = [command_range(muscle.model) for muscle in robot.muscles]
    return {
        "gravity": list(robot.gravity),
        "mass": sum(link.inertia.mass for link in robot.links),
        "motors": [
            {
                "name": c.name,
                "unit": "N·m" if c.unit == "rad" else "N",
                "low": c.tau_min,
                "high": c.tau_max,
            }
            for c in robot.motors
        ],
        "hasFriction": any(muscle.friction for muscle in robot.muscles),
        "muscles": [
            {
                "name": muscle.name,
                "law": law_of(muscle.model).kind,
                "unit": command.unit if (command := law_of(muscle.model).command) else "",
                "f_min": muscle.f_min,
                "f_max": muscle.f_max,
                "low": max(low, muscle.f_min) if law_of(muscle.model).kind == "ideal" else low,
                "high": min(high, muscle.f_max) if law_of(muscle.model).kind == "ideal" else high,
            }
            for muscle, (low, high) in zip(robot.muscles, ranges, strict=True)
        ],
        "commanded": commanded_muscles(robot),
        "coordinates": [
            {"name": c.name, "unit": c.unit, "lower": c.lower, "upper": c.upper}
            for c in robot.coordinates
        ],
        "tasks": [
            {"name": f"{frame.name}.{axis}", "unit": "rad" if frame.is_orientation else "m"}
            for frame in robot.task_frames
            for axis in frame.axes
        ],
    }
