"""One file of vectors, read by a C program on every platform and through ctypes: the same bits."""

from __future__ import annotations

from pathlib import Path

import pytest
from support.native.replay import replay_vectors
from support.native.targets import TARGETS, build_program, on_targets, run_program
from support.native.vector_file import write_vectors


@pytest.fixture(scope="module")
def vectors(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The file, freshly written."""
    return write_vectors(tmp_path_factory.mktemp("vectors") / "vectors.bin")


@pytest.fixture(scope="module")
def through_ctypes(vectors: Path) -> list[str]:
    """The lines of the library that came with the package."""
    lines, worst = replay_vectors(vectors)
    assert len(lines) > 100
    assert not worst
    return lines


@pytest.mark.native
def test_the_package_gives_what_others_give(through_ctypes: list[str]) -> None:
    """DART's and MuJoCo's terms, quadprog's answers, Python's loop with DART's plant."""
    assert through_ctypes


@on_targets(TARGETS, quick="gcc -O1")
def test_every_platform_gives_the_same_bits(
    target: str, vectors: Path, through_ctypes: list[str], tmp_path: Path
) -> None:
    sources = ("replay_hosted.c", "replay_vectors.c")
    program = build_program(TARGETS[target], tmp_path, sources)
    assert run_program(program, vectors).splitlines() == through_ctypes
