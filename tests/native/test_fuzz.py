"""Damaged robot blobs and native FMUs under sanitizers: rejected with a message, or valid.

The number of each kind is CARDSFLOW_MUTATIONS (default: 1000). test_damaged_robot_files.py uses
the same number of robot files.

    CARDSFLOW_MUTATIONS=100000 python -m pytest -n 0 -s tests/native/test_fuzz.py
"""

from __future__ import annotations

from pathlib import Path

import fmpy
import pytest
from support.cases import LONG
from support.native.damaged import MUTATIONS, SANITIZED, count_rejected
from support.native.targets import DERIVATIVES, ROOT, TRANSITION, build_program
from support.robots.bent_cables import elastic_bent_cables
from support.robots.every_joint import every_joint
from support.robots.random_robots import random_robot
from support.robots.robots import EXAMPLES, planar_2r, with_coordinates
from support.robots.wrapped import over_ellipsoids

from addin_sdfusion.robot import read_robot
from cardsflow_fmu import Experiment
from cardsflow_fmu.runtime.sources import NATIVE
from cardsflow_fmu.runtime.sources import RUNTIME as RUNTIME_FOLDER
from cardsflow_fmu.simulation.build import build
from sim_dart import compile_blob

STRICT = ("-fno-sanitize-recover=all",)
MUSCULAR = ("pneumatic_elbow", "hill_arm")
CONTROLLER_AROUND = {"controller.ki": 500.0, "controller.observer": 20.0, "controller.delay": 1}
PLANT_OPTIONS: dict[str, dict[str, object]] = {
    "planar_2r": {"plant.integrator": "rk4", "plant.wrenches": ["link_1", "link_2"]},
    "roboy_left_arm": {"plant.energy": True},
}


@LONG
@pytest.mark.fuzz
def test_damaged_blobs(tmp_path: Path) -> None:
    robots = [
        planar_2r(),
        every_joint(),
        over_ellipsoids(),
        elastic_bent_cables(random_robot(4)),
        *(random_robot(seed) for seed in range(3)),
    ]
    robots += [read_robot(EXAMPLES / name / "robot") for name in MUSCULAR]
    robots += [with_coordinates(robot, friction=0.5) for robot in robots[:2]]
    blobs = [tmp_path / f"{k}.bin" for k in range(len(robots))]
    for path, robot in zip(blobs, robots, strict=True):
        path.write_bytes(compile_blob(robot))
    program = build_program(SANITIZED, tmp_path, ("fuzz_blobs.c", "mutate.c"), *STRICT, DERIVATIVES)
    rejected = count_rejected(program, *blobs)
    print(f"\n{MUTATIONS} blobs, {rejected} rejected")
    assert MUTATIONS / 3 < rejected < MUTATIONS


@LONG  # libFuzzer runs the same program for some seconds
@pytest.mark.fuzz
def test_damaged_native_models(tmp_path: Path) -> None:
    folders = []
    for example in ("planar_2r", "roboy_left_arm", "no_joint_encoders", *MUSCULAR):
        settings = CONTROLLER_AROUND | PLANT_OPTIONS.get(example, {})
        experiment = Experiment.load(EXAMPLES / example, settings)
        for name, file in build(experiment, tmp_path / example, compute="c").items():
            folder = tmp_path / f"{example}_{name}"
            fmpy.extract(str(file), str(folder))
            folders.append(folder / "resources")
    scratch = tmp_path / "scratch"
    scratch.mkdir()
    runtime = [str(ROOT / name) for name in NATIVE.sources() if name.startswith(RUNTIME_FOLDER)]
    flags = [*STRICT, "-D_GNU_SOURCE", *runtime, DERIVATIVES, TRANSITION, "-ldl", "-lpthread"]
    program = build_program(SANITIZED, tmp_path, ("fuzz_native.c", "mutate.c"), *flags)
    rejected = count_rejected(program, scratch, *folders)
    print(f"\n{MUTATIONS} native models, {rejected} rejected")
    assert MUTATIONS / 3 < rejected < MUTATIONS


@pytest.fixture(autouse=True)
def _without_preloaded_sanitizers(monkeypatch: pytest.MonkeyPatch) -> None:
    """The programs contain sanitizers, which also detect leaks."""
    monkeypatch.delenv("ASAN_OPTIONS", raising=False)
