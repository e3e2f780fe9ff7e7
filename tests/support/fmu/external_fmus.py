"""External FMUs for tests, written in C independently of this package, in degrees and kN."""

from __future__ import annotations

import re
import subprocess
import zipfile
from pathlib import Path
from typing import Any

import fmpy

from cardsflow_fmu.runtime.library import this_platform

_SOURCES = Path(__file__).parent / "external"
_HEADERS = Path(fmpy.__file__).parent / "c-code"
IDLE = ("SetupExperiment", "EnterInitializationMode", "Terminate")
"""Functions that only return success in these FMUs."""

UNITS = """<UnitDefinitions>
<Unit name="kN"><BaseUnit kg="1" m="1" s="-2" factor="1000"/></Unit>
<Unit name="deg"><BaseUnit rad="1" factor="0.017453292519943295"/></Unit>
<Unit name="deg/s"><BaseUnit rad="1" s="-1" factor="0.017453292519943295"/></Unit>
</UnitDefinitions>"""


MAPS: dict[str, dict[str, Any]] = {
    "2.0": {
        "inputs": {f"f.cable_{k}": f"pull_{k}" for k in range(1, 5)},
        "outputs": {
            "q.joint_1": "angle_1",
            "q.joint_2": "angle_2",
            "qd.joint_1": "rate_1",
            "qd.joint_2": "rate_2",
        },
    },
    "3.0": {"inputs": {"f": "pulls"}, "outputs": {"q": "angles", "qd": "rates"}},
}
"""Map of the FMUs, by FMI version: inputs and outputs for the ports of the planar arm."""


def scalar(name: str, reference: int, causality: str, unit: str = "", start: str = "") -> str:
    """Return a Real variable of an FMI 2.0 model description."""
    variability = "fixed" if causality == "parameter" else "continuous"
    attributes = (f' unit="{unit}"' if unit else "") + (f' start="{start}"' if start else "")
    return (
        f'<ScalarVariable name="{name}" valueReference="{reference}" causality="{causality}" '
        f'variability="{variability}"><Real{attributes}/></ScalarVariable>'
    )


def array(name: str, reference: int, causality: str, unit: str, size: int) -> str:
    """Return a Float64 array of an FMI 3.0 model description."""
    start = f' start="{" ".join(["0"] * size)}"' if causality == "input" else ""
    return (
        f'<Float64 name="{name}" valueReference="{reference}" causality="{causality}" '
        f'unit="{unit}"{start}><Dimension start="{size}"/></Float64>'
    )


FMI2_VARIABLES = "".join(
    [
        *(scalar(f"pull_{k + 1}", k, "input", "kN", "0") for k in range(4)),
        *(scalar(f"angle_{k + 1}", 4 + k, "output", "deg") for k in range(2)),
        *(scalar(f"rate_{k + 1}", 6 + k, "output", "deg/s") for k in range(2)),
        scalar("inertia", 8, "parameter", start="2"),
        '<ScalarVariable name="brake" valueReference="9" causality="input" variability="discrete">'
        '<Boolean start="false"/></ScalarVariable>',
    ]
)
FMI2 = f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="body" guid="{{body}}">
<CoSimulation modelIdentifier="body_fmi2"/>{UNITS}
<ModelVariables>{FMI2_VARIABLES}</ModelVariables>
<ModelStructure><Outputs>{"".join(f'<Unknown index="{k}"/>' for k in range(5, 9))}</Outputs>
</ModelStructure></fmiModelDescription>"""

FMI3_VARIABLES = "".join(
    [
        array("pulls", 1, "input", "kN", 4),
        array("angles", 2, "output", "deg", 2),
        array("rates", 3, "output", "deg/s", 2),
        '<Float64 name="inertia" valueReference="4" causality="parameter" variability="fixed" '
        'start="2"/>',
        '<Boolean name="brake" valueReference="5" causality="input" start="false"/>',
    ]
)
FMI3 = f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" modelName="body" instantiationToken="{{body}}">
<CoSimulation modelIdentifier="body_fmi3"/>{UNITS}
<ModelVariables>{FMI3_VARIABLES}</ModelVariables>
<ModelStructure><Output valueReference="2"/><Output valueReference="3"/></ModelStructure>
</fmiModelDescription>"""


def external_fmu(
    path: Path, compiler: str, fmi: str, description: str | None = None, model: str = "body"
) -> Path:
    """Compile and pack a model for FMI `2.0` or `3.0`; return the .fmu file."""
    name = f"{model}_fmi{fmi[0]}"
    platform = this_platform()
    library = path.with_suffix(".so")
    source = _SOURCES / f"model_fmi{fmi[0]}.c"
    rest = path.with_suffix(".c")
    rest.write_text(_absent(source.read_text(), fmi))
    flags = ["-shared", "-fPIC", "-O1", "-Wall", "-ffp-contract=off", f"-I{_HEADERS}"]
    flags.append(f'-DMODEL="{_SOURCES / model}.h"')
    sources = [str(source), str(rest)]
    subprocess.run([compiler, *flags, "-o", str(library), *sources], check=True)
    folder = platform.folder(fmi)
    with zipfile.ZipFile(path, "w") as archive:
        text = description or (FMI2 if fmi == "2.0" else FMI3)
        archive.writestr("modelDescription.xml", text)
        archive.write(library, f"binaries/{folder}/{name}.so")
    return path


def _absent(source: str, fmi: str) -> str:
    """Return C code of the missing functions of an FMU: those of `IDLE` succeed, others fail."""
    header = (_HEADERS / f"fmi{fmi[0]}Functions.h").read_text()
    names = set(re.findall(r"TYPE\s+(fmi[23]\w+);", header))
    missing = [name for name in sorted(names) if not re.search(rf"\b{name}\b", source)]
    return "".join(f"int {n}(void) {{ return {0 if n[4:] in IDLE else 3}; }}\n" for n in missing)


def exchange_only(path: Path) -> Path:
    """Return an FMU that supports model exchange only."""
    text = FMI2.replace("<CoSimulation", "<ModelExchange")
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("modelDescription.xml", text)
    return path
