"""Damaged robot blobs and native FMUs under sanitizers: refused with a reason, or sound.

CARDSFLOW_MUTATIONS says how many of each are tried, 2000 else.
"""

from __future__ import annotations

import os
from pathlib import Path

import fmpy
import pytest
from every_joint import every_joint
from robots import EXAMPLES, planar_2r, random_robot
from targets import ROOT, Target, build_program, run_program

from cardsflow_fmu import Experiment
from cardsflow_fmu.simulation import build
from sim_dart import compile_blob

MUTATIONS = int(os.environ.get("CARDSFLOW_MUTATIONS", "2000"))
SANITIZED = Target(["gcc", "-O1", "-g", "-fsanitize=address,undefined"])
STRICT = ("-fno-sanitize-recover=all",)
RUNTIME = ROOT / "cardsflow_fmu/runtime/csrc"
CONTROLLER_AROUND = {"controller.ki": 500.0, "controller.observer": 20.0, "controller.delay": 1}


def test_damaged_blobs(tmp_path: Path) -> None:
    blobs = [tmp_path / f"{k}.bin" for k in range(5)]
    robots = [planar_2r(), every_joint(), *(random_robot(seed) for seed in range(3))]
    for path, robot in zip(blobs, robots, strict=True):
        path.write_bytes(compile_blob(robot))
    program = build_program(SANITIZED, tmp_path, ("fuzz_blobs.c", "mutate.c"), *STRICT)
    refused = int(run_program(program, "0", str(MUTATIONS), *blobs))
    print(f"\n{MUTATIONS} blobs, {refused} refused")
    assert MUTATIONS / 3 < refused < MUTATIONS


def test_damaged_native_models(tmp_path: Path) -> None:
    folders = []
    for example in ("planar_2r", "roboy_left_arm"):
        experiment = Experiment.load(EXAMPLES / example, CONTROLLER_AROUND)
        for name, file in build(experiment, tmp_path / example, native=True).items():
            folder = tmp_path / f"{example}_{name}"
            fmpy.extract(str(file), str(folder))
            folders.append(folder / "resources")
    scratch = tmp_path / "scratch"
    scratch.mkdir()
    runtime = [str(path) for path in sorted(RUNTIME.glob("*.c"))]
    flags = [*STRICT, "-D_GNU_SOURCE", f"-I{RUNTIME}", *runtime, "-ldl", "-lpthread"]
    program = build_program(SANITIZED, tmp_path, ("fuzz_native.c", "mutate.c"), *flags)
    refused = int(run_program(program, "0", str(MUTATIONS), scratch, *folders))
    print(f"\n{MUTATIONS} native models, {refused} refused")
    assert MUTATIONS / 3 < refused < MUTATIONS


@pytest.fixture(autouse=True)
def _without_preloaded_sanitizers(monkeypatch: pytest.MonkeyPatch) -> None:
    """The programs bring their own, and look for leaks too."""
    monkeypatch.delenv("ASAN_OPTIONS", raising=False)
