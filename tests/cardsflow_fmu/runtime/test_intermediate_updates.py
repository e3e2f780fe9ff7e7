"""Intermediate updates of FMI 3.0: one for each internal step, with early return."""

from __future__ import annotations

import ctypes
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import fmpy
import pytest
from fmpy import fmi3
from support.fmu.fmu_host import load
from support.robots.robots import PLANAR_2R

from cardsflow_fmu import Experiment
from cardsflow_fmu.simulation.build import build_fmus

pytestmark = pytest.mark.native

STEP = 1e-3
LONG = 5 * STEP


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An unpacked plant with internal steps of 1 ms."""
    folder = tmp_path_factory.mktemp("updates")
    file = build_fmus(Experiment.load(PLANAR_2R), folder, ["plant"], "3.0", sources=False)["plant"]
    fmpy.extract(str(file), str(folder / "plant"))
    return folder / "plant"


class Plant:
    """Instance that records its intermediate updates and may request an early return.

    Attributes:
        updates: Time, position of joint 1, and whether an early return is possible.
        return_at: Time of the early return to request, or None.
    """

    def __init__(self, folder: Path, *, early: bool) -> None:
        self.host = load(folder)
        self.slave: Any = self.host.slave
        self.updates: list[tuple[float, float, bool]] = []
        self.return_at: float | None = None
        self.q = self.host.references["q"]
        options = {"logMessage": self.host.log, "earlyReturnAllowed": early}
        self.slave.instantiate(intermediateUpdate=self.update, **options)
        self.host.start()

    def update(self, _: object, time: float, *rest: Any) -> None:
        can_return, requested, return_time = rest[3:]
        self.updates.append((time, self.position, bool(can_return)))
        if self.return_at is not None:
            ctypes.cast(requested, ctypes.POINTER(fmi3.fmi3Boolean))[0] = True
            ctypes.cast(return_time, ctypes.POINTER(ctypes.c_double))[0] = self.return_at

    @property
    def position(self) -> float:
        return float(self.slave.getFloat64([self.q], 2)[0])


@contextmanager
def plant(folder: Path, *, early: bool = True) -> Iterator[Plant]:
    made = Plant(folder, early=early)
    yield made
    made.slave.freeInstance()


def test_every_internal_step_has_an_update(folder: Path) -> None:
    """The states are those of short steps, and a long step without updates ends at the same."""
    with plant(folder) as one, plant(folder) as two:
        assert one.slave.doStep(0.0, LONG) == (False, False, False, LONG)
        positions = []
        for k in range(5):
            two.slave.doStep(k * STEP, STEP)
            positions.append(two.position)
        assert [time for time, *_ in one.updates] == pytest.approx([STEP * k for k in range(1, 6)])
        assert [q for _, q, _ in one.updates] == positions
        assert [early for *_, early in one.updates] == [True, True, True, True, False]
    slave = load(folder)
    slave.slave.instantiate()
    slave.start()
    slave.slave.doStep(0.0, LONG)
    assert slave.slave.getFloat64([one.q], 2)[0] == positions[-1]
    slave.slave.freeInstance()


@pytest.mark.parametrize("asked", [0.0, 1.4 * STEP, 2 * STEP, 2.9 * STEP, LONG])
def test_the_step_ends_at_or_before_the_requested_time(folder: Path, asked: float) -> None:
    """It ends at least one internal step after its beginning, and the next step begins there."""
    reached = {0.0: STEP, 1.4 * STEP: STEP, LONG: LONG}.get(asked, 2 * STEP)
    with plant(folder) as one:
        one.return_at = asked
        done = one.slave.doStep(0.0, LONG)
        assert done == (False, False, reached < LONG, pytest.approx(reached))
        one.return_at = None
        if reached < LONG:
            one.slave.doStep(done[3], LONG - done[3])
        with plant(folder) as two:
            two.slave.doStep(0.0, LONG)
            assert one.position == two.position


def test_no_early_return_unless_it_is_allowed(folder: Path) -> None:
    with plant(folder, early=False) as one:
        one.return_at = 0.0
        assert one.slave.doStep(0.0, LONG) == (False, False, False, LONG)
        assert len(one.updates) == 5
        assert not any(early for *_, early in one.updates)


def test_only_models_with_internal_steps_declare_early_return(folder: Path, tmp_path: Path) -> None:
    names = ["plant", "controller"]
    python = build_fmus(Experiment.load(PLANAR_2R), tmp_path, names, "3.0", native=False)
    found = [
        'canReturnEarlyAfterIntermediateUpdate="true"'
        in (path / "modelDescription.xml").read_text("utf-8")
        for path in (folder, *(Path(fmpy.extract(str(file))) for file in python.values()))
    ]
    assert found == [True, False, False]
