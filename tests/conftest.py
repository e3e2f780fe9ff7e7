"""Fixtures of several packages' tests."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

from cardsflow_fmu.results.report import figures, run_figures
from sim_dart.plant import plant
from sim_dart.plant.settings import select_engine

settings.register_profile(
    "default",
    max_examples=20,
    deadline=None,  # a busy machine is no error
    derandomize=True,
    suppress_health_check=list(HealthCheck),
)
settings.register_profile("thorough", settings.get_profile("default"), max_examples=100)
settings.register_profile("random", settings.get_profile("thorough"), derandomize=False)
settings.load_profile(os.environ.get("CARDSFLOW_EXAMPLES", "default"))

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    # A shell makes what it runs behind `&` deaf to Ctrl-C, and so all processes of the tests.
    signal.signal(signal.SIGINT, signal.default_int_handler)
if hasattr(signal, "SIGHUP") and signal.getsignal(signal.SIGHUP) is signal.SIG_IGN:
    signal.signal(signal.SIGHUP, signal.SIG_DFL)  # the same of what runs behind `nohup`


EXTRAS = {
    "cad": "build123d",
    "drake": "pydrake",
    "optimise": "cmaes",
    "pandas": "pandas",
    "parquet": "pyarrow",
    "pinocchio": "pinocchio",
    "rerun": "rerun",
    "ros2": "rosbags",
    "sweep": "distributed",
}
"""The module that tells whether an extra is installed."""


def pytest_configure(config: pytest.Config) -> None:
    """Where Python may leave no bytecode next to its files, that of the tests goes to their cache.

    They start some hundred Pythons, and compiling takes each longer than what it is started for.
    """
    if os.environ.pop("PYTHONDONTWRITEBYTECODE", "") and hasattr(config, "cache"):
        os.environ["PYTHONPYCACHEPREFIX"] = str(config.cache.mkdir("bytecode"))
    if config.args == config.getini("testpaths"):
        _begin_elsewhere(config)


def _begin_elsewhere(config: pytest.Config) -> None:
    """Each worker collects in an order of its own: what one has compiled, the others find."""
    count = int(os.environ.get("PYTEST_XDIST_WORKER_COUNT", "1"))
    number = int(os.environ.get("PYTEST_XDIST_WORKER", "gw0").removeprefix("gw"))
    tests = Path(__file__).parent
    files = [f for f in tests.rglob("test_*.py") if "benchmarks" not in f.parts]
    folders = sorted({str(file.parent) for file in files} - {str(tests)})
    paths = [*folders, *sorted(str(file) for file in files if file.parent == tests)]
    first = number * len(paths) // count
    config.args[:] = paths[first:] + paths[:first]


def pytest_xdist_auto_num_workers(config: pytest.Config) -> int:
    """One more than cores: many tests wait, and a busy machine shares itself by processes."""
    return (os.cpu_count() or 1) + 1


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """In one order; of tests with many cases that are alike, as many as their mark `cases` says."""
    items.sort(key=lambda item: item.location[0])
    if "CARDSFLOW_LONG_TESTS" in os.environ:
        return
    tests: dict[tuple[str, int], list[pytest.Item]] = {}
    for item in items:
        for mark in item.iter_markers("cases"):
            tests.setdefault((item.nodeid.partition("[")[0], mark.args[0]), []).append(item)
    left_out: set[pytest.Item] = set()
    for (_, count), cases in tests.items():
        left_out |= {*cases} - {cases[k * len(cases) // count] for k in range(count)}
    if left_out:
        config.hook.pytest_deselected(items=[item for item in items if item in left_out])
        items[:] = [item for item in items if item not in left_out]


def pytest_runtest_setup(item: pytest.Item) -> None:
    """Tests that need an extra skip without it."""
    for mark in item.iter_markers("extra"):
        if find_spec(EXTRAS[mark.args[0]]) is None:
            pytest.skip(f"needs the extra `{mark.args[0]}`")


@pytest.fixture(autouse=True, scope="session")
def undrawn_figures() -> Iterator[None]:
    """Figures of runs in the tests' process are empty files: drawing takes longer than many."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(run_figures, "image", lambda figure, form, mark: b"")
        yield


@pytest.fixture(scope="module")
def drawn_figures() -> Iterator[None]:
    """Figures of runs are drawn, until the module's last test."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(run_figures, "image", figures.image)
        yield


@pytest.fixture
def shared() -> Path:
    """Published robots, next to the repository; without them, tests that need them skip."""
    folder = Path(__file__).parents[1] / "../shared"
    if not folder.is_dir():
        pytest.skip("the published robots are not in a folder beside this repository")
    return folder


@pytest.fixture(params=["core", "dart"])
def every_engine(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    """The engine of plants that are made without one: a test that uses it holds for each."""
    engine = str(request.param)
    monkeypatch.setattr(
        plant,
        "select_engine",
        lambda e, *parts: select_engine(engine if e == "auto" else e, *parts),
    )
    return engine
