from __future__ import annotations

import os
import signal
import tracemalloc
from collections.abc import Callable

import numpy as np
import pytest

from addin_sdfusion.robot import InputError, SimulationError, UnknownNameError
from cardsflow_fmu.cosim.master import Master
from cardsflow_fmu.cosim.pacing import Pacer
from cardsflow_fmu.cosim.recording import NumberLog, Recording

pytestmark = pytest.mark.native


class Stub:
    """Participant whose step is a function of its inputs, and which logs its calls."""

    def __init__(self, name, inputs, outputs, law, diary):
        self.name, self.input_names, self.output_names = name, tuple(inputs), tuple(outputs)
        self.inputs, self.outputs = np.zeros(len(inputs)), np.zeros(len(outputs))
        self.law, self.diary, self.units = law, diary, {}

    def step(self, t, h):
        self.diary.append((self.name, round(t, 9), round(h, 9), *self.inputs))
        self.outputs[:] = self.law(t, h, self.inputs, self.outputs)

    def close(self):
        pass


def system(diary, **changes):
    """Return an integrator x' = f with the control law f = r - x; the reference r is the time."""
    plant = Stub("plant", ["f"], ["x"], lambda t, h, u, y: y + h * u, diary)
    controller = Stub(
        "controller", ["r", "x"], ["f", "infeasible"], lambda t, h, u, y: [u[0] - u[1], 0], diary
    )
    reference = Stub("reference", [], ["r"], lambda t, h, u, y: t + h, diary)
    parts = {"plant": plant, "reference": reference, "controller": controller}
    return list((parts | changes).values())


def test_the_controller_uses_current_outputs_and_its_force_acts_in_this_step() -> None:
    diary: list = []
    recording = Master(system(diary), wiring={}, step=0.5, steps=3).run()
    assert diary[:6] == [
        ("controller", 0.0, 0.5, 0.0, 0.0),
        ("plant", 0.0, 0.5, 0.0),
        ("reference", 0.0, 0.5),
        ("controller", 0.5, 0.5, 0.5, 0.0),
        ("plant", 0.5, 0.5, 0.5),
        ("reference", 0.5, 0.5),
    ]
    assert recording.names == ("time", "x", "r", "f", "infeasible")
    x = [0.0, 0.0, 0.25, 0.25 + 0.5 * 0.75]
    np.testing.assert_allclose(recording.rows[:, 1], x)
    np.testing.assert_allclose(recording.rows[:, 0], [0.0, 0.5, 1.0, 1.5])
    np.testing.assert_allclose(recording.rows[:, 3], [0.0, 0.5, 0.75, 0.75])
    assert recording.ticks.tolist() == [0, 1, 2]
    assert recording.failure is None


def test_a_slower_controller_holds_its_forces() -> None:
    diary: list = []
    recording = Master(system(diary), wiring={}, step=0.1, steps=6, every={"controller": 3}).run()
    assert [entry[:3] for entry in diary if entry[0] == "controller"] == [
        ("controller", 0.0, 0.3),
        ("controller", 0.3, 0.3),
    ]
    assert recording.ticks.tolist() == [0, 3]
    assert np.ptp(recording.rows[0:3, 3]) == 0.0
    assert np.ptp(recording.rows[3:6, 3]) == 0.0


def test_explicit_wiring_replaces_wiring_by_name() -> None:
    diary: list = []
    parts = system(diary)
    parts[0].output_names = ("position",)
    with pytest.raises(InputError, match=r"one source: controller\.x \(no output"):
        Master(parts, wiring={}, step=0.1, steps=1)
    wired = Master(parts, wiring={"controller.x": "plant.position"}, step=0.1, steps=3).run()
    plain = Master(system([]), wiring={}, step=0.1, steps=3).run()
    np.testing.assert_array_equal(wired.rows, plain.rows)


@pytest.mark.parametrize(
    ("wiring", "message"),
    [
        ({"controller.y": "plant.x"}, r"no input 'controller\.y'; did you mean 'controller\.x'"),
        ({"controller.x": "plant.z"}, r"wiring\.controller\.x: no output 'plant\.z'"),
    ],
)
def test_unknown_ports_in_the_wiring_are_an_error(wiring: dict[str, str], message: str) -> None:
    with pytest.raises(UnknownNameError, match=message):
        Master(system([]), wiring=wiring, step=0.1, steps=1)


def with_plant(law: Callable[..., float]) -> Recording:
    """Run a plant with a control law for 100 steps."""
    plant = Stub("plant", ["f"], ["x"], law, [])
    return Master(system([], plant=plant), wiring={}, step=0.1, steps=100).run()


def test_a_failure_keeps_the_recorded_rows() -> None:
    def fail_late(t, h, u, y):
        if t > 0.25:
            raise SimulationError("spring broke")
        return y + h * u

    recording = with_plant(fail_late)
    assert str(recording.failure) == "spring broke"
    np.testing.assert_allclose(recording.rows[:, 0], [0.0, 0.1, 0.2, 0.3])


def ctrl_c_late(t, h, u, y):
    if 0.25 < t < 0.35:
        os.kill(os.getpid(), signal.SIGINT)
    return y + h * u


def ctrl_c_twice_in_an_endless_step(t, h, u, y):
    if t > 0.25:
        for _ in range(2):
            os.kill(os.getpid(), signal.SIGINT)
        while True:
            pass
    return y + h * u


def sigterm_at_once(t, h, u, y):
    os.kill(os.getpid(), signal.SIGTERM)
    return y + h * u


@pytest.mark.parametrize(
    ("law", "rows"), [(ctrl_c_late, 4), (ctrl_c_twice_in_an_endless_step, 4), (sigterm_at_once, 1)]
)
def test_an_interrupted_run_keeps_the_recorded_rows(law: Callable[..., float], rows: int) -> None:
    """The first signal interrupts between two steps, the second one within a step."""
    before = signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM)
    recording = with_plant(law)
    assert str(recording.failure) == "interrupted"
    assert len(recording.rows) == rows
    assert (signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM)) == before


def test_ctrl_c_ends_the_wait_for_a_long_step() -> None:
    """In real time, a wait checks for Ctrl-C every 0.1 s."""
    slept: list[float] = []

    def sleep(seconds: float) -> None:
        slept.append(seconds)
        if len(slept) == 3:
            os.kill(os.getpid(), signal.SIGINT)

    pacer = Pacer(30.0, clock=lambda: sum(slept), sleep=sleep)
    recording = Master(system([]), wiring={}, step=30.0, steps=3).run(pacer=pacer)
    assert str(recording.failure) == "interrupted"
    assert (len(recording.rows), len(recording.lateness)) == (1, 1)
    assert slept == [0.1, 0.1, 0.1]


def test_progress_ends_with_all_steps() -> None:
    seen: list[int] = []
    Master(system([]), wiring={}, step=0.1, steps=300).run(seen.append)
    assert seen[-1] == 300
    assert seen == sorted(seen)


def test_log_of_numbers_keeps_them_in_a_file() -> None:
    """Memory of a run is bounded: full blocks are not in memory."""
    log, count = NumberLog(), 200_000
    tracemalloc.start()
    try:
        for k in range(count):
            log.append(0.5 * k)
        assert tracemalloc.get_traced_memory()[0] < 8 * count / 2
    finally:
        tracemalloc.stop()
    np.testing.assert_array_equal(log.numbers(), 0.5 * np.arange(count))
    log.append(7.0)
    assert log.numbers()[-1] == 7.0
    assert NumberLog().numbers().shape == (0,)


def test_all_inputs_without_a_source_are_reported_at_once() -> None:
    parts = system([])
    parts[0].output_names, parts[1].output_names = ("position",), ("pull",)
    message = (
        r"controller\.r \(no output .*\); controller\.x \(no output has this name\)\. For .*"
        r'\[fmus\.controller\]\. Otherwise, .* in \[wiring\.controller\], such as "r" = 0\.0'
    )
    with pytest.raises(InputError, match=message):
        Master(parts, wiring={}, step=0.1, steps=1)
