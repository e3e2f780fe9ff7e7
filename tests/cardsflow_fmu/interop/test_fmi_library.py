"""FMUs in FMI Library 3.0, on which PyFMI and the FMU Compliance Checker are based.

No registry of packages contains the library. To run the test, install it from its sources and set
the environment variable CARDSFLOW_FMI_LIBRARY to its folder.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import zipfile
from pathlib import Path

import pytest
from support.fmu.fmu_host import SUPPORT
from support.robots.robots import EXAMPLES

from cardsflow_fmu import Experiment, build
from cardsflow_fmu.fmu.description import FmiVersion

pytestmark = pytest.mark.interop

PROGRAM = SUPPORT / "importers/with_fmi_library.c"
FOLDER = "CARDSFLOW_FMI_LIBRARY"
BUILDS: list[tuple[FmiVersion, bool]] = [("2.0", False), ("3.0", True), ("3.0", False)]


@pytest.fixture(scope="module")
def importer(tmp_path_factory: pytest.TempPathFactory, compiler: str) -> Path:
    if not os.environ.get(FOLDER):
        pytest.skip(f"set {FOLDER} to the folder of an installed FMI Library")
    library = Path(os.environ[FOLDER])
    program = tmp_path_factory.mktemp("importer") / "with_fmi_library"
    words = ["-std=gnu99", f"-I{library}/include", PROGRAM, "-o", program]
    libraries = [library / "lib/libfmilib.a", "-lstdc++", "-lm", "-ldl", "-lpthread"]
    subprocess.run([compiler, *words, *libraries], check=True)
    return program


@pytest.mark.parametrize("example", ["planar_2r", "hill_arm"])
@pytest.mark.parametrize(("version", "arrays"), BUILDS, ids=str)
def test_fmi_library_reports_no_problems(
    importer: Path, example: str, version: FmiVersion, arrays: bool, tmp_path: Path
) -> None:
    """Terminals are removed before, since the library supports only some of their elements."""
    experiment = Experiment.load(EXAMPLES / example)
    for role, file in build(experiment, tmp_path, fmi=version, arrays=arrays).items():
        if role == "hardware":
            continue
        folder = tmp_path / f"unpacked_{role}"
        with zipfile.ZipFile(file) as archive:
            archive.extractall(folder)
        if version == "3.0":
            shutil.rmtree(folder / "terminalsAndIcons")
        done = subprocess.run([importer, folder], capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout + done.stderr
        assert "FMI Library: 0 messages" in done.stdout
