"""Speed of FMUs in the host process and in a worker process, compared with Python and pythonfmu."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from support.fmu.fmu_host import pack
from support.fmu.pythonfmu_slave import SCRIPT
from support.interleaved import interleaved, record
from support.robots.robots import PLANAR_2R
from wide_model import FEW, MANY, PORTS, WideModel

from cardsflow_fmu import Experiment
from cardsflow_fmu.cosim.fmi_calls import Fmi3Calls
from cardsflow_fmu.cosim.fmu_instance import FmuInstance
from cardsflow_fmu.cosim.participant import Participant
from cardsflow_fmu.models.controller import ControllerModel
from cardsflow_fmu.models.direct_participant import DirectParticipant
from cardsflow_fmu.models.experiment_model import ExperimentModel
from cardsflow_fmu.models.plant import PlantModel
from cardsflow_fmu.simulation.build import build

IN_PROCESS_LIMIT, WORKER_LIMIT = (
    10e-6,
    50e-6,
)  # additional time relative to a step in Python, in [s]
ARRAY_LIMIT = 2.0
STEP = 1e-3
BLOCK_STEPS = 20  # about 0.2 ms, shorter than a time slice of a busy machine
MODELS: dict[str, type[ExperimentModel]] = {"plant": PlantModel, "controller": ControllerModel}


class Pair:
    """Plant and controller, stepped alternately, with a constant reference at the start pose."""

    def __init__(self, plant: Participant, controller: Participant) -> None:
        self._plant, self._controller = plant, controller
        self._to_controller = _route(plant, controller)
        self._to_plant = _route(controller, plant)
        for k, port in enumerate(controller.input_names):
            if port.startswith("q_d."):
                source = plant.output_names.index(port.replace("q_d.", "q."))
                controller.inputs[k] = plant.outputs[source]
        self._count = 0

    def block(self) -> None:
        """Execute a block of steps."""
        plant, controller = self._plant, self._controller
        for _ in range(BLOCK_STEPS):
            t = self._count * STEP
            self._to_controller()
            controller.step(t, STEP)
            self._to_plant()
            plant.step(t, STEP)
            self._count += 1

    @property
    def state(self) -> list[float]:
        """Return the outputs of the plant."""
        return list(self._plant.outputs)

    def close(self) -> None:
        """Close both participants."""
        self._plant.close()
        self._controller.close()


def _route(source: Participant, target: Participant) -> Callable[[], None]:
    """Return a function that copies outputs to the inputs of the same name."""
    names = [name for name in target.input_names if name in source.output_names]
    froms = np.array([source.output_names.index(name) for name in names])
    tos = np.array([target.input_names.index(name) for name in names])

    def copy() -> None:
        target.inputs[tos] = source.outputs[froms]

    return copy


def pythonfmu_pair(folder: Path) -> Pair:
    """Create the same models as FMUs of pythonfmu."""
    from pythonfmu.builder import FmuBuilder

    made = []
    for name, model in MODELS.items():
        script = folder / f"{name}_slave.py"
        text = SCRIPT.format(
            module=name,
            model=model.__name__,
            experiment=str(PLANAR_2R),
            name=f"{name.title()}Slave",
        )
        script.write_text(text)
        archive = FmuBuilder.build_FMU(script, dest=folder)
        made.append(FmuInstance(name, Path(archive), folder / f"pythonfmu_{name}"))
    return Pair(*made)


def test_step_of_the_two_link_pair(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Compare a step of plant and controller in the same loop."""
    experiment = Experiment.load(PLANAR_2R)
    files = build(experiment, tmp_path, compute="python")
    pairs = {"plain": Pair(*(DirectParticipant(n, m(experiment)) for n, m in MODELS.items()))}
    for mode in ("in-process", "worker"):
        monkeypatch.setenv("CARDSFLOW_FMU_HOST", mode)
        pairs[mode] = Pair(*(FmuInstance(n, files[n], tmp_path / mode / n) for n in MODELS))
    if importlib.util.find_spec("pythonfmu"):
        pairs["pythonfmu"] = pythonfmu_pair(tmp_path)
    blocks = {name: pair.block for name, pair in pairs.items()}
    times = interleaved(blocks, calls=1, rounds=400)
    assert pairs["worker"].state == pairs["in-process"].state == pairs["plain"].state
    for pair in pairs.values():
        pair.close()
    ratios = {name: seconds / times["plain"] for name, seconds in times.items()}
    record(
        "a step of the two-link pair, against plain Python",
        plain_us=times["plain"] / BLOCK_STEPS * 1e6,
        **{f"{name}_ratio": ratio for name, ratio in ratios.items() if name != "plain"},
    )
    beside = {mode: (times[mode] - times["plain"]) / BLOCK_STEPS for mode in times}
    assert beside["in-process"] <= IN_PROCESS_LIMIT
    assert beside["worker"] <= WORKER_LIMIT
    assert ratios["in-process"] < ratios.get("pythonfmu", float("inf"))


@pytest.mark.parametrize("mode", ["in-process", "worker"])
def test_access_to_arrays(mode: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Compare access to arrays of 60 values with arrays of 4 values, in FMI 3.0."""
    monkeypatch.setenv("CARDSFLOW_FMU_HOST", mode)
    archive = pack(tmp_path / "wide.fmu", WideModel, PORTS, fmi="3.0")
    instance = FmuInstance("wide", archive, tmp_path / "wide")
    calls = instance._calls
    assert isinstance(calls, Fmi3Calls)
    alternatives = {}
    for name, first, count in (("few", 0, FEW), ("many", FEW, MANY)):
        alternatives[name] = set_and_get(calls, first, FEW + MANY + first, count)
    times = interleaved(alternatives, calls=2000)
    instance.close()
    ratio = times["many"] / times["few"]
    record(f"set and get of 60 values against 4, {mode}", ratio=ratio, us=times["many"] * 1e6)
    assert ratio <= ARRAY_LIMIT


def set_and_get(calls: Fmi3Calls, given: int, taken: int, count: int) -> Callable[[], None]:
    """Return calls of the library with existing buffers."""
    import ctypes

    size, one = ctypes.c_size_t(count), ctypes.c_size_t(1)
    buffer = (ctypes.c_double * count)(*range(count))
    to, of = (ctypes.c_uint32 * 1)(given), (ctypes.c_uint32 * 1)(taken)
    put, get = (calls._library[f"fmi3{verb}Float64"] for verb in ("Set", "Get"))
    instance = calls._instance

    def call() -> None:
        assert put(instance, to, one, buffer, size) == 0
        assert get(instance, of, one, buffer, size) == 0

    return call
