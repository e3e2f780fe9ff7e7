"""Definitions of all muscle laws: one module with `LAWS` for each law or family of laws.

The C core contains the equations, `sim_dart/csrc/laws/<law>.c`, and uses the parameters in the
order defined here. From these definitions hatch_build.py generates C headers with parameter
structs, parameter checks, command ranges and the list of laws (`sim_dart/muscles/law_headers.py`).
"""

from __future__ import annotations

from importlib import import_module
from pkgutil import iter_modules

from .law import MuscleLawDefinition

_MODULES = sorted(module.name for module in iter_modules(__path__) if module.name != "law")

MUSCLE_LAWS: dict[str, MuscleLawDefinition] = {
    law.kind: law for module in _MODULES for law in import_module(f"{__name__}.{module}").LAWS
}
"""All simulated muscle laws, by kind, in the C core's order."""

LAW_NAMES = "".join(
    f"{' '.join(['law', law.kind, *(parameter.name for parameter in law.parameters)])}\n"
    for law in MUSCLE_LAWS.values()
)
"""Names of all laws and parameters, in order. A core reports the text it was compiled with."""
