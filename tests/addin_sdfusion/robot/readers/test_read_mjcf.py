"""MJCF: M, gravity, lengths and what MuJoCo finds when it compiles are MuJoCo's own."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.oracles.moving_links import MovingLinks

from addin_sdfusion.robot import Robot
from addin_sdfusion.robot.model.tension_laws import law_parameters
from addin_sdfusion.robot.readers import read

MODEL = """<mujoco model="arm">
<compiler angle="degree" eulerseq="zyx" boundmass="0.05" boundinertia="0.001"
  balanceinertia="true"/>
<option gravity="0 1 -9"/>
<default>
  <geom density="800"/>
  <default class="soft"><joint damping="0.5" armature="0.01"/><geom density="400"/>
    <default class="pull"><muscle ctrlrange="0 1" scale="300"/></default></default>
</default>
<worldbody><site name="base" pos="0 0 1"/>
  <include file="arm.xml"/>
</worldbody>
<tendon>
  <spatial name="t"><site site="base"/><geom geom="ball" sidesite="side"/><site site="hand"/>
    <pulley divisor="2"/><site site="hand"/><site site="tip"/></spatial>
  <fixed name="f"><joint joint="turn" coef="0.02"/><joint joint="slide" coef="-0.5"/></fixed>
</tendon>
<equality><joint joint1="slide" joint2="swing" polycoef="0.1 0.2 0.3"/>
  <weld body1="hand" body2="upper"/></equality>
<actuator><muscle name="m" tendon="t" class="pull"/><motor name="w" joint="turn" gear="2"
  ctrllimited="true" ctrlrange="-3 4"/>
  <motor name="c" tendon="f" gear="-1" ctrllimited="true" ctrlrange="0 50"/></actuator>
<sensor><jointpos joint="turn"/></sensor></mujoco>
"""
ARM = """<mujocoinclude><body name="upper" pos="0 0.1 0" euler="10 20 30" childclass="soft">
  <joint name="turn" pos="0.1 0 0"axis="0 1 1" range="-40 50" ref="15"/>
  <joint name="swing" pos="0 0.05 0" axis="1 0 0" range="-30 30" ref="-10"/>
  <geom type="capsule" fromto="0 0 0 0.1 0.2 0.3" size="0.03"/>
  <geom name="ball" size="0.02" pos="0.02 0.1 0.4" mass="0"/><site name="side" pos="0.1 0.1 0.5"/>
  <frame pos="0 0 0.3" axisangle="0 0 1 90">
    <body name="hand" pos="0 0 0.1" zaxis="0 1 1"><joint name="slide" type="slide" axis="1 0 0"
        range="-0.2 0.3" ref="0.1"/>
      <inertial pos="0.01 0 0" quat="0.5 0.5 -0.5 0.5" mass="0.01" diaginertia="1e-2 1e-3 1e-3"/>
      <site name="hand" pos="0 0.05 0"/><geom type="box" size="0.1 0.1 0.1"/></body></frame>
  <body name="bits" xyaxes="0 1 0 -1 0 0"><joint name="wrist" range="-9 9"/>
    <geom type="cylinder" size="0.02 0.1" class="main"/>
    <geom type="ellipsoid" size="0.02 0.03 0.04" pos="0 0.1 0"/><site name="tip" pos="0 0 0.2"/>
    <geom type="box" size="0.02 0.03 0.04" pos="0.1 0 0" density="0"/></body>
</body></mujocoinclude>
"""


def files(folder: Path) -> Path:
    (folder / "arm.xml").write_text(ARM)
    (folder / "model.xml").write_text(MODEL)
    return folder / "model.xml"


def test_what_is_simplified_or_lost_is_said(tmp_path: Path) -> None:
    reading = read(files(tmp_path))
    robot = reading.require()
    said = {finding.code: str(finding) for finding in reading.findings}
    assert "<weld>" in said["loop-left-out"]
    assert "springs" in said["exact-equality"]
    assert "lengthrange" in said["length-range-found"]
    assert {"part-left-out", "geometry-left-out"} <= set(said)
    turn = robot.joint("upper_joint").coordinates[0]
    assert (turn.actuated, turn.tau_min, turn.tau_max) == (True, -6.0, 8.0)
    assert robot.muscle("c").f_max == 50.0
    assert [c.name for c in robot.coordinates] == ["turn", "swing", "wrist"]


@pytest.mark.interop
def test_a_small_model_is_what_mujoco_compiles(tmp_path: Path) -> None:
    mujoco = pytest.importorskip("mujoco")
    file = files(tmp_path)
    spaced = ARM.replace('0"axis', '0" axis')
    (tmp_path / "arm.xml").write_text(spaced)
    model = mujoco.MjModel.from_xml_path(str(file))
    (tmp_path / "arm.xml").write_text(ARM)
    robot = read(file).require()
    data = mujoco.MjData(model)
    names = [model.joint(k).name for k in range(model.njnt)]
    rng = np.random.default_rng(0)
    for k in range(6):
        if k:
            data.qpos[:] = rng.uniform(-0.3, 0.3, model.nq)
        mujoco.mj_forward(model, data)
        at = MovingLinks(robot, dict(zip(names, data.qpos, strict=True)))
        order = [at.names.index(name) for name in names]
        M = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, M, data.qM) if hasattr(data, "qM") else mujoco.mj_fullM(
            model, data, M
        )
        mass, gravity = at.mass_and_gravity()
        np.testing.assert_allclose(mass[np.ix_(order, order)], M, rtol=0, atol=1e-14)
        np.testing.assert_allclose(gravity[order], data.qfrc_bias, rtol=0, atol=1e-13)
        length = at.straight_length(robot.muscle("c"))
        assert length == pytest.approx(data.ten_length[1], abs=1e-14)


SHARED = ("myoarm", "myoelbow_2dof6muscles", "myofinger_v0", "myohand")


@pytest.mark.parametrize("name", SHARED)
def test_published_models_are_those_of_mujoco(shared: Path, name: str) -> None:
    robot = read(shared / f"models/mjcf/{name}.xml").require()
    reference = json.loads((shared / f"reference/mjcf/{name}.json").read_text())
    names = [joint["name"] for joint in reference["joints"]]
    for pose in reference["poses"]:
        at = MovingLinks(robot, dict(zip(names, pose["qpos"], strict=True)))
        order = [at.names.index(name) for name in names]
        M, g = at.mass_and_gravity()
        near = {"rtol": 0, "atol": 1e-13 * np.abs(pose["M"]).max()}
        np.testing.assert_allclose(M[np.ix_(order, order)], pose["M"], **near)
        if not any(pose["qvel"]):
            most = np.abs(pose["bias"]).max()
            np.testing.assert_allclose(g[order], pose["bias"], rtol=0, atol=1e-13 * most)
        pairs = zip(reference["actuators"], pose["actuator_length"], strict=True)
        for actuator, length in pairs:
            muscle = robot.muscle(actuator["name"])
            if not muscle.wraps:
                assert at.straight_length(muscle) == pytest.approx(length, abs=1e-14)
    _same_parameters(robot, reference)


def _same_parameters(robot: Robot, reference: dict[str, Any]) -> None:
    """Joints and muscles; ranges of lengths that the file gives."""
    known = {c.name: c for c in robot.all_coordinates}
    for joint in reference["joints"]:
        c = known[joint["name"]]
        ours = (c.damping, c.stiffness, c.armature, c.friction, c.rest)
        words = ("damping", "stiffness", "armature", "frictionloss", "springref")
        assert ours == pytest.approx([np.ravel(joint[word])[0] for word in words], abs=1e-15)
        if joint["limited"] and c.is_free:
            assert (c.lower, c.upper) == pytest.approx(joint["range"], abs=1e-15)
    assert {c.name for c in known.values() if c.coupling} == {
        coupling["dependent"] for coupling in reference["couplings"]
    }
    assert [m.name for m in robot.muscles] == [a["name"] for a in reference["actuators"]]
    for muscle, actuator in zip(robot.muscles, reference["actuators"], strict=True):
        values = law_parameters(muscle.model)
        own = [values[name] for name in ("range_low", "range_high", "force", "scale", "lmin",
                                         "lmax", "vmax", "fpmax", "fvmax")]  # fmt: skip
        assert own == actuator["gainprm"][:9]
        exact = robot.name != "tendon-muscle-finger"
        lengths = (values["length_low"], values["length_high"])
        assert lengths == pytest.approx(actuator["lengthrange"], rel=1e-15 if exact else 0.01)
        if values["force"] < 0.0:
            assert values["acc0"] == pytest.approx(actuator["acc0"], rel=1e-13)
