"""Accuracy of core and laws in single precision, bit-identical on every platform.

Robots, QPs, loops and expected values are those of the tests in double precision.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from support.cases import LONG
from support.native.damaged import SANITIZED, count_rejected
from support.native.float_loop import SOFT, SOLVED, run_loop
from support.native.precision import STRICT, Handle, Precision, open_robot
from support.native.targets import (
    TARGETS,
    Target,
    build_program,
    parametrize_targets,
    run,
    single_flags,
)
from support.native.vector_file import REPLAY, write_vectors
from support.robots.bent_cables import with_bent_cables
from support.robots.driven import leg
from support.robots.every_joint import every_joint
from support.robots.random_robots import random_robot
from support.robots.robots import EXAMPLES, planar_2r
from support.robots.wrapped import over_ellipsoids

from addin_sdfusion.robot import CardsflowError, Robot, read_robot
from cardsflow_fmu import Experiment
from sim_dart import compile_blob
from sim_dart.core.library import Core

REFERENCE = "gcc -O1"
LONGER = ["gcc -O3 -march=native", "zig linux-aarch64, qemu", "zig win64, wine"]
"""Targets of long tests; test_bare_metal.py replays the same vectors on a processor for floats."""

TERMS = {
    "lengths": 2e-6,
    "jacobian": 5e-6,
    "mass_matrix": 2e-6,
    "coriolis": 5e-6,
    "gravity": 2e-6,
    "torques": 2e-5,
    "tensions": 5e-6,
    "qdd": 5e-5,
}
"""Tolerance of single precision, relative to the largest value of its kind."""

MUSCULAR = ("pneumatic_elbow", "hill_arm")


def robots() -> Iterator[Robot]:
    yield from (
        planar_2r(),
        leg(),
        every_joint(),
        over_ellipsoids(),
        *(random_robot(seed) for seed in range(5)),
    )
    for name in ("roboy_left_arm", *MUSCULAR):
        yield read_robot(EXAMPLES / name / "robot")


@pytest.fixture(scope="module")
def vectors(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_vectors(tmp_path_factory.mktemp("vectors") / "vectors.bin", single=True)


@pytest.fixture(scope="module")
def replayed(vectors: Path, tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    """Return the output of the program compiled by gcc; it fails if a vector deviates."""
    target, folder = TARGETS[REFERENCE], tmp_path_factory.mktemp("replay")
    program = build_program(target, folder, REPLAY, *single_flags(target), *STRICT)
    return run([*program, vectors]).splitlines()


@LONG
@pytest.mark.slow
def test_vectors_agree_within_single_precision(replayed: list[str]) -> None:
    assert len(replayed) > 100


@parametrize_targets([], long=LONGER)
def test_results_are_bit_identical_on_every_platform(
    target: str, vectors: Path, replayed: list[str], tmp_path: Path
) -> None:
    program = build_program(TARGETS[target], tmp_path, REPLAY, *single_flags(TARGETS[target]))
    assert run([*program, vectors]).splitlines() == replayed


@pytest.mark.slow
def test_literals_must_have_single_precision(tmp_path: Path) -> None:
    """Otherwise doubles would occur: a compiler without that flag reports an error."""
    with pytest.raises(AssertionError, match="literals_must_be_of_single_precision"):
        build_program(Target(["gcc", "-O1"]), tmp_path, REPLAY, "-DCARDSFLOW_FLOAT")


def evaluate(handle: Handle, q: np.ndarray, qd: np.ndarray, share: np.ndarray) -> None:
    """Return all terms at a state; commands are a share of their range."""
    number = handle.precision.numbers
    assert not handle.call("move_checked", number(q), number(qd))
    handle.call("start", number(share))
    handle.call("drive", number(qd), number(share))
    handle.call("pull", number(100.0 * share))
    handle.call("mass_matrix")
    handle.call("gravity")
    handle.call("bias", number(qd))
    none = np.zeros(64)  # armatures: one for each variable; the array is longer than needed
    handle.call("accelerate", number(qd), handle.array("torques").copy(), number(none))


@LONG
@pytest.mark.slow
def test_terms_deviate_by_rounding_errors_only(single: Precision, double: Precision) -> None:
    """Print the largest error of each kind."""
    worst = dict.fromkeys(TERMS, 0.0)
    for robot in robots():
        rng = np.random.default_rng(0)
        handles = open_robot(single, robot), open_robot(double, robot)
        for _ in range(4):
            q, qd = rng.uniform(-1.0, 1.0, (2, len(robot.coordinates))).astype("f4").astype(float)
            share = rng.uniform(0.05, 0.9, len(robot.muscles)).astype("f4").astype(float)
            for handle in handles:
                evaluate(handle, q, qd, share)
            for name in TERMS:
                got, true = (handle.array(name).astype(float) for handle in handles)
                off = np.abs(got - true).max() / max(np.abs(true).max(), 1e-30)
                worst[name] = max(worst[name], float(off))
    print("\n", {name: f"{off:.0e}" for name, off in worst.items()})
    assert all(off <= TERMS[name] for name, off in worst.items()), worst


@pytest.mark.cases(2)
@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "rule", "friction"),
    [
        *product(("planar_2r", "roboy_left_arm", *MUSCULAR), ("step", "runge_kutta"), (0.0,)),
        ("roboy_left_arm", "step", 0.2),
    ],
)
def test_steps_agree_with_double_precision(
    name: str, rule: str, friction: float, single: Precision, double: Precision
) -> None:
    """Simulate 0.2 s of the plant, with constant commands."""
    experiment = Experiment.load(EXAMPLES / name)
    robot = experiment.robot
    if friction:
        robot = with_bent_cables(robot, friction, experiment.start.q)
    found = []
    for precision in (single, double):
        handle = open_robot(precision, robot)
        low = np.array([muscle.f_min for muscle in robot.muscles])
        u = precision.numbers(0.3 * np.ones(low.size) if name in MUSCULAR else low)
        handle.array("q")[:] = experiment.start.q
        handle.call("move_checked", handle.array("q").copy(), handle.array("qd").copy())
        handle.call("start", u)
        assert not handle.call(rule, u, None, 1e-3, 200)
        found.append(np.concatenate([handle.array("q"), 0.01 * handle.array("qd")]).astype(float))
    off = float(np.abs(found[0] - found[1]).max())
    print(f"\n{name}, {rule}: {off:.1e} rad")
    assert off < 1e-4


@pytest.mark.slow
@pytest.mark.parametrize(("example", "unit"), [("planar_2r", "rad"), ("roboy_left_arm", "m")])
def test_single_precision_controller_tracks_as_well(
    example: str, unit: str, tmp_path: Path
) -> None:
    """The plant has double precision, as for firmware; every tick is solved.

    With the environment variable CARDSFLOW_LONG_LOOPS it runs to the end of the reference.
    """
    experiment = Experiment.load(EXAMPLES / example)
    runs = [
        run_loop(tmp_path / str(single), experiment, duration(example), single=single)
        for single in (True, False)
    ]
    single, double = runs
    off = np.abs(single.forces - double.forces).max() / double.forces.max()
    print(f"\n{example}: RMS {single.rms:.5g} {unit}, double {double.rms:.5g} {unit}")
    print(f"  forces deviate by {off:.1e} of the largest, {len(single.q)} ticks")
    assert set(single.statuses) <= {SOLVED} if set(double.statuses) == {SOLVED} else {SOLVED, SOFT}
    assert single.rms == pytest.approx(double.rms, rel=1e-2)
    assert off < 1e-4


def duration(example: str) -> float:
    """Return the duration, in [s]."""
    whole = {"planar_2r": 8.0, "roboy_left_arm": 32.0}[example]
    return whole if os.environ.get("CARDSFLOW_LONG_LOOPS") else 1.5


@pytest.mark.slow
def test_blob_of_the_other_precision_is_rejected(single: Precision) -> None:
    robot = planar_2r()
    with pytest.raises(CardsflowError, match="the blob has single precision, this library double"):
        Core(compile_blob(robot, single=True))
    blob = np.frombuffer(compile_blob(robot), np.uint64).copy()
    message = bytes(200)
    assert not single.call("core_size", blob, blob.nbytes, message, len(message))
    assert message.startswith(b"the blob has double precision")


def test_number_too_large_for_single_precision_is_rejected() -> None:
    robot = replace(planar_2r(), gravity=(0.0, 0.0, -1e60))
    assert compile_blob(robot)
    with pytest.raises(CardsflowError, match="gravity: -1e\\+60 is too large for single precision"):
        compile_blob(robot, single=True)


@LONG
@pytest.mark.fuzz
def test_damaged_blobs(tmp_path: Path) -> None:
    """Open blobs under sanitizers: each is rejected with a message, or valid."""
    paths = []
    for k, robot in enumerate(robots()):
        paths.append(tmp_path / f"{k}.bin")
        paths[-1].write_bytes(compile_blob(robot, single=True))
    flags = ("-fno-sanitize-recover=all", "-fsanitize=float-cast-overflow")
    program = build_program(
        SANITIZED, tmp_path, ("fuzz_blobs.c", "mutate.c"), *flags, *single_flags(SANITIZED)
    )
    rejected = count_rejected(program, *paths)
    print(f"\n{rejected} rejected")
    assert rejected > 0
