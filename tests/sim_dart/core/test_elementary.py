"""The C core's own elementary functions, against the platform's with more digits."""

from __future__ import annotations

import ctypes
import math
import shutil
import subprocess
from collections.abc import Callable
from itertools import product
from pathlib import Path

import numpy as np
import pytest

SOURCE = Path(__file__).parents[3] / "sim_dart/csrc/math/elementary.c"
BEYOND = [0.0, -0.0, 1.0, -1.0, math.inf, -math.inf, math.nan]

Function = Callable[..., float]


@pytest.fixture(scope="module")
def functions(tmp_path_factory: pytest.TempPathFactory) -> ctypes.CDLL:
    """Compiled by themselves: the core does not export them."""
    if np.finfo(np.longdouble).nmant < 63:
        pytest.skip("no long doubles with more digits here")
    compiler = shutil.which("cc")
    if compiler is None:
        pytest.skip("no C compiler")
    library = tmp_path_factory.mktemp("elementary") / "elementary.so"
    flags = ["-std=c99", "-O2", "-ffp-contract=off", "-shared", "-fPIC", "-Werror", "-Wall"]
    subprocess.run([compiler, *flags, SOURCE, "-o", library, "-lm"], check=True)
    return ctypes.CDLL(str(library))


def function(library: ctypes.CDLL, name: str, arguments: int = 1) -> Function:
    made = library[name]
    made.restype = ctypes.c_double
    made.argtypes = [ctypes.c_double] * arguments
    return made


def units(got: np.ndarray, true: np.ndarray) -> float:
    """The largest error in units of the last place of what is true."""
    spacing = np.spacing(np.abs(true.astype(float)))
    return float((np.abs(got.astype(np.longdouble) - true) / spacing).max())


def around(rng: np.random.Generator, low: float, high: float) -> np.ndarray:
    """Numbers within bounds, and some next to nothing."""
    small = 10.0 ** rng.uniform(-30, -1, 2000) * min(high, 1.0)
    return np.concatenate([rng.uniform(low, high, 8000), small])


@pytest.mark.parametrize(
    ("name", "true", "low", "high", "most"),
    [
        ("sine", np.sin, -10.0, 10.0, 0.8),
        ("sine", np.sin, -1e6, 1e6, 0.8),
        ("cosine", np.cos, -10.0, 10.0, 0.8),
        ("cosine", np.cos, -1e6, 1e6, 0.8),
        ("arc_sine", np.arcsin, -1.0, 1.0, 2.0),
        ("arc_cosine", np.arccos, -1.0, 1.0, 2.0),
        ("exponential", np.exp, -700.0, 709.7, 1.0),
        ("exponential", np.exp, -1.0, 1.0, 1.0),
        ("exponential_less_one", np.expm1, -30.0, 30.0, 3.0),
        ("exponential_less_one", np.expm1, -0.5, 0.5, 3.0),
        ("logarithm", np.log, 1e-300, 1e300, 1.0),
        ("logarithm", np.log, 0.5, 2.0, 1.0),
        ("hyperbolic_tangent", np.tanh, -3.0, 3.0, 2.0),
    ],
)
def test_errors_stay_within_the_last_places(
    functions: ctypes.CDLL, name: str, true: Function, low: float, high: float, most: float
) -> None:
    x = around(np.random.default_rng(1), low, high)
    own = function(functions, name)
    assert units(np.array([own(v) for v in x]), true(x.astype(np.longdouble))) <= most


def test_multiples_of_a_quarter_turn_keep_their_digits(functions: ctypes.CDLL) -> None:
    """Where sine or cosine is nearly zero, a careless reduction leaves none."""
    x = np.arange(1, 3000) * np.pi / 2
    exact = x.astype(np.longdouble)
    for name, true in (("sine", np.sin), ("cosine", np.cos)):
        own = function(functions, name)
        got = np.array([own(v) for v in x])
        # the long double's own reduction is good to its last place, which is below 1e-19 here
        assert (np.abs(got - true(exact)) <= 1e-16 * np.abs(got) + 1e-19).all()


def test_the_arc_tangent_is_right_in_all_quadrants(functions: ctypes.CDLL) -> None:
    rng = np.random.default_rng(2)
    y, x = rng.normal(size=(2, 8000)) * 10.0 ** rng.uniform(-8, 8, (2, 8000))
    own = function(functions, "arc_tangent", 2)
    got = np.array([own(a, b) for a, b in zip(y, x, strict=True)])
    assert units(got, np.arctan2(y.astype(np.longdouble), x.astype(np.longdouble))) <= 1.2
    for a, b in product(BEYOND, BEYOND):
        assert repr(own(a, b)) == repr(math.atan2(a, b))
    assert own(math.inf, 1e300) == math.pi / 2


def test_numbers_that_overflow_are_refused(functions: ctypes.CDLL) -> None:
    for name in ("sine", "cosine"):
        own = function(functions, name)
        assert math.isnan(own(math.inf))
        assert math.isnan(own(math.nan))
        assert -1.0 <= own(1e300) <= 1.0
    exponential, logarithm = (function(functions, n) for n in ("exponential", "logarithm"))
    assert [exponential(x) for x in (-math.inf, -1e3, 0.0, 1e3)] == [0.0, 0.0, 1.0, math.inf]
    assert exponential(-740.0) == pytest.approx(math.exp(-740.0), rel=1e-2)  # has few digits
    assert exponential(709.78) == pytest.approx(math.exp(709.78), rel=1e-13)
    assert logarithm(0.0) == -math.inf
    assert logarithm(math.inf) == math.inf
    assert logarithm(5e-324) == pytest.approx(math.log(5e-324), rel=1e-15)
    assert math.isnan(logarithm(-1.0))
    tanh = function(functions, "hyperbolic_tangent")
    assert [tanh(x) for x in (-math.inf, 0.0, 1e3)] == [-1.0, 0.0, 1.0]
    assert all(math.isnan(own(math.nan)) for own in (exponential, tanh))
