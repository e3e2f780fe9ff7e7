"""Runs that record a value that is not finite are incomplete; the error names signal and time."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.command_line import CommandLine
from support.robots.robots import PLANAR_2R

from addin_sdfusion.robot import SimulationError
from addin_sdfusion.robot.json_text import json_text
from cardsflow_fmu.cosim import master as master_module
from cardsflow_fmu.cosim.coupling import Coupling
from cardsflow_fmu.cosim.master import Master
from cardsflow_fmu.cosim.signals.ports import SOLVE_TIME
from cardsflow_fmu.cosim.stepper import Stepper


class Source:
    """Unconnected participant whose output is not finite in one step, or from a step on."""

    def __init__(
        self, value: float, at: int, name: str = "external", output: str = "heat", last: int = 99
    ) -> None:
        self.name, self.input_names, self.output_names = name, (), ("good", output)
        self.inputs, self.outputs = np.empty(0), np.zeros(2)
        self.units: dict[str, Any] = {}
        self._value, self._at, self._last, self._done = value, at, last, 0
        self._give()

    def _give(self) -> None:
        self.outputs[1] = self._value if self._at <= self._done <= self._last else 1.0

    def step(self, t: float, h: float) -> None:
        self._done += 1
        self._give()

    def close(self) -> None:
        pass


def master(*parts: Source) -> Master:
    coupling = Coupling("jacobi")
    return Master(parts, {}, step=0.5, steps=10, coupling=coupling)


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("at", [0, 1, 3, 9, 10])
def test_unconnected_outputs_are_checked_in_all_rows(value: float, at: int) -> None:
    recording = master(Source(value, at, last=at)).run()
    assert str(recording.failure) == f"heat is not finite at t = {at / 2:g} s: {value}"
    assert len(recording.rows) == at + 1, "the row that shows it is the last"


def test_large_numbers_are_finite() -> None:
    assert master(Source(1e300, 2)).run().failure is None


def test_the_cause_of_a_failure_is_named_first() -> None:
    source = Source(math.nan, 3)

    def step(t: float, h: float) -> None:
        Source.step(source, t, h)
        if t >= 1.5:
            raise SimulationError("the plant failed")

    source.step = step  # type: ignore[method-assign]
    failure = master(source).run().failure
    assert str(failure) == "heat is not finite at t = 1.5 s: nan; the plant failed"


def test_the_solve_time_of_a_tick_must_be_finite() -> None:
    controller = Source(math.nan, 3, "controller", SOLVE_TIME)
    recording = master(controller).run()
    assert "solve_time is not finite at t = 1.5 s: nan" in str(recording.failure)


def no_constant(text: str) -> Any:
    raise AssertionError(f"{text} is not JSON")


@pytest.mark.parametrize("at", [0, 1, 20], ids=["start", "in the middle", "last row"])
def test_a_run_with_an_infinite_value_is_incomplete_and_writes_valid_json(
    tmp_path: Path, cardsflow: CommandLine, monkeypatch: pytest.MonkeyPatch, at: int
) -> None:
    """The loop in C records the value, so that the summary would contain NaN."""

    def spoil(stepper: Stepper, done: int) -> None:
        plant = next(t.participant for t in stepper._turns if t.participant.name == "plant")
        if done >= at:
            plant.outputs[plant.output_names.index("l.cable_1")] = math.nan

    run, record = Stepper.run, Stepper.record

    def spoilt_run(self: Stepper, first: int, *arguments: Any) -> None:
        spoil(self, first)
        run(self, first, *arguments)

    def spoilt_record(self: Stepper, t: float, row: Any) -> None:
        spoil(self, 20)
        record(self, t, row)

    monkeypatch.setattr(master_module, "_CHUNK", 1)
    monkeypatch.setattr(Stepper, "run", spoilt_run)
    monkeypatch.setattr(Stepper, "record", spoilt_record)
    words = ["--coupling", "direct", "-o", tmp_path, "--set", "run.duration=0.02", "--json"]
    code, out, err = cardsflow("run", PLANAR_2R, *words)
    assert code == 1
    assert f"l.cable_1 is not finite at t = {at * 1e-3:g} s: nan" in err
    assert json.loads(out, parse_constant=no_constant)["status"] == "incomplete"
    for file in tmp_path.glob("*.json"):
        json.loads(file.read_text(), parse_constant=no_constant)


def test_json_has_null_for_values_that_are_not_finite() -> None:
    value = {"a": [1.0, math.nan, (math.inf, {"b": -math.inf})], "c": "NaN"}
    assert json_text(value) == '{"a": [1.0, null, [null, {"b": null}]], "c": "NaN"}'
