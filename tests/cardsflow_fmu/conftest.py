"""An FMU of the toy model, and instances of it."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from support.browser import NO_DRAWING, Page, opened_browser
from support.command_line import CommandLine
from support.fmu.fmu_host import Host, opened, unpack
from support.fmu.worker_host import unpack_stubborn

from cardsflow_fmu.fmu.description import FmiVersion


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Tests of FMUs are of FMI 2.0, and of FMI 3.0 as well where their module reports it."""
    if "fmi" in metafunc.fixturenames:
        versions = getattr(metafunc.module, "FMI", ("2.0",))
        metafunc.parametrize("fmi", versions, scope="session")


@pytest.fixture(scope="session")
def toy_fmu(tmp_path_factory: pytest.TempPathFactory, fmi: FmiVersion) -> Path:
    """An unpacked FMU of the toy model."""
    return unpack(tmp_path_factory.mktemp("toy") / "toy", fmi=fmi)


@pytest.fixture(scope="session")
def stubborn_fmu(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An unpacked FMU of the stubborn model."""
    return unpack_stubborn(tmp_path_factory.mktemp("stubborn") / "stubborn")


@pytest.fixture
def damaged(toy_fmu: Path, tmp_path: Path) -> Path:
    """A copy of the FMU to damage."""
    return Path(shutil.copytree(toy_fmu, tmp_path / "copy"))


@pytest.fixture
def host(toy_fmu: Path) -> Iterator[Host]:
    """A new instance."""
    with opened(toy_fmu) as (host,):
        yield host


@pytest.fixture
def started(host: Host) -> Host:
    """An instance in step mode."""
    host.start()
    return host


@pytest.fixture(scope="session")
def compiler() -> str:
    """A C compiler; gcc if there is one, since other tests have its object files."""
    found = next(filter(shutil.which, ("gcc", "cc", "clang")), None)
    if found is None or sys.platform == "win32":
        pytest.skip("no C compiler")
    return found


@pytest.fixture
def cardsflow(capsys: pytest.CaptureFixture[str]) -> CommandLine:
    """The command line."""
    return CommandLine(capsys)


@pytest.fixture(scope="session")
def opened_tab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Page]:
    """The tab of a browser, which all tests of a process use."""
    with opened_browser(tmp_path_factory.mktemp("browser")) as tab:
        yield tab


@pytest.fixture
def page(opened_tab: Page, request: pytest.FixtureRequest) -> Page:
    """An empty page, which draws only if the module reports that it looks at pictures."""
    opened_tab.reset()
    if not getattr(request.module, "PICTURES", False):
        opened_tab.run_first(NO_DRAWING)
    return opened_tab
