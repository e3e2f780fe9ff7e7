"""MuJoCo muscle law compared with MuJoCo, and with its values for published models."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
from support.robots.muscle_bench import Bench

from addin_sdfusion.robot.formats.read import read
from addin_sdfusion.robot.model.muscle_laws import law_parameters

pytestmark = pytest.mark.native

MODEL = """
<mujoco>
  <option gravity="0 0 0"/>
  <worldbody>
    <site name="a"/>
    <body><joint name="slide" type="slide" axis="1 0 0"/><geom size="0.1" contype="0"/>
      <site name="b"/></body>
  </worldbody>
  <tendon><spatial name="t"><site site="a"/><site site="b"/></spatial></tendon>
  <actuator><general tendon="t" dyntype="muscle" gaintype="muscle" biastype="muscle"
    lengthrange="0.2 0.35" ctrlrange="0.1 0.9" gainprm="{gain}" biasprm="{bias}" dynprm="{dynamics}"
  /></actuator>
</mujoco>"""


def _numbers(values: Any) -> str:
    return " ".join(repr(float(x)) for x in values)


@pytest.mark.slow
def test_forces_and_rates_equal_mujoco() -> None:
    """Check random parameters, states and commands, with and without smoothing."""
    rng = np.random.default_rng(2)
    for k in range(40):
        low, r, lmin, lmax = rng.uniform([0.3, 0.9, 0.2, 1.2], [0.8, 1.6, 0.9, 2.0])
        vmax, fpmax, fvmax = rng.uniform([1.0, 0.2, 1.0], [12.0, 3.0, 1.8])
        passive = rng.uniform([0.3, 0.9, 1.2], [0.8, 1.6, 2.0])
        rise, fall = rng.uniform(0.005, 0.1, 2)
        force, scale, width = (700.0, 200.0, 0.0) if k % 2 else (-1.0, 900.0, rng.uniform(0.1, 2.0))
        gain = (low, r, force, scale, lmin, lmax, vmax, fpmax, fvmax)
        bias = (*passive[:2], force, scale, lmin, passive[2], vmax, fpmax, fvmax)
        text = MODEL.format(
            gain=_numbers(gain), bias=_numbers(bias), dynamics=_numbers((rise, fall, width))
        )
        model = mujoco.MjModel.from_xml_string(text)
        data = mujoco.MjData(model)
        names = ("range_low", "range_high", "force", "scale", "lmin", "lmax", "vmax", "fpmax",
                 "fvmax", "passive_range_low", "passive_range_high", "passive_lmax", "acc0",
                 "activation_time_constant", "deactivation_time_constant", "activation_width",
                 "length_low", "length_high", "control_low", "control_high")  # fmt: skip
        values = (*gain, *passive, model.actuator_acc0[0], rise, fall, width, 0.2, 0.35, 0.1, 0.9)
        bench = Bench(("mujoco_muscle", dict(zip(names, map(float, values), strict=True))))
        for _ in range(30):
            length, speed = rng.uniform(0.05, 0.6), rng.normal() * 0.3
            act, ctrl = rng.uniform(0.0, 1.0), rng.uniform(-0.2, 1.2)
            data.qpos[0], data.qvel[0], data.act[0], data.ctrl[0] = length, speed, act, ctrl
            mujoco.mj_forward(model, data)
            tension = bench.tension(length, speed, ctrl, [act])
            assert tension == pytest.approx(-data.actuator_force[0], rel=1e-12, abs=1e-12)
            assert bench.state_rates(length, speed, ctrl, [act])[0] == data.act_dot[0]


@pytest.mark.parametrize("forces", [("700 200", "400 200"), ("-1 900", "-1 500")])
def test_custom_passive_forces(tmp_path: Path, forces: tuple[str, str]) -> None:
    gain, bias = (f"0.6 1.2 {force} 0.5 1.6 2 1.3 1.2" for force in forces)
    text = MODEL.format(gain=gain, bias=bias, dynamics="0.01 0.04 0")
    text = text.replace('name="b"', 'name="b" pos="0.3 0 0"')
    (tmp_path / "m.xml").write_text(text)
    reading = read(tmp_path / "m.xml")
    assert "passive-force" not in {finding.code for finding in reading.findings}
    (muscle,) = reading.require().muscles
    bench = Bench(("mujoco_muscle", law_parameters(muscle.model)))
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    data.qpos[0], data.act[0] = 0.04, 0.3
    mujoco.mj_forward(model, data)
    tension = bench.tension(0.34, 0.0, 0.1, [0.3])
    assert tension == pytest.approx(-data.actuator_force[0], rel=1e-12)


def _published(shared: Path) -> Iterator[tuple[dict[str, Any], dict[str, Any], int]]:
    for file in sorted((shared / "reference/mjcf").glob("my*.json")):
        content = json.loads(file.read_text())
        if "actuators" not in content:
            continue
        for pose in content["poses"]:
            for i, actuator in enumerate(content["actuators"]):
                yield actuator, pose, i


@pytest.mark.slow
def test_published_models(shared: Path) -> None:
    """Compare forces of MyoSuite models to 1e-12, and activation rates exactly."""
    benches: dict[str, Bench] = {}
    compared = 0
    for actuator, pose, i in _published(shared):
        gain, key = actuator["gainprm"], f"{actuator['name']} {actuator['gainprm']}"
        assert gain == actuator["biasprm"]
        names = (
            "range_low",
            "range_high",
            "force",
            "scale",
            "lmin",
            "lmax",
            "vmax",
            "fpmax",
            "fvmax",
        )
        values = dict(zip(names, gain, strict=False)) | {
            "acc0": actuator["acc0"],
            "activation_time_constant": actuator["dynprm"][0],
            "deactivation_time_constant": actuator["dynprm"][1],
            "activation_width": actuator["dynprm"][2],
            "length_low": actuator["lengthrange"][0],
            "length_high": actuator["lengthrange"][1],
            "control_low": actuator["ctrlrange"][0],
            "control_high": actuator["ctrlrange"][1],
        }
        bench = benches.setdefault(key, Bench(("mujoco_muscle", values)))
        length, speed, act = (
            pose["actuator_length"][i], pose["actuator_velocity"][i], pose["act"][i]
        )  # fmt: skip
        force = bench.tension(length, speed, pose["ctrl"][i], [act])
        assert force == pytest.approx(-pose["actuator_force"][i], rel=1e-12, abs=1e-12)
        rate = bench.state_rates(length, speed, pose["ctrl"][i], [act])[0]
        assert math.isclose(rate, pose["act_dot"][i], rel_tol=1e-15)
        compared += 1
    assert compared > 100
