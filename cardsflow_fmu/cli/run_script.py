"""Python scripts for the same run as `cardsflow run`: with only FMPy, or with this package."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cardsflow_fmu.cosim.coupling import Coupling
from cardsflow_fmu.cosim.signals.ports import load_signals
from cardsflow_fmu.cosim.signals.roles import HARDWARE
from cardsflow_fmu.cosim.signals.world import wrench_signals

if TYPE_CHECKING:
    from cardsflow_fmu.experiment.experiment import Experiment

_FMPY = files("cardsflow_fmu.simulation") / "cosimulate.txt"


def missing_in_fmpy(experiment: Experiment, realtime: bool) -> str | None:
    """Return a feature of the experiment that a script with only FMPy does not support, or None."""
    loads = [*load_signals(experiment.robot), *wrench_signals(experiment.plant.wrenches)]
    hidden = experiment.disturbance is not None and not experiment.disturbance.known
    found = {
        "--realtime": realtime and not experiment.hardware.use,
        "[fmus]": bool(experiment.fmus),
        "[wiring]": any(
            source != 0.0 or target.partition(".")[2] not in loads
            for target, source in experiment.wiring.items()
        ),
        "a disturbance that is hidden from the controller": hidden,
        f"the coupling scheme {experiment.run.scheme}": experiment.run.stepping != Coupling(),
        "hardware.approach": experiment.hardware.use and experiment.hardware.approach is not None,
    }
    return next((name for name, is_used in found.items() if is_used), None)


def fmpy_script(
    path: Path, output: Path | None, settings: Sequence[str], *, python: bool, hardware: bool
) -> str:
    """Return a script with only FMPy that steps the FMUs of an experiment like `cardsflow run`.

    Args:
        path: An experiment.toml or its folder.
        output: Folder of the FMUs in the description (default: `fmus`).
        settings: Changes, as `KEY=VALUE` words of `--set`.
        python: Whether all models use the Python engine.
        hardware: Whether hardware.fmu replaces plant.fmu by default.
    """
    words = [str(path), *(word for change in settings for word in ("--set", change))]
    words += ["--compute", "python"] if python else []
    folder = shlex.quote("fmus" if output is None else str(output))
    description = f"""\
The FMUs of {path.as_posix()}, stepped with FMPy only; no import of this package.

cardsflow build {shlex.join(words)} -o {folder}
python cosimulate.py {folder} results.csv plant        # the simulated robot
python cosimulate.py {folder} hardware.csv hardware    # hardware.fmu instead
"""
    escaped = description.replace("\\", "\\\\").replace('"', '\\"')
    body = _FMPY.read_text(encoding="utf-8")
    return f'"""{escaped}"""\n\n' + body.replace("ROBOT", HARDWARE if hardware else "plant")


def run_script(
    experiment: Path,
    output: Path | None,
    settings: Mapping[str, Any],
    *,
    realtime: bool = False,
) -> str:
    """Return a script that runs an experiment or an .ssp file with this package."""
    is_system = experiment.suffix == ".ssp"
    options: dict[str, Any] = {} if output is None else {"output": str(output)}
    if is_system and settings:
        options["settings"] = dict(settings)
    if realtime:
        options["realtime"] = True
    words = "".join(f", {key}={value!r}" for key, value in options.items())
    if is_system:
        return "\n".join(
            [
                "from cardsflow_fmu import run_system",
                "",
                f"result = run_system({str(experiment)!r}{words})",
                "print(result.describe())",
                "",
            ]
        )
    changes = [f"    {key!r}: {value!r}," for key, value in settings.items()]
    return "\n".join(
        [
            "from cardsflow_fmu import Experiment, run",
            "",
            *(["settings = {", *changes, "}"] if changes else []),
            f"experiment = Experiment.load({str(experiment)!r}{', settings' if changes else ''})",
            f"result = run(experiment{words})",
            "print(result.describe())",
            "",
        ]
    )
