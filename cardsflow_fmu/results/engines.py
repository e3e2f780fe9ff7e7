"""Engines of plant and controller, and the master algorithm, for the summary."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from addin_sdfusion.robot import InputError, limits
from cardsflow_fmu.cosim.signals.roles import HARDWARE
from cardsflow_fmu.experiment.config.custom_law import CustomLaw
from cardsflow_fmu.experiment.experiment import EXPERIMENT_FILE, Experiment
from cardsflow_fmu.models.by_role import missing_in_c
from cardsflow_fmu.models.native_loop import missing_in_loop
from cardsflow_fmu.runtime.model_file import NATIVE_FILE
from cardsflow_fmu.utils.archive import open_archive, read_entry

OVER_FMUS = "C, over FMUs"


def engine_summary(experiment: Experiment) -> dict[str, Any]:
    """Return the engines of plant and controller, reasons for Python models, and the master.

    The master is the program that couples the models: C or Python.
    """
    run = experiment.run
    missing: dict[str, str] = {}
    master = OVER_FMUS if run.coupling == "fmu" else "C, over objects"
    if run.compute == "c" and run.coupling == "fmu":
        missing = python_reasons(experiment)
    elif run.compute == "c":
        unsupported = missing_in_loop(experiment)
        missing, master = ({"loop": unsupported}, master) if unsupported else ({}, "C")
    return {
        "engine": _engines(experiment, missing, master),
        "not_in_c": missing,
        "master": master,
    }


def _engines(experiment: Experiment, missing: Mapping[str, str], master: str) -> dict[str, str]:
    """Return the engines of plant and controller."""
    if master == "C":
        return {"plant": "native", "controller": "native"}
    from sim_dart.plant.settings import select_engine

    plant = select_engine(experiment.plant.engine, experiment.scene, experiment.plant_robot)
    controller = "dart" if experiment.controller.engine == "dart" else "core"
    chosen = {"plant": str(plant), "controller": controller}
    if (experiment.run.compute, experiment.run.coupling) == ("c", "fmu"):
        chosen |= dict.fromkeys(chosen.keys() - missing.keys(), "native")
    if experiment.hardware.use:
        chosen["plant"] = HARDWARE
    return chosen | {role: fmu.file.name for role, fmu in experiment.fmus.items() if role in chosen}


def python_reasons(experiment: Experiment) -> dict[str, str]:
    """Return the models that run in Python, by role, with the feature that C does not support."""
    roles = [role for role in ("plant", "controller") if role not in experiment.fmus]
    if experiment.hardware.use and "plant" in roles:
        roles.remove("plant")
    unsupported = {role: missing_in_c(experiment, role) for role in roles}
    return {role: feature for role, feature in unsupported.items() if feature is not None}


def system_engines(files: Mapping[str, Path]) -> dict[str, str]:
    """Return the engines of plant and controller in a system of FMUs."""
    roles = [role for role in ("plant", "controller") if role in files]
    return {role: _fmu_engine(role, files[role]) for role in roles}


def _fmu_engine(role: str, file: Path) -> str:
    """Return the engine of an FMU of CARDSFlow; for other FMUs, the file name."""
    try:
        with open_archive(file, "FMU") as archive:
            if f"resources/{NATIVE_FILE}" in archive.namelist():
                return "native"
            names = (f"resources/{EXPERIMENT_FILE}", "resources/model.json")
            data, model = (json.loads(read_entry(archive, name, limits.JSON)) for name in names)
        if model["class"].endswith("HardwareModel"):
            return HARDWARE
        has_world = role == "plant" and data.get("world") is not None
        muscles = data["muscles"].values() if role == "plant" else ()
        in_python = any(CustomLaw.of(muscle.get("model", {}).get("kind", "")) for muscle in muscles)
        in_dart = has_world or in_python or data[role]["engine"] == "dart"
    except (InputError, KeyError, TypeError, ValueError, AttributeError, RecursionError):
        return file.name
    return "dart" if in_dart else "core"
