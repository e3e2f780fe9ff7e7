"""Times for reading, building and exporting large designs and files, and for the largest QPs."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import numpy as np
import pytest
from fake_fusion import designs, install
from support.controllers.box_solver import BoxSolver
from support.controllers.qp_problems import at_bounds, feasible, infeasible, rank_deficient
from support.designs.built_stubs import built
from support.designs.design_strategies import Draughtsman
from support.interleaved import record
from support.robots.robots import chain

from addin_sdfusion.building.build_robot import build_robot
from addin_sdfusion.exporting.convex_hull import convex_hull
from addin_sdfusion.exporting.export import export_built
from addin_sdfusion.robot import CardsflowError
from addin_sdfusion.robot.formats.read import read
from addin_sdfusion.settings import ExportSettings


@contextmanager
def takes_at_most(seconds: float, name: str) -> Iterator[None]:
    """Record the time of a block and check that it is below a limit, in [s]."""
    begin = time.perf_counter()
    yield
    took = time.perf_counter() - begin
    record(name, seconds=took)
    assert took < seconds


def test_large_design_is_read_in_time() -> None:
    with install():
        from addin_sdfusion.fusion.design import read_design

        with takes_at_most(2.0, "the fake's design of 200 links and 400 points, drawn"):
            design = designs.many_links(200, 400)
        with takes_at_most(2.0, "a design of 200 links and 400 points, read"):
            read_design(design, meshes=False)


def test_large_design_is_built_in_time() -> None:
    drawn = Draughtsman(1, 200, ["revolute"], muscles=133).draw()
    assert sum(len(m.via_points) for m in drawn.robot.muscles) > 350
    build_robot(drawn.snapshot)
    with takes_at_most(1.0, "a design of 200 links and 133 muscles, built"):
        build_robot(drawn.snapshot)


def test_design_with_200_links_is_exported_in_time(tmp_path: Path) -> None:
    settings = ExportSettings(visual=False, collision="none")
    with takes_at_most(5.0, "a design of 200 links, exported"):
        export_built(built(chain(200, 100)), settings, tmp_path / "chain")


def test_hull_of_20000_points_is_computed_in_time() -> None:
    nodes = list(map(tuple, np.random.default_rng(0).normal(size=(20_000, 3)).tolist()))
    with takes_at_most(9.0, "the hull of 20,000 points"):
        assert convex_hull(nodes) is not None


@pytest.mark.parametrize("parent", ["l{before}", "l{after}", "nowhere{i}"])
def test_ten_thousand_links_are_read_in_time(tmp_path: Path, parent: str) -> None:
    """Links form a chain, a loop, or separate parts."""
    parts = []
    for i in range(10_000):
        name = parent.format(before=max(i - 1, 0), after=(i + 1) % 10_000, i=i)
        ends = f"<parent>{name}</parent><child>l{i}</child>"
        parts.append(f'<link name="l{i}"/><joint name="j{i}" type="fixed">{ends}</joint>')
    text = f'<sdf version="1.7"><model name="m">{"".join(parts)}</model></sdf>'
    (tmp_path / "model.sdf").write_text(text)
    with takes_at_most(10.0, f"10,000 links on {parent}, read"), suppress(CardsflowError):
        read(tmp_path)


def test_published_robots_are_read_in_time(shared: Path) -> None:
    for folder in filter(Path.is_dir, sorted(shared.glob("robots/*/*"))):
        if folder.name == "templates":  # CASPR's DTDs
            continue
        with takes_at_most(2.0, f"the published robot {folder.name}, read"):
            try:
                read(folder)
            except CardsflowError as error:
                pytest.fail(f"not even read: {error}")


def test_largest_problems_are_solved_within_a_tick() -> None:
    """Problems of every kind without a warm start take far less than a tick of 10 ms."""
    worst = 0.0
    for kind in (feasible, at_bounds, rank_deficient, infeasible):
        large = [problem for problem in map(kind, range(400)) if len(problem.g) == 80]
        assert large
        for problem in large:
            m_eq, n = problem.A.shape
            begin = time.perf_counter()
            BoxSolver(n, m_eq).answer(problem)
            worst = max(worst, time.perf_counter() - begin)
    record("QPs of 80 variables, cold", worst_seconds=worst)
    assert worst < 0.05
