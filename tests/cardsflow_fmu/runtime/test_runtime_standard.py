from __future__ import annotations

import re
import shutil
import sys
from pathlib import Path

import fmpy
import pytest
from support.fmu.fmu_host import run

from cardsflow_fmu.runtime.library import library_path

pytestmark = pytest.mark.native


HEADERS = Path(fmpy.__file__).parent / "c-code"
SOURCES = Path(__file__).parents[3] / "cardsflow_fmu/runtime/csrc/fmi"


SIZES = r"""
#include <stdio.h>

int main(void)
{
    printf("%d %d %d\n", fmi2OK, fmi2Warning, fmi2Discard);
    printf("%d %d %d\n", fmi2Error, fmi2Fatal, fmi2Pending);
    printf("%d %d\n", fmi2ModelExchange, fmi2CoSimulation);
    printf("%d %d\n", fmi2DoStepStatus, fmi2PendingStatus);
    printf("%d %d\n", fmi2LastSuccessfulTime, fmi2Terminated);
    printf("%zu %zu\n", sizeof(fmi2CallbackFunctions), offsetof(fmi2CallbackFunctions, logger));
    printf("%zu\n", offsetof(fmi2CallbackFunctions, componentEnvironment));
    printf("%d %d %s %s\n", fmi2True, fmi2False, fmi2TypesPlatform, fmi2Version);
    return 0;
}
"""

TYPES = r"""
#define SAME(type, standard) _Static_assert(_Generic((type){0}, standard: 1, default: 0), #type)
SAME(fmi2Component, void *);
SAME(fmi2ComponentEnvironment, void *);
SAME(fmi2FMUstate, void *);
SAME(fmi2ValueReference, unsigned int);
SAME(fmi2Real, double);
SAME(fmi2Integer, int);
SAME(fmi2Boolean, int);
SAME(fmi2String, const char *);
SAME(fmi2Byte, char);
"""


def test_signatures_agree_with_the_standard(compiler: str) -> None:
    """The header of the standard replaces the one of the runtime, so that the compiler compares."""
    flags = ["-std=c99", "-D_GNU_SOURCE", "-Wall", "-Wextra", "-Werror", "-fsyntax-only"]
    standard = ["-DFMI2_TYPES_H", f"-I{HEADERS}", "-include", "fmi2Functions.h"]
    run([compiler, *flags, *standard, "-Wmissing-prototypes", str(SOURCES / "fmi2.c")])
    run([compiler, *flags, *standard, str(SOURCES / "fmi2_log.c")])
    standard = ["-DFMI3_TYPES_H", f"-I{HEADERS}", "-include", "fmi3Functions.h"]
    standard.append("-DFMI3_OVERRIDE_FUNCTION_PREFIX")
    for name in ("fmi3.c", "fmi3_variables.c", "fmi3_unsupported.c"):
        run([compiler, *flags, *standard, "-Wmissing-prototypes", str(SOURCES / name)])
    run([compiler, *flags, *standard, str(SOURCES / "fmi3_component.c")])


def test_types_agree_with_the_standard(compiler: str, tmp_path: Path) -> None:
    answers = []
    for header in (SOURCES / "fmi2_types.h", HEADERS / "fmi2Functions.h"):
        source, program = tmp_path / "types.c", tmp_path / "types"
        source.write_text(f'#include <stddef.h>\n#include "{header}"\n{TYPES}{SIZES}')
        run([compiler, "-std=c11", "-Wall", "-Werror", str(source), "-o", str(program)])
        answers.append(run([str(program)]))
    assert answers[0] == answers[1]


def test_types_of_fmi_3_agree_with_the_standard(compiler: str, tmp_path: Path) -> None:
    ours = (SOURCES / "fmi3_types.h").read_text()
    names = re.findall(r"\b(fmi3\w+);|\(\*(fmi3\w+)\)", ours)
    types = [f'printf("{a or b} %zu\\n", sizeof({a or b}));' for a, b in names]
    constants = ["fmi3Discard", "fmi3Fatal", "fmi3Dependent", "fmi3IntervalChanged"]
    values = [f'printf("{name} %d\\n", (int){name});' for name in constants]
    assert len(types) > 20
    answers = []
    for header in (SOURCES / "fmi3_types.h", HEADERS / "fmi3Functions.h"):
        source, program = tmp_path / "types.c", tmp_path / "types"
        body = "int main(void)\n{\n" + "\n".join(types + values) + "\nreturn 0;\n}\n"
        source.write_text(f'#include <stdio.h>\n#include "{header}"\n{body}')
        run([compiler, "-std=c99", "-Wall", "-Werror", str(source), "-o", str(program)])
        answers.append(run([str(program)]))
    assert answers[0] == answers[1]


def test_only_fmi_functions_are_exported() -> None:
    nm = shutil.which("nm")
    if nm is None or sys.platform != "linux":
        pytest.skip("no nm")
    for library, also in (
        (library_path(), ("cardsflow_worker_", "native_model_")),
        (library_path(native=True), ()),
    ):
        lines = run([nm, "-D", "--defined-only", str(library)]).splitlines()
        names = {line.split()[-1] for line in lines}
        assert names
        assert all(name.startswith(("fmi2", "fmi3", *also)) for name in names)
