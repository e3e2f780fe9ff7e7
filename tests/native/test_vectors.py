"""Vectors replayed on every platform and by the libraries of the package are bit-identical."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from support.native.targets import TARGETS, build_program, parametrize_targets, run
from support.native.vector_file import REPLAY, write_vectors

from controllers.qp import dual_newton
from sim_dart.core import library as core

OTHERS = ["gcc -O1 -march=native", "zig linux-aarch64, qemu"]
LONGER = ["gcc -O1", "gcc -O3 -march=native", "clang -O3", "zig linux64 v3", "zig win64, wine"]


@pytest.fixture(scope="module")
def vectors(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the file, newly written."""
    return write_vectors(tmp_path_factory.mktemp("vectors") / "vectors.bin")


@pytest.fixture(scope="module")
def replayed(vectors: Path, tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    """Return the output of the libraries of the package, which may be sanitized."""
    libraries = [core.library()._name, dual_newton.library()._name]
    folder = tmp_path_factory.mktemp("replay")
    program = build_program(TARGETS["gcc -O1"], folder, REPLAY, libraries=libraries)
    return run([*program, vectors], variables=os.environ).splitlines()


@pytest.mark.slow
@pytest.mark.native
def test_package_agrees_with_other_software(replayed: list[str]) -> None:
    """Terms of DART and MuJoCo, solutions of quadprog, Python loop with DART plant."""
    assert len(replayed) > 100


@parametrize_targets(OTHERS, long=LONGER)
def test_results_are_bit_identical_on_every_platform(
    target: str, vectors: Path, replayed: list[str], tmp_path: Path
) -> None:
    program = build_program(TARGETS[target], tmp_path, REPLAY)
    assert run([*program, vectors]).splitlines() == replayed
