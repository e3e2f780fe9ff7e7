"""Kinds of files that users specify: a valid file of each, and the commands that read it."""

from __future__ import annotations

import contextlib
import io
import random
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from cardsflow_fmu.cli.main import main

from .mutations import damage_file
from .robot_files import (
    gltf,
    mesh,
    mjcf,
    osim,
    read_hull,
    robot_of,
    sdf,
    snapshot,
    step_file,
    table,
    urdf,
)
from .run_files import (
    bag_folder,
    calibration,
    captured,
    damage_recording,
    damage_run,
    experiments,
    fmu,
    killed_run,
    mcap,
    motion,
    read_runs,
    read_search,
    recording,
    results,
    search,
    ssp,
    study,
    study_folder,
    trajectories,
    world,
)

SECONDS = 10.0
"""Maximum processor time for a file, in [s]."""


@dataclass(frozen=True)
class Kind:
    """Kind of files.

    Attributes:
        make: Function that writes valid files to a folder.
        files: Pattern of the files that are damaged.
        commands: Commands that read them in that folder, as words after `cardsflow`. A mutation
            runs one of them.
        damage: Function that damages a file.
    """

    make: Callable[[Path], None]
    files: str
    commands: Sequence[Sequence[str] | Callable[[Path], None]]
    damage: Callable[[random.Random, Path], None] = damage_file


_TO_RUN = ("convert", ".", "--to", "run.mcap")
_TO_MOTION = ("--to", "motion_of.csv")
_IMPORT = (
    *("import-cad", "hands.step", "-o", "x", "--joints", "joints.csv", "--muscles", "muscles.csv"),
    *("--materials", "materials.csv", "--wraps", "wraps.csv"),
)
_CALIBRATE = ("calibrate", ".", "--robot", "robot", "--parameters", "muscles.*.offset", "-o", "x")
_SEEN = ("--capture", "seen.csv")
_CHECK = ("check", "experiment.toml")
_ROBOT = [
    ("check", "."),
    ("info", "."),
    ("check", ".", "--for", "osim"),
    ("check", ".", "--for", "mjcf"),
    ("init", ".", "-o", "x.toml"),
]
_MESH = [("view", ".", "--html", "a.html"), read_hull]
_EXPORT = ("import-cad", "design.json", "-o", "x")
_PLAY = ("--listen", "udp://127.0.0.1:0", "--duration", "0.001")

KINDS: dict[str, Kind] = {
    "fmu": Kind(fmu, "plant.fmu", [("info", "plant.fmu"), ("check", "with.toml")]),
    "ssp": Kind(ssp, "system.ssp", [("info", "system.ssp"), ("run", "system.ssp", "-o", "out")]),
    "npz": Kind(motion("npz"), "motion.npz", [_CHECK]),
    "npy": Kind(motion("npy"), "motion.npy", [_CHECK]),
    "csv": Kind(motion("csv"), "motion.csv", [_CHECK, ("compare", "motion.csv", "motion.csv")]),
    "sto": Kind(
        motion("sto"),
        "motion.sto",
        [_CHECK, ("activations", "robot", "--motion", "motion.sto", "-o", "x")],
    ),
    "calibration": Kind(calibration, "*.*", [_CALIBRATE]),
    "capture": Kind(
        captured,
        "*.*",
        [("calibrate", "run.csv", *_CALIBRATE[2:], "--markers", "markers.toml", *_SEEN)],
    ),
    "experiment": Kind(experiments, "experiment.toml", [_CHECK]),
    "device": Kind(experiments, "experiment.toml", [("device", "experiment.toml", *_PLAY)]),
    "study": Kind(study, "study.toml", [("study", "study.toml", "--only", "0")]),
    "recording": Kind(
        recording,
        "hardware.rec",
        [("replay-hardware", "hardware.rec", *_PLAY), ("convert", "hardware.rec", *_TO_RUN[2:])],
        damage_recording,
    ),
    "stl": Kind(mesh(".stl"), "meshes/*", _MESH),
    "obj": Kind(mesh(".obj"), "meshes/*", _MESH),
    "dae": Kind(mesh(".dae"), "meshes/*", _MESH),
    "ply": Kind(mesh(".ply"), "meshes/*", _MESH),
    "glb": Kind(mesh(".glb"), "meshes/*", _MESH),
    "off": Kind(mesh(".off"), "meshes/*", _MESH),
    "results": Kind(results, "*.json", [("compare", ".", "."), ("view", ".", "--html", "a.html")]),
    "run": Kind(results, "*.*", [("compare", ".", "."), ("view", ".", "--html", "a.html")]),
    "study folder": Kind(study_folder, "out/*/*.json", [read_runs], damage_run),
    "sdf": Kind(sdf, "model.sdf", _ROBOT),
    "urdf": Kind(urdf, "*.urdf", _ROBOT),
    "muscle table": Kind(table, "muscles.csv", _ROBOT),
    "cardsflow": Kind(robot_of("hill_arm"), "*.*", _ROBOT),
    "caspr": Kind(robot_of("planar_2r"), "*.*", _ROBOT),
    "osim": Kind(osim, "leg.osim", [*_ROBOT, ("convert", ".", "--to", "sdf", "-o", "x")]),
    "mjcf": Kind(mjcf, "*.xml", [*_ROBOT, ("convert", "model.xml", "--to", "sdf", "-o", "x")]),
    "trajectories": Kind(
        trajectories,
        "robot/*traj*",
        [("check", "samples.toml"), ("check", "parabolic_blend.toml")],
    ),
    "world": Kind(world, "world.sdf", [_CHECK]),
    "mcap": Kind(mcap, "run.mcap", [_CHECK, ("convert", "run.mcap", *_TO_MOTION)]),
    "bag": Kind(bag_folder, "bag/*", [_CHECK, ("convert", "bag", *_TO_MOTION)]),
    "gltf": Kind(gltf, "meshes/*", _MESH),
    "search": Kind(search, "study.toml", [read_search]),
    "killed run": Kind(killed_run, "*.*", [("compare", ".", "."), _TO_RUN]),
    "figures": Kind(results, "*.*", [("plot", "."), ("report", ".")]),
    "step": Kind(step_file, "*.step", [_IMPORT]),
    "step tables": Kind(step_file, "*.csv", [_IMPORT]),
    "snapshot": Kind(snapshot, "design.json", [_EXPORT]),
}


def command(folder: Path, words: Sequence[str]) -> tuple[int, str]:
    """Run a command in the current folder; return its exit code and messages."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            code = main(words)
        except SystemExit as end:
            code = int(end.code or 0)
    return code, err.getvalue()
