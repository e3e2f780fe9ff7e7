"""Elementary functions of the C core in double and single precision."""

from __future__ import annotations

import ctypes
import math
import shutil
import subprocess
from collections.abc import Callable
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

SOURCE = Path(__file__).parents[3] / "sim_dart/csrc/math/elementary.c"
FLAGS = ["-std=c99", "-O2", "-ffp-contract=off", "-shared", "-fPIC", "-Werror", "-Wall"]
SINGLE = ["-DCARDSFLOW_FLOAT", "-fsingle-precision-constant", "-Wdouble-promotion", "-Wextra"]
BEYOND = [0.0, -0.0, 1.0, -1.0, math.inf, -math.inf, math.nan]
ENDS = [0.0, -0.0, 1.0, -1.0, 1e38, 1e-40, math.inf, -math.inf]

Numbers = NDArray[Any]
Function = Callable[..., float]


class Compiled(NamedTuple):
    """Functions of one precision, compiled separately since the core does not export them."""

    library: ctypes.CDLL
    number: Any
    real: type[np.floating[Any]]
    exact: type[np.floating[Any]]

    def function(self, name: str, arguments: int = 1) -> Function:
        made = self.library[name]
        made.restype, made.argtypes = self.number, [self.number] * arguments
        return made

    def units(self, got: list[float], true: Numbers) -> float:
        """Return the largest error in units of the last place."""
        spacing = np.spacing(np.abs(true).astype(self.real)).astype(self.exact)
        return float((np.abs(np.array(got).astype(self.exact) - true) / spacing).max())


def compile_elementary(folder: Path, compiler: str, *flags: str) -> ctypes.CDLL:
    if shutil.which(compiler) is None:
        pytest.skip(f"no C compiler {compiler}")
    library = folder / "elementary.so"
    subprocess.run([compiler, *FLAGS, *flags, SOURCE, "-o", library, "-lm"], check=True)
    return ctypes.CDLL(str(library))


@pytest.fixture(scope="module")
def double(tmp_path_factory: pytest.TempPathFactory) -> Compiled:
    if np.finfo(np.longdouble).nmant < 63:
        pytest.skip("no long doubles with more digits here")
    library = compile_elementary(tmp_path_factory.mktemp("double"), "cc")
    return Compiled(library, ctypes.c_double, np.float64, np.longdouble)


@pytest.fixture(scope="module")
def single(tmp_path_factory: pytest.TempPathFactory) -> Compiled:
    library = compile_elementary(tmp_path_factory.mktemp("single"), "gcc", *SINGLE)
    return Compiled(library, ctypes.c_float, np.float32, np.float64)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "true", "low", "high", "most"),
    [
        ("sine", np.sin, -10.0, 10.0, 0.8),
        ("sine", np.sin, (-1e6, -4096.0), (1e6, 4096.0), 0.8),
        ("cosine", np.cos, -10.0, 10.0, 0.8),
        ("cosine", np.cos, (-1e6, -4096.0), (1e6, 4096.0), 0.8),
        ("arc_sine", np.arcsin, -1.0, 1.0, (2.0, 2.2)),
        ("arc_cosine", np.arccos, -1.0, 1.0, 2.0),
        ("exponential", np.exp, (-700.0, -87.0), (709.7, 88.7), 1.0),
        ("exponential", np.exp, -1.0, 1.0, 1.0),
        ("exponential_less_one", np.expm1, -30.0, 30.0, 3.0),
        ("exponential_less_one", np.expm1, -0.5, 0.5, 3.0),
        ("logarithm", np.log, (1e-300, 1e-37), (1e300, 1e38), 1.0),
        ("logarithm", np.log, 0.5, 2.0, 1.0),
        ("hyperbolic_tangent", np.tanh, -3.0, 3.0, 2.0),
    ],
)
@pytest.mark.parametrize("precision", ["double", "single"])
def test_errors_stay_within_the_last_places(
    request: pytest.FixtureRequest,
    precision: str,
    name: str,
    true: Function,
    low: Any,
    high: Any,
    most: Any,
) -> None:
    """Check numbers within bounds and tiny numbers; the bounds are for double and single."""
    code: Compiled = request.getfixturevalue(precision)
    k = precision == "single"
    low, high, most = (b[k] if isinstance(b, tuple) else b for b in (low, high, most))
    rng, count = np.random.default_rng(1), 2000 * (1 + k)
    tiny = 10.0 ** rng.uniform(-15 if k else -30, -1, count) * min(high, 1.0)
    x = np.concatenate([rng.uniform(low, high, 4 * count), tiny]).astype(code.real)
    own = code.function(name)
    assert code.units([own(v) for v in x], np.asarray(true(x.astype(code.exact)))) <= most


@pytest.mark.slow
def test_multiples_of_a_quarter_turn_are_accurate(double: Compiled) -> None:
    """Near zeros of sine or cosine, a simple range reduction has no correct digits."""
    x = np.arange(1, 3000) * np.pi / 2
    exact = x.astype(np.longdouble)
    for name, true in (("sine", np.sin), ("cosine", np.cos)):
        own = double.function(name)
        got = np.array([own(v) for v in x])
        # the range reduction of long double is accurate to its last place, below 1e-19 here
        assert (np.abs(got - true(exact)) <= 1e-16 * np.abs(got) + 1e-19).all()


@pytest.mark.parametrize(
    ("precision", "size", "span", "most"), [("double", 8000, 8, 1.2), ("single", 20000, 12, 1.0)]
)
def test_arc_tangent_is_correct_in_all_quadrants(
    request: pytest.FixtureRequest, precision: str, size: int, span: int, most: float
) -> None:
    code: Compiled = request.getfixturevalue(precision)
    rng = np.random.default_rng(2)
    y, x = (rng.normal(size=(2, size)) * 10.0 ** rng.uniform(-span, span, (2, size))).astype(
        code.real
    )
    own = code.function("arc_tangent", 2)
    got = [own(a, b) for a, b in zip(y, x, strict=True)]
    assert code.units(got, np.arctan2(y.astype(code.exact), x.astype(code.exact))) <= most


def test_arc_tangent_of_special_numbers_equals_the_standard_library(double: Compiled) -> None:
    own = double.function("arc_tangent", 2)
    for a, b in product(BEYOND, BEYOND):
        assert repr(own(a, b)) == repr(math.atan2(a, b))
    assert own(math.inf, 1e300) == math.pi / 2


def test_arc_tangent_of_special_floats_equals_the_standard_library(single: Compiled) -> None:
    for y, x in product(ENDS, ENDS):
        got, true = single.function("arc_tangent", 2)(y, x), math.atan2(y, x)
        assert got == pytest.approx(true, rel=2e-7, abs=1e-44)
        assert math.copysign(1.0, got) == math.copysign(1.0, true)


def test_overflow_gives_infinity_or_nan(double: Compiled) -> None:
    for name in ("sine", "cosine"):
        own = double.function(name)
        assert math.isnan(own(math.inf))
        assert math.isnan(own(math.nan))
        assert -1.0 <= own(1e300) <= 1.0
    exponential, logarithm = (double.function(n) for n in ("exponential", "logarithm"))
    assert [exponential(x) for x in (-math.inf, -1e3, 0.0, 1e3)] == [0.0, 0.0, 1.0, math.inf]
    assert exponential(-740.0) == pytest.approx(
        math.exp(-740.0), rel=1e-2
    )  # subnormal numbers have few digits
    assert exponential(709.78) == pytest.approx(math.exp(709.78), rel=1e-13)
    assert logarithm(0.0) == -math.inf
    assert logarithm(math.inf) == math.inf
    assert logarithm(5e-324) == pytest.approx(math.log(5e-324), rel=1e-15)
    assert math.isnan(logarithm(-1.0))
    tanh = double.function("hyperbolic_tangent")
    assert [tanh(x) for x in (-math.inf, 0.0, 1e3)] == [-1.0, 0.0, 1.0]
    assert all(math.isnan(own(math.nan)) for own in (exponential, tanh))


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
        *((name, math.nan, math.nan) for name in ("sine", "cosine", "exponential", "logarithm")),
    ],
)
def test_float_overflow_gives_the_limit(single: Compiled, name: str, x: float, true: float) -> None:
    assert single.function(name)(x) == pytest.approx(true, rel=0, abs=0, nan_ok=True)


def test_subnormal_floats(single: Compiled) -> None:
    assert single.function("logarithm")(1e-42) == pytest.approx(math.log(1e-42), rel=1e-4)
    assert single.function("exponential")(-100.0) == pytest.approx(math.exp(-100), rel=0.02)


def test_error_of_large_angles_is_below_their_rounding(single: Compiled) -> None:
    x = np.random.default_rng(3).uniform(4096.0, 1e9, 5000).astype(np.float32)
    own = single.function("sine")
    off = np.abs(np.array([own(v) for v in x]) - np.sin(x.astype(float)))
    assert (off <= np.spacing(x).astype(float)).all()


def test_four_parallel_exponentials_equal_single_ones(single: Compiled) -> None:
    four = ctypes.c_float * 4
    own = single.function("exponential")
    for row in np.random.default_rng(4).uniform(-100.0, 100.0, (500, 4)).astype(np.float32):
        x, y = four(*row), four()
        single.library.exponential_of_four(x, y)
        assert list(y) == [own(value) for value in x]
