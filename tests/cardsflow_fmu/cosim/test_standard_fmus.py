"""FMUs of the FMI project run to the end: their variables, in models of our own."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from support.fmu.external_fmus import external_fmu
from support.fmu.standard_fmus import FEEDTHROUGH, feedthrough, state_space, van_der_pol
from support.robots.robots import PLANAR_2R

from addin_sdfusion.robot import CardsflowError
from cardsflow_fmu import Experiment
from cardsflow_fmu.cosim.coupling import Coupling
from cardsflow_fmu.cosim.fmu_instance import FmuInstance
from cardsflow_fmu.cosim.master import Master
from cardsflow_fmu.simulation.run import simulate

STEP = 0.01


@pytest.fixture(scope="module")
def fmus(tmp_path_factory: pytest.TempPathFactory, compiler: str) -> dict[tuple[str, str], Path]:
    """Build the FMUs, by model and version of FMI."""
    folder = tmp_path_factory.mktemp("standard")
    models = {("van_der_pol", fmi): van_der_pol(fmi) for fmi in FEEDTHROUGH}
    models |= {("feedthrough", fmi): feedthrough(fmi) for fmi in FEEDTHROUGH}
    models["state_space", "3.0"] = state_space()
    return {
        (model, fmi): external_fmu(folder / f"{model}_{fmi[0]}.fmu", compiler, fmi, text, model)
        for (model, fmi), text in models.items()
    }


@contextmanager
def opened(
    folder: Path, file: Path, values: Mapping[str, float] | None = None
) -> Iterator[FmuInstance]:
    instance = FmuInstance(file.stem, file, folder / file.stem, values)
    try:
        yield instance
    finally:
        instance.close()


def oscillation(mu: float, steps: int) -> np.ndarray:
    """Return x0 and x1 by Euler's method, shape (steps + 1, 2)."""
    rows = [np.array([2.0, 0.0])]
    for _ in range(steps):
        x, v = rows[-1]
        rows.append(rows[-1] + STEP * np.array([v, mu * (1.0 - x * x) * v - x]))
    return np.array(rows)


@pytest.mark.parametrize("version", FEEDTHROUGH)
def test_van_der_pol_and_all_types_of_feedthrough(
    fmus: dict[tuple[str, str], Path], version: str, tmp_path: Path
) -> None:
    source, target = fmus["van_der_pol", version], fmus["feedthrough", version]
    kinds = FEEDTHROUGH[version]
    wiring: dict[str, str | float] = {
        f"{target.stem}.{kind}_input": f"{source.stem}.x0" for kind in kinds
    }
    with (
        opened(tmp_path, source, {"mu": 2.0}) as oscillator,
        opened(tmp_path, target) as other,
    ):
        order = Coupling("gauss_seidel", (source.stem, target.stem))
        master = Master([oscillator, other], wiring, step=STEP, steps=2000, coupling=order)
        recording = master.run()
    assert recording.failure is None
    x = recording.rows[:, [recording.names.index(name) for name in ("x0", "x1")]]
    np.testing.assert_array_equal(x, oscillation(2.0, 2000))
    for kind in kinds:
        output = recording.rows[1:, recording.names.index(f"{kind}_output")]
        value = x[1:, 0]
        rounded = np.rint(value)
        if kind.startswith("U"):
            rounded = np.maximum(rounded, 0.0)
        expected = {"Float64": value, "Float32": np.float32(value), "Boolean": rounded != 0}
        np.testing.assert_array_equal(output, expected.get(kind, rounded), err_msg=kind)


def test_structural_parameters_set_the_sizes_of_arrays(
    fmus: dict[tuple[str, str], Path], tmp_path: Path
) -> None:
    """An oscillator of two states with one input: x' = A x + B u with u = 3, by Euler's method."""
    A, b = np.array([[0.0, 1.0], [-4.0, -0.2]]), np.array([0.0, 0.5])
    values = {"n": 2.0, "m": 1.0, "r": 1.0, "x0[1]": 1.0, "C[1,1]": 1.0, "D": 0.0}
    values |= {f"A[{i + 1},{j + 1}]": A[i, j] for i in range(2) for j in range(2)}
    values |= {"B[1,1]": b[0], "B[2,1]": b[1]}
    with opened(tmp_path, fmus["state_space", "3.0"], values) as system:
        assert (system.input_names, system.output_names) == (("u[1]",), ("y[1]",))
        wiring: dict[str, str | float] = {f"{system.name}.u[1]": 3.0}
        order = Coupling("gauss_seidel", (system.name,))
        recording = Master([system], wiring, step=STEP, steps=1000, coupling=order).run()
    assert recording.failure is None
    x, expected = np.array([1.0, 0.0]), [1.0]
    for _ in range(1000):
        x = x + STEP * (A @ x + 3.0 * b)
        expected.append(x[0])
    np.testing.assert_allclose(recording.rows[:, 1], expected, rtol=0, atol=1e-12)


def test_state_space_replaces_the_plant_of_an_experiment(
    fmus: dict[tuple[str, str], Path],
) -> None:
    """Its four states are q and qd: free motion with constant velocity."""
    parameters = {"m": 4, "n": 4, "r": 4, "A[1,3]": 1, "A[2,4]": 1, "B": 0, "D": 0}
    parameters |= {f"C[{k},{k}]": 1 for k in range(1, 5)} | {
        "x0[1]": -0.5,
        "x0[2]": 0.5,
        "x0[3]": 0.25,
    }
    plant = {
        "path": str(fmus["state_space", "3.0"]),
        "parameters": parameters,
        "inputs": {"f": "u"},
        "outputs": {
            "q.joint_1": "y[1]",
            "q.joint_2": "y[2]",
            "qd.joint_1": "y[3]",
            "qd.joint_2": "y[4]",
        },
    }
    result = simulate(
        Experiment.load(PLANAR_2R, {"fmus.plant": plant, "run.duration": 0.1}), coupling="direct"
    )
    np.testing.assert_allclose(result["q.joint_1"], -0.5 + 0.25 * result["time"], atol=1e-13)
    np.testing.assert_array_equal(result["q.joint_2"], 0.5)


@pytest.mark.parametrize(
    ("size", "message"),
    [
        (2.5, "the structural parameter n must be a number of items, not 2.5"),
        (-1.0, "the structural parameter n must be a number of items, not -1"),
        (1e9, "it has more than"),
        (6.0, "failed at the start"),
    ],
)
def test_an_invalid_size_is_an_error(
    fmus: dict[tuple[str, str], Path], tmp_path: Path, size: float, message: str
) -> None:
    file = fmus["state_space", "3.0"]
    with pytest.raises(CardsflowError, match=message), opened(tmp_path, file, {"n": size}):
        pass
