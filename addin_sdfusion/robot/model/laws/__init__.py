"""The muscle laws of muscles: THE table, a module with `LAWS` for each law or family of laws.

The equations are in the C core, `sim_dart/csrc/laws/<law>.c`, which takes the parameters in the
order given here. hatch_build.py makes of the table what C has to know of it: structs of
parameters, refusals, ranges of commands, the list of laws (`sim_dart/muscles/law_headers.py`).
"""

from __future__ import annotations

from importlib import import_module
from pkgutil import iter_modules

from .law import MuscleLawDefinition

_MODULES = sorted(module.name for module in iter_modules(__path__) if module.name != "law")

MUSCLE_LAWS: dict[str, MuscleLawDefinition] = {
    law.kind: law for module in _MODULES for law in import_module(f"{__name__}.{module}").LAWS
}
"""The laws that are simulated, by kind, in the C core's order."""

LAW_NAMES = "".join(
    f"{' '.join(['law', law.kind, *(parameter.name for parameter in law.parameters)])}\n"
    for law in MUSCLE_LAWS.values()
)
"""Every law with its parameters, in order: what a core says that it was compiled with."""
