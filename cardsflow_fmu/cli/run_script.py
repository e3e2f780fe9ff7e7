"""The Python that does what `cardsflow run` does."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any


def run_script(
    experiment: Path,
    output: Path | None,
    settings: Mapping[str, Any],
    *,
    through: str = "fmu",
    realtime: bool = False,
) -> str:
    """A script that runs an experiment, or the FMUs of an .ssp file.

    Args:
        experiment: An experiment.toml, its folder, or an .ssp.
        output: Folder for the results; the experiment's own when None.
        settings: Changes by full key.
        through: What is stepped: FMUs, plain Python objects, or a loop in C.
        realtime: Whether steps wait for their time by the clock.
    """
    is_system = experiment.suffix == ".ssp"
    options: dict[str, Any] = {} if output is None else {"output": str(output)}
    if is_system and settings:
        options["settings"] = dict(settings)
    if through != "fmu":
        options["through"] = through
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
