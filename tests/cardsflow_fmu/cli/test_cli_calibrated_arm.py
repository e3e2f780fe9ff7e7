"""An arm that differs from its CAD is recorded and calibrated, and then runs without encoders."""

from __future__ import annotations

import importlib.util
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.cases import LONG
from support.command_line import CommandLine
from support.hardware.hardware_devices import served
from support.robots.recorded_arm import damped_arm
from support.robots.robots import EXAMPLES

from addin_sdfusion.robot.formats.convert import convert
from cardsflow_fmu import Experiment, run
from cardsflow_fmu.hardware.emulator.emulated_device import emulated_device

_spec = importlib.util.spec_from_file_location("true_arm", EXAMPLES / "unknown_arm/true_arm.py")
assert _spec is not None
assert _spec.loader is not None
true_arm = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(true_arm)

FREE = "muscles.*.offset, muscles.*.via_points, links.*.inertia, joints.*"
LOCKSTEP = {"hardware.use": True, "hardware.mode": "lockstep"}


@LONG
@pytest.mark.slow
def test_calibrated_arm_runs_without_joint_encoders(cardsflow: CommandLine, tmp_path: Path) -> None:
    """Before the calibration, the lengths match no pose. Afterwards they determine it to 1 mrad."""
    rng, cad = np.random.default_rng(1), damped_arm()
    convert(cad, "sdf", tmp_path / "cad")
    convert(true_arm.true_robot(cad, rng), "sdf", tmp_path / "truth")
    exciting, new = tmp_path / "exciting", tmp_path / "calibrated"
    words = [tmp_path / "cad", "--parameters", FREE, "--duration", "6", "-o", exciting]
    assert cardsflow("excite", *words)[0] == 0

    offsets = dict(zip((m.name for m in cad.muscles), 5e-3 * rng.normal(size=4), strict=True))
    emulator = {"noise": 1e-4, "length_offset": {k: float(b) for k, b in offsets.items()}}
    there = Experiment.load(
        exciting, {"robot.path": str(tmp_path / "truth"), "hardware.emulator": emulator, **LOCKSTEP}
    )

    def run_and_record(robot: Path, out: str, **estimator: object) -> dict[str, Any]:
        settings = {"robot.path": str(robot), **LOCKSTEP}
        settings |= {"estimator": estimator} if estimator else {}
        with served(emulated_device(there, there.hardware)) as uri:
            driven = Experiment.load(exciting, settings | {"hardware.link": uri})
            return run(driven, tmp_path / out, coupling="direct").summary

    run_and_record(tmp_path / "cad", "recorded")
    words = [tmp_path / "recorded", "--robot", tmp_path / "cad", "--parameters", FREE, "-o", new]
    code, out, _ = cardsflow("calibrate", *words)
    assert code == 0, out
    found = json.loads((new / "calibration.json").read_text())["offsets"]
    assert max(abs(found[k] - b) for k, b in offsets.items()) < 5e-3

    before = run_and_record(tmp_path / "cad", "before", find_start=True)["estimation"]
    after = run_and_record(new, "after", find_start=True, offset="calibrated")["estimation"]
    assert before["valid_share"] < 0.1
    assert after["valid_share"] == 1.0
    for error in after["per_signal"].values():
        assert error["rms"] < 1e-3
