"""Coupling schemes, compared with explicit recurrences."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from addin_sdfusion.robot import InputError, UnknownNameError
from cardsflow_fmu.cosim.coupling import Coupling
from cardsflow_fmu.cosim.master import Master
from cardsflow_fmu.cosim.signals.units import KNOWN_UNITS, Conversion

pytestmark = pytest.mark.native

H, STEPS = 0.1, 20
LAMBDA = -0.8


class Part:
    """Participant whose outputs are a function of its inputs and outputs."""

    def __init__(
        self,
        name: str,
        inputs: dict[str, str],
        outputs: dict[str, str],
        law: Callable[[np.ndarray, np.ndarray, float], object],
    ) -> None:
        self.name, self.law = name, law
        self.input_names, self.output_names = tuple(inputs), tuple(outputs)
        units = {**inputs, **outputs}
        self.units = {n: KNOWN_UNITS[unit] for n, unit in units.items() if unit}
        self.inputs, self.outputs = np.zeros(len(inputs)), np.ones(len(outputs))

    def step(self, t: float, h: float) -> None:
        self.outputs[:] = self.law(self.inputs, self.outputs, h)

    def close(self) -> None:
        pass


def oscillator() -> list[Part]:
    """Two integrators in a ring: x' = y and y' = LAMBDA x."""
    return [
        Part("plant", {"y": ""}, {"x": ""}, lambda u, x, h: x + h * u),
        Part("controller", {"x": ""}, {"y": ""}, lambda u, y, h: y + h * LAMBDA * u),
    ]


def run(coupling: Coupling) -> np.ndarray:
    return Master(oscillator(), {}, step=H, steps=STEPS, coupling=coupling).run().rows[:, 1:]


def recurrence(step: Callable[[float, float], tuple[float, float]]) -> np.ndarray:
    rows = [(1.0, 1.0)]
    for _ in range(STEPS):
        rows.append(step(*rows[-1]))
    return np.array(rows)


def test_jacobi_uses_outputs_at_the_beginning_of_the_step() -> None:
    expected = recurrence(lambda x, y: (x + H * y, y + H * LAMBDA * x))
    np.testing.assert_array_equal(run(Coupling("jacobi")), expected)


@pytest.mark.parametrize("order", [("plant", "controller"), ("controller", "plant")])
def test_gauss_seidel_uses_the_newest_outputs_in_the_order(order: tuple[str, ...]) -> None:
    def step(x: float, y: float) -> tuple[float, float]:
        if order[0] == "plant":
            x = x + H * y
            return x, y + H * LAMBDA * x
        y = y + H * LAMBDA * x
        return x + H * y, y

    np.testing.assert_array_equal(run(Coupling("gauss_seidel", order)), recurrence(step))


def test_sampled_records_the_command_that_acts_from_that_time_on() -> None:
    rows = run(Coupling())
    y = 1.0 + H * LAMBDA * 1.0
    np.testing.assert_array_equal(rows[0], [1.0, y])
    np.testing.assert_array_equal(rows[1], [1.0 + H * y, y + H * LAMBDA * (1.0 + H * y)])


@pytest.mark.parametrize(
    ("coupling", "message"),
    [
        (Coupling("gauss_seidel", ("plant",)), "the order does not contain controller"),
        (Coupling("gauss_seidel", ("plant", "plant")), "twice"),
        (Coupling("sampled", ("driver",)), "no participant 'driver'"),
    ],
)
def test_an_invalid_order_is_an_error(coupling: Coupling, message: str) -> None:
    with pytest.raises(InputError, match=message):
        run(coupling)


def test_any_number_of_participants_with_different_rates() -> None:
    """A chain of counters; ambiguous column names have the participant's name as a prefix."""
    parts = [
        Part(f"p{k}", {"u": ""} if k else {}, {"n": ""}, lambda u, n, h: n + 1) for k in range(5)
    ]
    wiring = {f"p{k}.u": f"p{k - 1}.n" for k in range(1, 5)}
    every = {"p4": 5}
    master = Master(parts, wiring, step=H, steps=10, coupling=Coupling("jacobi"), every=every)
    recording = master.run()
    assert recording.names == ("time", *(f"p{k}.n" for k in range(5)))
    assert recording.rows[-1, 1:].tolist() == [11.0, 11.0, 11.0, 11.0, 3.0]


def joined(source: Part, sink: Part, wiring: dict[str, str], **options: Any) -> Master:
    """Run two coupled participants for two steps."""
    return Master([source, sink], wiring, step=H, steps=2, coupling=Coupling("jacobi"), **options)


def test_units_are_converted() -> None:
    seen = []
    source = Part("a", {}, {"angle": "deg", "force": "kN"}, lambda u, y, h: [90.0, 2.0])
    sink = Part("b", {"x": "rad", "f": "N"}, {}, lambda u, y, h: seen.append(u.tolist()) or [])
    wiring = {"b.x": "a.angle", "b.f": "a.force"}
    joined(source, sink, wiring).run()
    np.testing.assert_allclose(seen, [[np.pi / 180, 1000.0], [np.pi / 2, 2000.0]], rtol=1e-15)


def test_an_explicit_conversion_replaces_the_conversion_of_units() -> None:
    seen = []
    source = Part("a", {}, {"angle": "deg"}, lambda u, y, h: [90.0])
    sink = Part("b", {"x": "N"}, {}, lambda u, y, h: seen.append(u[0]) or [])
    changes = {"b.x": Conversion(2.0, 1.0)}
    joined(source, sink, {"b.x": "a.angle"}, changes=changes).run()
    assert seen == [3.0, 181.0]


def test_incompatible_units_are_an_error_before_the_first_step() -> None:
    source = Part("a", {}, {"angle": "deg"}, lambda u, y, h: pytest.fail("stepped"))
    sink = Part("b", {"x": "N"}, {}, lambda u, y, h: pytest.fail("stepped"))
    with pytest.raises(InputError, match=r"a\.angle -> b\.x: 'deg' is not compatible with 'N'"):
        joined(source, sink, {"b.x": "a.angle"})


def test_groups_and_arrays_are_connected_in_order_and_by_size() -> None:
    source = Part("a", {}, {"q.elbow": "", "q.wrist": "", "q2": ""}, lambda u, y, h: [1, 2, 3])
    sink = Part("b", {"u[1]": "", "u[2]": ""}, {}, lambda u, y, h: [])
    joined(source, sink, {"b.u": "a.q"}).run()
    assert sink.inputs.tolist() == [1.0, 2.0]
    with pytest.raises(
        InputError, match=r"sizes do not match: a\.q2 has 1 value, b\.u has 2 values"
    ):
        joined(source, sink, {"b.u": "a.q2"})


def test_inputs_without_a_source_keep_their_values_without_wiring_by_name() -> None:
    source = Part("a", {}, {"x": ""}, lambda u, y, h: [5.0])
    sink = Part("b", {"x": ""}, {}, lambda u, y, h: [])
    sink.inputs[:] = 7.0
    joined(source, sink, {}, by_name=False).run()
    assert sink.inputs.tolist() == [7.0]


def test_two_participants_with_the_same_name_are_an_error() -> None:
    parts = [oscillator()[0], oscillator()[0]]
    with pytest.raises(InputError, match="same name"):
        Master(parts, {}, step=H, steps=1, coupling=Coupling("jacobi"))


def test_an_unknown_port_is_named_in_the_error() -> None:
    with pytest.raises(UnknownNameError, match=r"no input 'plant\.z'"):
        Master(oscillator(), {"plant.z": 0.0}, step=H, steps=1)
