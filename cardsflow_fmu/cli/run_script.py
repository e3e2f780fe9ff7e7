"""Scripts in Python that do what `cardsflow run` does: in plain FMPy, or by this package."""

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
    """What an experiment has that the script in plain FMPy does not; None where it has all.

    Args:
        experiment: The experiment.
        realtime: Whether steps are to wait for their time by the clock.
    """
    loads = [*load_signals(experiment.robot), *wrench_signals(experiment.plant.wrenches)]
    hidden = experiment.disturbance is not None and not experiment.disturbance.known
    found = {
        "--realtime": realtime and not experiment.hardware.use,
        "[fmus]": bool(experiment.fmus),
        "[wiring]": any(
            source != 0.0 or target.partition(".")[2] not in loads
            for target, source in experiment.wiring.items()
        ),
        "a disturbance that the controller does not know of": hidden,
        f"the coupling scheme {experiment.run.scheme}": experiment.run.stepping != Coupling(),
        "hardware.approach": experiment.hardware.use and experiment.hardware.approach is not None,
    }
    return next((name for name, is_there in found.items() if is_there), None)


def fmpy_script(
    path: Path, output: Path | None, settings: Sequence[str], *, python: bool, hardware: bool
) -> str:
    """A script in plain FMPy that steps the FMUs of an experiment, as `cardsflow run` does.

    Args:
        path: An experiment.toml, or its folder.
        output: Folder for the FMUs in its description; `fmus` when None.
        settings: Changes, as in the words behind `--set`.
        python: Whether models are in Python where C has them as well.
        hardware: Whether hardware.fmu is in the plant's place unless its user says otherwise.
    """
    words = [str(path), *(word for change in settings for word in ("--set", change))]
    words += ["--compute", "python"] if python else []
    folder = shlex.quote("fmus" if output is None else str(output))
    description = f"""\
The FMUs of {path.as_posix()}, stepped in plain FMPy; no import of this package.

cardsflow build {shlex.join(words)} -o {folder}
python cosimulate.py {folder} results.csv plant        # the simulated robot
python cosimulate.py {folder} hardware.csv hardware    # hardware.fmu in its place
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
    """A script that runs an experiment, or the FMUs of an .ssp file, by this package.

    Args:
        experiment: An experiment.toml, its folder, or an .ssp.
        output: Folder for the results; the experiment's own when None.
        settings: Changes by full key.
        realtime: Whether steps wait for their time by the clock.
    """
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
