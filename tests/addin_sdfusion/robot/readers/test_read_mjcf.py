"""MJCF: names, parameters and files; for dynamics see sim_dart/dynamics/test_mjcf_files.py."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
from support.mjcf_files import BESIDE
from support.third_party_models import INCLUDED, MJCF, OPTIONS

from addin_sdfusion.robot import Robot
from addin_sdfusion.robot.formats.read import read
from addin_sdfusion.robot.model.muscle_laws import law_parameters


def files(folder: Path) -> Path:
    (folder / "arm.xml").write_text(INCLUDED)
    (folder / "options.xml").write_text(OPTIONS)
    (folder / "model.xml").write_text(MJCF)
    return folder / "model.xml"


def test_simplified_and_omitted_features_are_reported(tmp_path: Path) -> None:
    reading = read(files(tmp_path))
    robot = reading.require()
    assert robot.gravity == (0.0, 1.0, -9.0)
    reported = {finding.code: str(finding) for finding in reading.findings}
    assert "1 equalities of loops" in reported["exact-equality"]
    assert "springs" in reported["exact-equality"]
    assert "lengthrange" in reported["length-range-found"]
    assert {"part-left-out", "geometry-left-out"} <= set(reported)
    turn = robot.joint("upper_joint").coordinates[0]
    assert (turn.actuated, turn.tau_min, turn.tau_max) == (True, -6.0, 8.0)
    assert robot.muscle("c").f_max == 50.0
    assert [c.name for c in robot.coordinates] == ["turn", "swing", "wrist"]


SHARED = ("myoarm", "myoelbow_2dof6muscles", "myofinger_v0", "myohand")


@pytest.mark.parametrize("name", SHARED)
def test_published_models_have_the_parameters_of_mujoco(shared: Path, name: str) -> None:
    robot = read(shared / f"models/mjcf/{name}.xml").require()
    reference = json.loads((shared / f"reference/mjcf/{name}.json").read_text())
    _same_parameters(robot, reference)


def _same_parameters(robot: Robot, reference: dict[str, Any]) -> None:
    """Compare joints and muscles; length ranges must be given in the file."""
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
        own = [values[name] for name in ("range_low", "range_high", "lmin", "lmax", "vmax", "fpmax",
                                         "fvmax")]  # fmt: skip
        assert own == [*actuator["gainprm"][:2], *actuator["gainprm"][4:9]]
        force, scale = actuator["gainprm"][2:4]
        force = force if force > 0.0 else scale / actuator["acc0"]
        assert values["force"] == pytest.approx(force, rel=1e-13)
        exact = robot.name != "tendon-muscle-finger"
        lengths = (values["length_low"], values["length_high"])
        assert lengths == pytest.approx(actuator["lengthrange"], rel=1e-15 if exact else 0.01)


def test_bodies_have_the_order_of_mujoco(tmp_path: Path) -> None:
    """Children of a body come before the next body, as do the values of a keyframe."""

    def body(name: str, inner: str = "") -> str:
        inertial = '<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>'
        return f'<body name="{name}"><joint name="{name}"/>{inertial}{inner}</body>'

    bodies = body("a", f"<frame>{body('b')}</frame>" + body("c", body("d"))) + body("e")
    key = '<keyframe><key name="initial" qpos="0.1 0.2 0.3 0.4 0.5"/></keyframe>'
    file = tmp_path / "arm.xml"
    file.write_text(f"<mujoco><worldbody>{bodies}</worldbody>{key}</mujoco>")
    robot, model = read(file).require(), mujoco.MjModel.from_xml_path(str(file))
    assert [c.name for c in robot.coordinates] == [model.joint(k).name for k in range(5)]
    assert [c.initial for c in robot.coordinates] == model.key_qpos[0].tolist()


def test_included_files_are_relative_to_the_model_or_the_including_file(tmp_path: Path) -> None:
    def body(name: str) -> str:
        return f'<mujocoinclude><body name="{name}"><geom size="0.1"/></body></mujocoinclude>'

    file = tmp_path / "model.xml"
    file.write_text('<mujoco><worldbody><include file="parts/all.xml"/></worldbody></mujoco>')
    (tmp_path / "parts").mkdir()
    both = '<include file="a.xml"/><include file="b.xml"/>'
    (tmp_path / "parts" / "all.xml").write_text(f"<mujocoinclude>{both}</mujocoinclude>")
    (tmp_path / "a.xml").write_text(body("a"))
    (tmp_path / "parts" / "a.xml").write_text(body("not_this"))
    (tmp_path / "parts" / "b.xml").write_text(body("b"))
    model = mujoco.MjModel.from_xml_path(str(file))
    names = [link.name for link in read(file).require().links]
    assert names == [model.body(k).name for k in range(1, model.nbody)] == ["a", "b"]


COPIES = """<mujoco model="fan"><worldbody><body name="hub"><geom size="0.1"/>
<replicate count="10" sep="-" offset="0.1 0 0.02"><body name="blade"><geom size="0.02"/>
<replicate count="2" sep="_" offset="0 0.1 0"><site name="hole"/></replicate></body></replicate>
</body></worldbody></mujoco>"""


def test_replicated_elements_have_the_names_of_mujoco(tmp_path: Path) -> None:
    (tmp_path / "fan.xml").write_text(COPIES)
    robot, model = read(tmp_path / "fan.xml").require(), mujoco.MjModel.from_xml_string(COPIES)
    assert [link.name for link in robot.links][:3] == ["hub", "blade-00", "blade-01"]
    names = [frame.name for frame in robot.task_sets[0].frames]
    assert names == [model.site(k).name for k in range(20)]


def test_visual_meshes_have_the_pose_of_their_geom(tmp_path: Path) -> None:
    """MuJoCo moves a compiled mesh into the frame of its inertia; here it is not moved."""
    (tmp_path / "t.obj").write_text(BESIDE["parts/tetra.obj"])
    geom = '<geom type="mesh" mesh="t" pos="1 2 3" euler="10 20 30" {}/>'
    filled, bare = geom.format(""), geom.format('mass="0" group="4"')
    (tmp_path / "m.xml").write_text(
        '<mujoco><asset><mesh file="t.obj" scale="1 2 3"/></asset><worldbody><body name="b">'
        f'<joint/>{filled}<frame pos="0 0 1">{bare}</frame></body>'
        "</worldbody></mujoco>"
    )
    first, second = read(tmp_path / "m.xml").require().link("b").meshes
    assert (first.uri, first.scale, first.role) == ("t.obj", (1.0, 2.0, 3.0), "visual")
    assert first.pose.position == pytest.approx((1.0, 2.0, 3.0))
    assert (second.role, second.pose.position) == ("collision", pytest.approx((1.0, 2.0, 4.0)))
    assert first.pose.rpy == pytest.approx(second.pose.rpy)


def test_muscles_on_unlimited_joints_have_lengths(tmp_path: Path) -> None:
    """Sums of angles may be negative; an unlimited hinge rotates by one revolution."""
    (tmp_path / "m.xml").write_text(
        '<mujoco><worldbody><site name="o" pos="0.3 0 0"/><body name="b"><joint name="h" '
        'axis="0 0 1"/><geom size="0.1"/><site name="t" pos="0.1 0 0"/><body name="c">'
        '<joint name="k" range="-60 30"/><geom size="0.1" pos="0.1 0 0"/></body></body></worldbody>'
        '<tendon><spatial name="s"><site site="o"/><site site="t"/></spatial>'
        '<fixed name="f"><joint joint="k" coef="2"/></fixed></tendon>'
        '<actuator><muscle tendon="s" force="9"/><muscle tendon="f" force="9"/></actuator></mujoco>'
    )
    spatial, fixed = (law_parameters(m.model) for m in read(tmp_path / "m.xml").require().muscles)
    ends = (spatial["length_low"], spatial["length_high"])
    assert ends == pytest.approx((0.2, 0.4), rel=1e-2)
    ends = (fixed["length_low"], fixed["length_high"])
    assert ends == pytest.approx((-2.0 * np.pi / 3.0, np.pi / 3.0))


def test_a_site_at_the_position_of_the_site_before_it_is_ignored(tmp_path: Path) -> None:
    file = tmp_path / "arm.xml"
    file.write_text(
        '<mujoco><worldbody><site name="a" pos="0.1 0 1.2"/><site name="b" pos="0.1 0 1.2"/>'
        '<body pos="0 0 1"><joint name="j" axis="0 1 0" range="-60 60"/>'
        '<geom type="capsule" fromto="0 0 0 0 0 -0.4" size="0.03"/>'
        '<site name="c" pos="0.02 0 -0.2"/></body></worldbody><tendon><spatial name="t">'
        '<site site="a"/><site site="b"/><site site="c"/></spatial></tendon>'
        '<actuator><motor tendon="t" ctrlrange="-20 0" gear="1"/></actuator></mujoco>'
    )
    reading = read(file)
    (muscle,) = reading.require().muscles
    assert len(muscle.via_points) == 2
    (finding,) = [f for f in reading.findings if f.code == "repeated-via-point"]
    assert "['b']" in finding.message


ONE_MUSCLE = (
    '<mujoco><worldbody><site name="a" pos="0 0 0.2"/><body pos="0 0 0.1">'
    '<joint type="slide" axis="0 0 1"/><geom type="sphere" size="0.01" mass="1"/><site name="b"/>'
    '</body></worldbody><tendon><spatial name="t" {}><site site="a"/><site site="b"/></spatial>'
    '</tendon><actuator><muscle name="m" tendon="t" {}/></actuator></mujoco>'
)


def test_range_of_the_tendon_replaces_missing_ranges_of_joints(tmp_path: Path) -> None:
    file = tmp_path / "m.xml"
    file.write_text(ONE_MUSCLE.format('limited="true" range="0.075 0.105"', ""))
    parameters = law_parameters(read(file).require().muscles[0].model)
    ends = [parameters["length_low"], parameters["length_high"]]
    assert ends == [0.075, 0.105]
    (simulated,) = mujoco.MjModel.from_xml_path(str(file)).actuator_lengthrange
    assert simulated == pytest.approx(ends, abs=1e-3)  # the limits of MuJoCo are soft
    file.write_text(ONE_MUSCLE.format("", ""))
    (error,) = [f for f in read(file).findings if f.is_error]
    assert "set lengthrange of the actuator" in error.message


def test_commands_of_a_muscle_are_limited_to_its_activation(tmp_path: Path) -> None:
    """MuJoCo computes the same activation for commands of -1 and 0."""
    file = tmp_path / "m.xml"
    text = ONE_MUSCLE.format("", 'lengthrange="0.1 0.2" ctrllimited="true" ctrlrange="-1 1"')
    file.write_text(text)
    parameters = law_parameters(read(file).require().muscles[0].model)
    assert (parameters["control_low"], parameters["control_high"]) == (0.0, 1.0)
    model = mujoco.MjModel.from_xml_path(str(file))
    rates = []
    for command in (-1.0, 0.0):
        data = mujoco.MjData(model)
        data.act[0], data.ctrl[0] = 0.5, command
        mujoco.mj_forward(model, data)
        rates.append(data.act_dot[0])
    assert rates[0] == rates[1] < 0.0
