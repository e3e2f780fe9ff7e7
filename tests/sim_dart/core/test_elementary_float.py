"""The C core's elementary functions of single precision, against double precision."""

from __future__ import annotations

import ctypes
import math
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

SOURCE = Path(__file__).parents[3] / "sim_dart/csrc/math/elementary.c"
SINGLE = ["-DCARDSFLOW_FLOAT", "-fsingle-precision-constant", "-Wdouble-promotion"]
FLAGS = ["-std=c99", "-O2", "-ffp-contract=off", "-shared", "-fPIC", "-Werror", "-Wall", "-Wextra"]

Floats = NDArray[np.float32]
Function = Callable[..., float]


@pytest.fixture(scope="module")
def functions(tmp_path_factory: pytest.TempPathFactory) -> ctypes.CDLL:
    """Compiled by themselves: the core does not export them."""
    if shutil.which("gcc") is None:
        pytest.skip("no gcc")
    library = tmp_path_factory.mktemp("elementary") / "elementary_float.so"
    subprocess.run(["gcc", *FLAGS, *SINGLE, SOURCE, "-o", library, "-lm"], check=True)
    return ctypes.CDLL(str(library))


def function(library: ctypes.CDLL, name: str, arguments: int = 1) -> Function:
    made = library[name]
    made.restype = ctypes.c_float
    made.argtypes = [ctypes.c_float] * arguments
    return made


def units(got: NDArray[np.float64], true: NDArray[np.float64]) -> float:
    """The largest error in units of the last place of what is true, in single precision."""
    spacing = np.spacing(np.abs(true).astype(np.float32)).astype(float)
    return float((np.abs(got - true) / spacing).max())


def around(rng: np.random.Generator, low: float, high: float) -> Floats:
    """Numbers within bounds, and some next to nothing."""
    small = 10.0 ** rng.uniform(-15, -1, 4000) * min(high, 1.0)
    return np.concatenate([rng.uniform(low, high, 16000), small]).astype(np.float32)


@pytest.mark.parametrize(
    ("name", "true", "low", "high", "most"),
    [
        ("sine", np.sin, -10.0, 10.0, 0.8),
        ("sine", np.sin, -4096.0, 4096.0, 0.8),
        ("cosine", np.cos, -10.0, 10.0, 0.8),
        ("cosine", np.cos, -4096.0, 4096.0, 0.8),
        ("arc_sine", np.arcsin, -1.0, 1.0, 2.2),
        ("arc_cosine", np.arccos, -1.0, 1.0, 2.0),
        ("exponential", np.exp, -87.0, 88.7, 1.0),
        ("exponential", np.exp, -1.0, 1.0, 1.0),
        ("exponential_less_one", np.expm1, -30.0, 30.0, 3.0),
        ("exponential_less_one", np.expm1, -0.5, 0.5, 3.0),
        ("logarithm", np.log, 1e-37, 1e38, 1.0),
        ("logarithm", np.log, 0.5, 2.0, 1.0),
        ("hyperbolic_tangent", np.tanh, -3.0, 3.0, 2.0),
    ],
)
def test_errors_stay_within_the_last_places(
    functions: ctypes.CDLL, name: str, true: Function, low: float, high: float, most: float
) -> None:
    x = around(np.random.default_rng(1), low, high)
    own = function(functions, name)
    worst = units(np.array([own(v) for v in x]), np.asarray(true(x.astype(float))))
    print(f"\n{name}: {worst:.2f}")
    assert worst <= most


def test_arc_tangent_in_every_quadrant(functions: ctypes.CDLL) -> None:
    rng = np.random.default_rng(2)
    y, x = (rng.normal(size=(2, 20000)) * 10.0 ** rng.uniform(-12, 12, (2, 20000))).astype("f4")
    own = function(functions, "arc_tangent", 2)
    got = np.array([own(b, a) for b, a in zip(y, x, strict=True)])
    assert units(got, np.arctan2(y.astype(float), x.astype(float))) <= 1.0


@pytest.mark.parametrize("y", [0.0, -0.0, 1.0, -1.0, 1e38, 1e-40, math.inf, -math.inf])
@pytest.mark.parametrize("x", [0.0, -0.0, 1.0, -1.0, 1e38, 1e-40, math.inf, -math.inf])
def test_arc_tangent_at_the_ends_of_numbers(functions: ctypes.CDLL, y: float, x: float) -> None:
    got, true = function(functions, "arc_tangent", 2)(y, x), math.atan2(y, x)
    assert got == pytest.approx(true, rel=2e-7, abs=1e-44)
    assert math.copysign(1.0, got) == math.copysign(1.0, true)


@pytest.mark.parametrize(
    ("name", "x", "true"),
    [
        ("exponential", 89.0, math.inf),
        ("exponential", -110.0, 0.0),
        ("exponential", -math.inf, 0.0),
        ("exponential", math.inf, math.inf),
        ("logarithm", 0.0, -math.inf),
        ("logarithm", math.inf, math.inf),
        ("hyperbolic_tangent", 50.0, 1.0),
        ("hyperbolic_tangent", -math.inf, -1.0),
        ("arc_cosine", 1.5, 0.0),
    ],
)
def test_beyond_what_a_number_can_hold(
    functions: ctypes.CDLL, name: str, x: float, true: float
) -> None:
    assert function(functions, name)(x) == true


@pytest.mark.parametrize("name", ["sine", "cosine", "exponential", "logarithm"])
def test_not_a_number_stays_so(functions: ctypes.CDLL, name: str) -> None:
    assert math.isnan(function(functions, name)(math.nan))


def test_numbers_below_the_smallest_normal_one(functions: ctypes.CDLL) -> None:
    assert function(functions, "logarithm")(1e-42) == pytest.approx(math.log(1e-42), rel=1e-4)
    assert function(functions, "exponential")(-100.0) == pytest.approx(math.exp(-100), rel=0.02)


def test_an_angle_of_many_turns_errs_less_than_its_own_rounding(functions: ctypes.CDLL) -> None:
    x = np.random.default_rng(3).uniform(4096.0, 1e9, 5000).astype(np.float32)
    own = function(functions, "sine")
    off = np.abs(np.array([own(v) for v in x]) - np.sin(x.astype(float)))
    assert (off <= np.spacing(x).astype(float)).all()


def test_four_exponentials_at_once_are_those_one_by_one(functions: ctypes.CDLL) -> None:
    four = ctypes.c_float * 4
    own = function(functions, "exponential")
    for row in np.random.default_rng(4).uniform(-100.0, 100.0, (500, 4)).astype(np.float32):
        x, y = four(*row), four()
        functions.exponential_of_four(x, y)
        assert list(y) == [own(value) for value in x]
