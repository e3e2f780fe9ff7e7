"""Configuration and fixtures that the tests of several packages share."""

from __future__ import annotations

import gc
import os
import signal
import subprocess
from collections.abc import Iterator
from contextlib import ExitStack
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from hypothesis import HealthCheck, settings
from support.command_server import command_server

from addin_sdfusion.robot.formats.mjcf import compiled
from sim_dart.plant import plant
from sim_dart.plant.settings import select_engine

settings.register_profile(
    "default",
    max_examples=20,
    deadline=None,  # a busy machine must not fail a test
    derandomize=True,
    suppress_health_check=list(HealthCheck),
)
settings.register_profile("thorough", settings.get_profile("default"), max_examples=100)
settings.register_profile("random", settings.get_profile("thorough"), derandomize=False)
settings.load_profile(os.environ.get("CARDSFLOW_EXAMPLES", "default"))

os.environ.setdefault("SOURCE_DATE_EPOCH", "1790000000")  # FMUs of equal input have equal bytes

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    # A shell ignores Ctrl-C in background processes (`&`); the tests need the default handler.
    signal.signal(signal.SIGINT, signal.default_int_handler)
if hasattr(signal, "SIGHUP") and signal.getsignal(signal.SIGHUP) is signal.SIG_IGN:
    signal.signal(signal.SIGHUP, signal.SIG_DFL)  # `nohup` ignores SIGHUP


EXTRAS = {
    "cad": "build123d",
    "drake": "pydrake",
    "optimise": "cmaes",
    "pandas": "pandas",
    "pinocchio": "pinocchio",
    "ros2": "rosbags",
    "sweep": "distributed",
}
"""Module whose presence shows that an extra is installed."""


def pytest_configure(config: pytest.Config) -> None:
    """Keep bytecode in the cache of pytest if Python must not write it next to its files.

    The tests start hundreds of Python processes, and most would compile longer than they run.
    """
    if os.environ.pop("PYTHONDONTWRITEBYTECODE", "") and hasattr(config, "cache"):
        os.environ["PYTHONPYCACHEPREFIX"] = str(config.cache.mkdir("bytecode"))
    if config.args == config.getini("testpaths"):
        _rotate_test_paths(config)


def _rotate_test_paths(config: pytest.Config) -> None:
    """Collect files in a different order in each worker, so that workers share bytecode."""
    count = int(os.environ.get("PYTEST_XDIST_WORKER_COUNT", "1"))
    number = int(os.environ.get("PYTEST_XDIST_WORKER", "gw0").removeprefix("gw"))
    tests = Path(__file__).parent
    files = [f for f in tests.rglob("test_*.py") if "benchmarks" not in f.parts]
    folders = sorted({str(file.parent) for file in files} - {str(tests)})
    paths = [*folders, *sorted(str(file) for file in files if file.parent == tests)]
    first = number * len(paths) // count
    config.args[:] = paths[first:] + paths[:first]


def pytest_xdist_auto_num_workers(config: pytest.Config) -> int:
    """Return the number of workers: one more than cores, since many tests wait."""
    return (os.cpu_count() or 1) + 1


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Sort the tests, long ones first; of a test with the mark `cases(n)`, select n cases."""
    items.sort(key=lambda item: (not item.get_closest_marker("first"), item.location[0]))
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


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Iterator[object]:
    """Keep the garbage collector from looking through the collected tests again and again."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.enable()


def pytest_runtest_setup(item: pytest.Item) -> None:
    """Skip tests that require an extra that is not installed."""
    for mark in item.iter_markers("extra"):
        if find_spec(EXTRAS[mark.args[0]]) is None:
            pytest.skip(f"needs the extra `{mark.args[0]}`")


@pytest.fixture(scope="session", autouse=True)
def _mjcf_in_forks(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Compile MJCF files in forks of a process with MuJoCo, which takes 0.2 s to start.

    Tests of that process itself use `own_compiler`.
    """
    with ExitStack() as stack, pytest.MonkeyPatch.context() as patch:

        @cache
        def client() -> tuple[str, ...]:
            alone = {k: v for k, v in os.environ.items() if k != "LD_PRELOAD"}
            folder = tmp_path_factory.mktemp("mujoco")
            return tuple(stack.enter_context(command_server(folder, alone, ["mujoco"])))

        def run(command: list[str], **options: Any) -> subprocess.CompletedProcess[bytes]:
            return subprocess.run([*client(), command[-1]], check=False, **options)

        if hasattr(os, "fork"):
            forks = SimpleNamespace(run=run, TimeoutExpired=subprocess.TimeoutExpired)
            patch.setattr(compiled, "subprocess", forks)
        yield


@pytest.fixture
def own_compiler() -> Iterator[None]:
    """Start MuJoCo's compiler as users do."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(compiled, "subprocess", subprocess)
        yield


@pytest.fixture
def shared() -> Path:
    """Return the folder of published robots next to the repository, or skip the test."""
    folder = Path(__file__).parents[1] / "../shared"
    if not folder.is_dir():
        pytest.skip("the published robots are not in a folder beside this repository")
    return folder


@pytest.fixture(params=["core", "dart"])
def every_engine(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    """Run a test with each engine as the default engine of plants."""
    engine = str(request.param)
    monkeypatch.setattr(
        plant,
        "select_engine",
        lambda e, *parts: select_engine(engine if e == "auto" else e, *parts),
    )
    return engine
