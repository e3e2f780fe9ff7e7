from __future__ import annotations

import sys
from pathlib import Path

import fmpy
import pytest
from fmu_host import run

from cardsflow_fmu.runtime.library import library_path
from cardsflow_fmu.version import __version__

pytestmark = pytest.mark.native


C_HOST = r"""
#include <dlfcn.h>
#include <stdarg.h>
#include <stdio.h>
#include "fmi2FunctionTypes.h"

static void log_message(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status,
                        fmi2String category, fmi2String message, ...)
{
    (void)environment, (void)name;
    va_list arguments;
    va_start(arguments, message);
    printf("%d %s: ", (int)status, category);
    vprintf(message, arguments);
    va_end(arguments);
}

int main(int count, char **arguments)
{
    fmi2CallbackFunctions callbacks = {log_message, NULL, NULL, NULL, NULL};
    void *library = count == 4 ? dlopen(arguments[1], RTLD_NOW) : NULL;
    if (!library)
        return 2;
    fmi2InstantiateTYPE *instantiate = (fmi2InstantiateTYPE *)dlsym(library, "fmi2Instantiate");
    fmi2String guid = arguments[2], location = arguments[3];
    return instantiate("toy", fmi2CoSimulation, guid, location, &callbacks, 0, 0) != NULL;
}
"""

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


HEADERS = Path(fmpy.__file__).parent / "c-code"


def arguments_for(toy_fmu: Path) -> list[str]:
    guid = fmpy.read_model_description(str(toy_fmu)).guid
    return [str(library_path()), guid, (toy_fmu / "resources").as_uri()]


def test_host_that_is_not_python(compiler: str, toy_fmu: Path, tmp_path: Path) -> None:
    source, program = tmp_path / "host.c", tmp_path / "host"
    source.write_text(C_HOST)
    run([compiler, f"-I{HEADERS}", str(source), "-o", str(program), "-ldl"])
    assert run([str(program), *arguments_for(toy_fmu)]) == (
        f"3 logStatusError: this FMU needs a Python with the package cardsflow {__version__} "
        "as its host: the host program is not Python"
    )


def test_python_without_the_package(toy_fmu: Path) -> None:
    python = [sys.executable, "-I", "-S", "-c", PYTHON_HOST]
    message, component = run([*python, *arguments_for(toy_fmu)]).splitlines()
    assert message.startswith(f"this FMU needs the package cardsflow {__version__} in the host's")
    assert sys.executable in message
    assert message.endswith("No module named 'cardsflow_fmu'")
    assert component == "None"
