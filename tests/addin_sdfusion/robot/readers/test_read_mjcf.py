"""MJCF: M, gravity, lengths and what MuJoCo finds when it compiles are MuJoCo's own."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
from support.models_of_others import INCLUDED, MJCF, OPTIONS
from support.oracles.moving_links import MovingLinks

from addin_sdfusion.robot import Robot
from addin_sdfusion.robot.model.tension_laws import law_parameters
from addin_sdfusion.robot.readers import read


def files(folder: Path) -> Path:
    (folder / "arm.xml").write_text(INCLUDED)
    (folder / "options.xml").write_text(OPTIONS)
    (folder / "model.xml").write_text(MJCF)
    return folder / "model.xml"


def test_what_is_simplified_or_lost_is_said(tmp_path: Path) -> None:
    reading = read(files(tmp_path))
    robot = reading.require()
    assert robot.gravity == (0.0, 1.0, -9.0)
    said = {finding.code: str(finding) for finding in reading.findings}
    assert "1 equalities of loops" in said["exact-equality"]
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
    spaced = INCLUDED.replace('0"axis', '0" axis')
    (tmp_path / "arm.xml").write_text(spaced)
    model = mujoco.MjModel.from_xml_path(str(file))
    (tmp_path / "arm.xml").write_text(INCLUDED)
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
        own = [values[name] for name in ("range_low", "range_high", "lmin", "lmax", "vmax", "fpmax",
                                         "fvmax")]  # fmt: skip
        assert own == [*actuator["gainprm"][:2], *actuator["gainprm"][4:9]]
        force, scale = actuator["gainprm"][2:4]
        force = force if force > 0.0 else scale / actuator["acc0"]
        assert values["force"] == pytest.approx(force, rel=1e-13)
        exact = robot.name != "tendon-muscle-finger"
        lengths = (values["length_low"], values["length_high"])
        assert lengths == pytest.approx(actuator["lengthrange"], rel=1e-15 if exact else 0.01)


def test_bodies_are_in_mujocos_order(tmp_path: Path) -> None:
    """The children of a body come before the next body: the keyframe's values are in that order."""

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


def test_files_are_included_from_beside_the_model_or_the_file_that_includes(tmp_path: Path) -> None:
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


COPIES = """<mujoco model="fan"><worldbody><body name="hub">
<joint name="turn" axis="0 0 1"/><geom size="0.1"/>
<replicate count="10" sep="-" offset="0.1 0 0.02" euler="0 5 20"><body name="blade" pos="0 0.2 0">
<joint name="fold" axis="1 0 0"/><geom size="0.02 0.1" type="capsule"/>
<replicate count="2" sep="_" offset="0 0.1 0"><site name="hole"/></replicate></body></replicate>
</body></worldbody></mujoco>"""


def test_what_is_replicated_is_where_mujoco_has_it(tmp_path: Path) -> None:
    (tmp_path / "fan.xml").write_text(COPIES)
    robot = read(tmp_path / "fan.xml").require()
    model = mujoco.MjModel.from_xml_string(COPIES)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    at = MovingLinks(robot, {c.name: 0.0 for c in robot.coordinates})
    assert [link.name for link in robot.links][:3] == ["hub", "blade-00", "blade-01"]
    for link in robot.links:
        np.testing.assert_allclose(
            at.poses[link.name][:3, 3], data.body(link.name).xpos, atol=1e-14
        )
    for frame in robot.task_sets[0].frames:
        place = at.poses[frame.link] @ [*frame.position, 1.0]
        np.testing.assert_allclose(place[:3], data.site(frame.name).xpos, atol=1e-14)
    assert len(robot.task_sets[0].frames) == model.nsite == 20
    (tmp_path / "fan.xml").write_text(COPIES.replace('"10"', '"9000"'))
    assert "too-many-copies" in {finding.code for finding in read(tmp_path / "fan.xml").findings}


@pytest.mark.parametrize("way", ["", "legacy", "exact", "convex"])
def test_a_mesh_is_filled_as_by_mujoco(tmp_path: Path, way: str) -> None:
    """One that is hollow and open, of which each way makes another body."""
    trimesh = pytest.importorskip("trimesh", reason="needs the extra viewer")
    ring = trimesh.creation.annulus(r_min=0.05, r_max=0.1, height=0.08, sections=12)
    ring.apply_translation([0.02, 0.01, 0.0])
    cut = trimesh.Trimesh(ring.vertices, ring.faces[:-3], process=False)
    (tmp_path / "ring.stl").write_bytes(cut.export(file_type="stl"))
    given = f'inertia="{way}"' if way else ""
    file = tmp_path / "elsewhere" / "m.xml"
    file.parent.mkdir()
    file.write_text(
        f'<mujoco><asset><mesh file="../ring.stl" scale="1 2 1" {given}/></asset><worldbody>'
        '<body name="b"><joint axis="1 2 3"/><geom type="mesh" mesh="ring" density="800"/></body>'
        "</worldbody></mujoco>"
    )
    robot = read(file).require()
    model = mujoco.MjModel.from_xml_path(str(file))
    inertia = robot.link("b").inertia
    assert inertia.mass == pytest.approx(model.body_mass[1], rel=1e-9)
    np.testing.assert_allclose(inertia.com, model.body_ipos[1], atol=1e-9)
    moments = np.linalg.eigvalsh(np.array(inertia.matrix))
    np.testing.assert_allclose(moments, np.sort(model.body_inertia[1]), rtol=1e-7)


def test_muscles_on_joints_and_of_joints_without_ends_have_lengths(tmp_path: Path) -> None:
    """Sums of angles may be negative; a hinge without ends goes round once."""
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


@pytest.mark.parametrize("kind", ["sphere", "capsule", "cylinder", "box"])
@pytest.mark.parametrize("given", ["", 'mass="3"', 'density="7"'])
def test_shells_weigh_what_they_do_in_mujoco(tmp_path: Path, kind: str, given: str) -> None:
    (tmp_path / "m.xml").write_text(
        f'<mujoco><worldbody><body name="b"><joint axis="1 2 3"/><geom type="{kind}" '
        f'size="0.1 0.2 0.3" shellinertia="true" {given}/></body></worldbody></mujoco>'
    )
    inertia = read(tmp_path / "m.xml").require().link("b").inertia
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "m.xml"))
    assert inertia.mass == pytest.approx(model.body_mass[1], rel=1e-12)
    moments = np.sort([inertia.ixx, inertia.iyy, inertia.izz])
    np.testing.assert_allclose(moments, np.sort(model.body_inertia[1]), rtol=1e-12)
