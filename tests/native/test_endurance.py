"""A robot for hours: no memory is allocated after the start, and no tick takes long."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from support.cases import LONG, with_marks
from support.native.example import write_example
from support.native.targets import GCC, build_program, run
from support.robots.robots import EXAMPLES

from cardsflow_fmu import Experiment

pytestmark = pytest.mark.slow

STEPS = int(os.environ.get("CARDSFLOW_STEPS", "100000"))
TICKS = int(os.environ.get("CARDSFLOW_TICKS", "10000"))


@pytest.mark.parametrize("example", ["planar_2r", with_marks("roboy_left_arm", LONG)])
def test_heap_does_not_grow(example: str, tmp_path: Path) -> None:
    """For longer runs set CARDSFLOW_STEPS and CARDSFLOW_TICKS: 10 million and 300,000."""
    write_example(tmp_path / "example.h", Experiment.load(EXAMPLES / example))
    sources = ("endurance.c", "example_loop.c")
    flags = ("-D_GNU_SOURCE", f"-I{tmp_path}")
    program = build_program(GCC, tmp_path, sources, *flags)
    heap, times, factor = run([*program, str(STEPS), str(TICKS)]).splitlines()
    before, after = heap.split()
    assert before == after
    median, rare, worst, work = (float(time) for time in times.split())
    print(f"\n{example}: {STEPS} steps; {TICKS} ticks of the controller,")
    print(f"  median {median:.2f}, 99.9 % {rare:.2f}, worst {worst:.1f} us,")
    print(f"  worst without other programs' time {work:.1f} us,")
    print(f"  loop at {float(factor):.0f} times real time")
