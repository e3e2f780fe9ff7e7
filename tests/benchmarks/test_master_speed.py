"""The master in C, compared with a loop in Python over the same FMUs with FMPy's calls.

Both loops execute the same steps, which the benchmark checks first. Factors are in processor time
of this process, the best of several runs: `test_master_speed.py -s`.
"""

from __future__ import annotations

import shutil
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.fmu.external_fmus import MAPS, external_fmu
from support.interleaved import record
from support.robots.robots import EXAMPLES

from cardsflow_fmu import Experiment
from cardsflow_fmu.cosim.external_fmu import AdaptedFmu, without_missing_loads
from cardsflow_fmu.cosim.fmu_instance import FmuInstance
from cardsflow_fmu.cosim.master import Master
from cardsflow_fmu.cosim.participant import Copy, Form, Participant
from cardsflow_fmu.cosim.signals.ports import external_load_signals
from cardsflow_fmu.cosim.wiring import connect
from cardsflow_fmu.models.plant import PlantModel
from cardsflow_fmu.results.journal import Journal
from cardsflow_fmu.simulation.build import build_fmus
from cardsflow_fmu.simulation.run import run

STEPS = 2000
COMPILER = shutil.which("cc") or "cc"
RATIO_LIMIT = 3.0  # time of the loop in Python / time of the master
RUN_LIMITS = {"planar_2r": 150.0, "roboy_left_arm": 100.0}  # times real time, with the journal


class PythonLoop:
    """Sampled loop over FMUs with FMPy's functions, which create arrays in every call."""

    def __init__(self, parts: Sequence[Participant], wiring: Any, every: int) -> None:
        copies = connect(parts, wiring)
        self._order = [next(p for p in parts if p.name == "controller")]
        self._order += [p for p in parts if p not in self._order]
        self._plan = {p.name: (copies[p.name], fmpy_step(p)) for p in parts}
        self._parts, self._every = parts, every

    def run(self, step: float) -> np.ndarray:
        rows = []
        first, *others = self._order
        for k in range(STEPS):
            if k % self._every == 0:
                self._step([first], k * step, self._every * step)
            rows.append(np.concatenate([p.outputs for p in self._parts]))
            self._step(others, k * step, step)
        return np.array(rows)

    def _step(self, parts: Sequence[Participant], t: float, h: float) -> None:
        for part in parts:
            run_copies(self._plan[part.name][0])
        for part in parts:
            run_copies(getattr(part, "incoming", ()))
            self._plan[part.name][1](t, h)
            run_copies(getattr(part, "outgoing", ()))


def run_copies(copies: Sequence[Copy]) -> None:
    for source, j, target, k, form, change in copies:
        value = source[j]
        if form == Form.SCALED:
            value = change.factor * value + change.offset
        elif form == Form.UNSCALED:
            value = (value - change.offset) / change.factor
        target[k] = value


def fmpy_step(part: Any) -> Callable[[float, float], None]:
    """Return a step of an FMU with FMPy's functions."""
    fmu: FmuInstance = getattr(part, "_inner", part)
    slave: Any = fmu._calls._slave  # type: ignore[union-attr]
    inputs, outputs = fmu._input_row, fmu._output_row
    calls = [
        (
            list(bank.references),
            getattr(slave, f"{verb}{bank.function}"),
            row.values[bank.place],
            bank.function == "Boolean",
        )
        for verb, row in (("set", inputs), ("get", outputs))
        for bank in row.banks
    ]
    sets, gets = calls[: len(inputs.banks)], calls[len(inputs.banks) :]

    def step(t: float, h: float) -> None:
        for references, function, values, is_boolean in sets:
            function(references, [bool(v) for v in values] if is_boolean else values.tolist())
        slave.doStep(t, h)
        for references, function, values, _ in gets:
            values[:] = function(references, *([len(values)] if slave_is_3 else []))

    slave_is_3 = hasattr(slave, "getFloat64")
    return step


def experiment_of(example: str, fmi: str | None, folder: Path) -> Experiment:
    """Return an example, with an external plant of a version of FMI if one is given."""
    settings: dict[str, Any] = {"run.duration": STEPS * 1e-3}
    if fmi is not None:
        file = external_fmu(folder / "body.fmu", COMPILER, fmi)
        settings |= {"fmus.plant": {"path": str(file), **MAPS[fmi]}, "wiring.plant.brake": 0.0}
    return Experiment.load(EXAMPLES / example, settings)


def participants(experiment: Experiment, files: dict[str, Path], folder: Path) -> list[Any]:
    parts: list[Any] = []
    for name in experiment.columns:
        external = experiment.fmus.get(name)
        file = files[name] if external is None else external.file
        fmu = FmuInstance(name, file, folder / name)
        adapted = external and AdaptedFmu(fmu, external, PlantModel.table(experiment))
        parts.append(adapted or fmu)
    return parts


@pytest.mark.parametrize(
    ("example", "fmi"),
    [("planar_2r", None), ("roboy_left_arm", None), ("planar_2r", "2.0"), ("planar_2r", "3.0")],
    ids=["planar arm", "Roboy's arm", "external FMI 2", "external FMI 3"],
)
def test_master_against_a_loop_in_python(example: str, fmi: str | None, tmp_path: Path) -> None:
    experiment = experiment_of(example, fmi, tmp_path)
    files = build_fmus(experiment, tmp_path, experiment.columns)
    loads = external_load_signals(experiment.robot, experiment.plant.wrenches)
    settings, best = experiment.run, {"C": np.inf, "Python": np.inf}
    every = round(experiment.controller.period / settings.step)
    for k in range(5):
        rows = {}
        for name in best:
            folder = tmp_path / f"{name}_{k}"
            parts = participants(experiment, files, folder)
            wiring = without_missing_loads(experiment.wiring, experiment.fmus, parts, loads)
            if name == "C":
                master = Master(
                    parts,
                    wiring,
                    step=settings.step,
                    steps=STEPS,
                    coupling=settings.stepping,
                    every={"controller": every},
                )
                begin = time.process_time()
                rows[name] = master.run().columns
            else:
                loop = PythonLoop(parts, wiring, every)
                begin = time.process_time()
                rows[name] = loop.run(settings.step)
            best[name] = min(best[name], time.process_time() - begin)
            for part in parts:
                part.close()
    states = [names.index(n) for names in [all_outputs(parts)] for n in names if n[:2] == "q."]
    recorded = np.column_stack([rows["C"][all_outputs(parts)[j]][:STEPS] for j in states])
    np.testing.assert_array_equal(recorded, rows["Python"][:, states])
    factors = {name: STEPS * settings.step / seconds for name, seconds in best.items()}
    ratio = factors["C"] / factors["Python"]
    record(f"master, {example}, FMI {fmi or 'of this package'}", ratio=ratio, **factors)
    assert ratio >= RATIO_LIMIT


def all_outputs(parts: Sequence[Participant]) -> list[str]:
    return [name for part in parts for name in part.output_names]


@pytest.mark.parametrize("example", RUN_LIMITS)
def test_loop_of_cardsflow_run(
    example: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The loop of a default run, including the table on disk."""
    spent: list[float] = []
    original = Master.run

    def timed(self: Master, *arguments: Any) -> Any:
        assert isinstance(arguments[3], Journal)
        begin = time.process_time()
        recording = original(self, *arguments)
        spent.append((time.process_time() - begin) / recording.rows[-1, 0])
        return recording

    monkeypatch.setattr(Master, "run", timed)
    for _ in range(3):
        run(Experiment.load(EXAMPLES / example), tmp_path)
    factor = 1.0 / min(spent)
    record(f"loop of `cardsflow run`, {example}", factor=factor)
    assert factor >= RUN_LIMITS[example]
