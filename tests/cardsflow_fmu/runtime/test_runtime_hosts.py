from __future__ import annotations

import sys
from pathlib import Path

import fmpy
import pytest
from support.fmu.fmu_host import run

from cardsflow_fmu.runtime.library import library_path
from cardsflow_fmu.version import __version__

pytestmark = pytest.mark.native


PYTHON_HOST = """
import ctypes, sys
library, guid, location = sys.argv[1:]
LOG = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * 2, ctypes.c_int, *[ctypes.c_char_p] * 2)
log = LOG(lambda _, name, status, category, text: print(text.decode()))
callbacks = (ctypes.c_void_p * 5)(ctypes.cast(log, ctypes.c_void_p))
instantiate = ctypes.CDLL(library).fmi2Instantiate
instantiate.restype = ctypes.c_void_p
print(instantiate(b"toy", 1, guid.encode(), location.encode(), callbacks, 0, 0))
"""


def arguments_for(toy_fmu: Path) -> list[str]:
    guid = fmpy.read_model_description(str(toy_fmu)).guid
    return [str(library_path()), guid, (toy_fmu / "resources").as_uri()]


def test_python_host_without_the_package_is_reported(
    toy_fmu: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CARDSFLOW_FMU_HOST", "in-process")
    python = [sys.executable, "-I", "-S", "-c", PYTHON_HOST]
    message, component = run([*python, *arguments_for(toy_fmu)]).splitlines()
    assert message.startswith(f"this FMU needs the package cardsflow {__version__} in the host's")
    assert sys.executable in message
    assert message.endswith("No module named 'cardsflow_fmu'")
    assert component == "None"


def test_python_host_without_the_package_uses_a_worker(toy_fmu: Path) -> None:
    python = [sys.executable, "-I", "-S", "-c", PYTHON_HOST]
    assert int(run([*python, *arguments_for(toy_fmu)]))
