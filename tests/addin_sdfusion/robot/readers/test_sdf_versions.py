"""All versions and notations of SDF: poses, joints, muscles, and omitted features."""

from __future__ import annotations

import math

import pytest

from addin_sdfusion.robot import CableModel, Wrap, WrapSurface, read_robot
from addin_sdfusion.robot.formats.read import read
from addin_sdfusion.robot.model.pose import Pose
from addin_sdfusion.robot.model.rotations import compose, inverse, rotate, rotation

INERTIAL = (
    "<inertial>{pose}<mass>1</mass><inertia><ixx>0.3</ixx><iyy>0.4</iyy><izz>0.5</izz></inertia>"
    "</inertial>"
)
HINGE = '<joint name="elbow" type="{type}"><parent>base</parent><child>arm</child>{more}</joint>'
AXIS = "<axis><xyz>0 0 1</xyz>{more}</axis>"
PLAIN = AXIS.format(more="")
AXES = "<axis><xyz>1 0 0</xyz></axis><axis2><xyz>0 1 0</xyz></axis2>"
VERSIONS = [f"1.{minor}" for minor in range(4, 13)]


def link(name, pose="", more="", inertial=""):
    return f'<link name="{name}">{pose}{INERTIAL.format(pose=inertial)}{more}</link>'


def hinge(more=PLAIN, type_="revolute"):
    return HINGE.format(type=type_, more=more)


def write(folder, *parts, version="1.7", attributes="", beside=None):
    body = "\n".join(parts)
    model = f'<model name="robot"{attributes}>\n{body}\n</model>'
    (folder / "model.sdf").write_text(f'<sdf version="{version}">{model}</sdf>')
    if beside is not None:
        (folder / "cardsflow.xml").write_text(f"<cardsflow>\n{beside}\n</cardsflow>")
    return folder


def robot_with(folder, *parts, **options):
    return read_robot(write(folder, *parts, **options))


def found(folder, *parts, **options):
    return {finding.code for finding in read(write(folder, *parts, **options)).findings}


def arm_pose(robot):
    """Return the pose of the arm at q = 0."""
    elbow, base = robot.joint("elbow"), robot.joints[0].T_parent_joint
    return compose(base, compose(elbow.T_parent_joint, inverse(elbow.T_child_joint)))


def close(pose, position, rpy):
    assert pose.position == pytest.approx(position, abs=1e-12)
    assert pose.rpy == pytest.approx(rpy, abs=1e-12)


@pytest.mark.parametrize("version", VERSIONS)
def test_all_versions_are_read(tmp_path, version):
    reading = read(write(tmp_path, link("base"), link("arm"), hinge(), version=version))
    assert "sdf-version" not in {finding.code for finding in reading.findings}
    assert reading.require().joint("elbow").type == "revolute"


BASE = link("base", "<pose>0 0 1 0 0 0.5</pose>")
TURN = (0.1, -0.2, 0.3)
C, S = math.cos(0.5), math.sin(0.5)


def quaternion(roll, pitch, yaw):
    """Return the quaternion x, y, z, w times two, to test normalisation."""
    (cr, cp, cy), (sr, sp, sy) = (
        [f(angle / 2) for angle in (roll, pitch, yaw)] for f in (math.cos, math.sin)
    )
    return (
        2 * (sr * cp * cy - cr * sp * sy),
        2 * (cr * sp * cy + sr * cp * sy),
        2 * (cr * cp * sy - sr * sp * cy),
        2 * (cr * cp * cy + sr * sp * sy),
    )


POSES = [
    ('<pose degrees="true">1 2 3 {0} {1} {2}</pose>', [math.degrees(a) for a in TURN]),
    ('<pose rotation_format="euler_rpy">1 2 3 {0} {1} {2}</pose>', TURN),
    ('<pose rotation_format="quat_xyzw">1 2 3 {0} {1} {2} {3}</pose>', quaternion(*TURN)),
    ('<pose frame="">1 2 3 {0} {1} {2}</pose>', TURN),
    ('<pose relative_to="__model__">1 2 3 {0} {1} {2}</pose>', TURN),
]


@pytest.mark.parametrize(("text", "numbers"), POSES)
def test_rotation_can_be_written_in_several_notations(tmp_path, text, numbers):
    arm = link("arm", text.format(*map(repr, numbers)))
    close(arm_pose(robot_with(tmp_path, BASE, arm, hinge())), (1, 2, 3), TURN)


@pytest.mark.parametrize(
    ("pose", "frames"),
    [
        ('<pose relative_to="base">1 0 0 0 0 0</pose>', ""),
        ('<pose frame="base">1 0 0 0 0 0</pose>', ""),
        ('<pose relative_to="f">1 0 0 0 0 0</pose>', '<frame name="f" attached_to="base"/>'),
        (
            '<pose relative_to="g"/>',
            '<frame name="g" attached_to="f"><pose>1 0 0 0 0 0</pose></frame>'
            '<frame name="f" attached_to="base"/>',
        ),
    ],
)
def test_poses_are_composed_over_frames(tmp_path, pose, frames):
    robot = robot_with(tmp_path, BASE, frames, link("arm", pose), hinge())
    close(arm_pose(robot), (C, S, 1), (0, 0, 0.5))


def test_frame_can_be_inside_its_link(tmp_path):
    inside = '<frame name="f"><pose>1 0 0 0 0 0</pose></frame>'
    base = link("base", "<pose>0 0 1 0 0 0.5</pose>", inside)
    robot = robot_with(tmp_path, base, link("arm", '<pose frame="f"/>'), hinge(), version="1.5")
    close(arm_pose(robot), (C, S, 1), (0, 0, 0.5))


def test_joint_can_refer_to_frames_instead_of_links(tmp_path):
    frame = '<frame name="f" attached_to="arm"><pose>1 0 0 0 0 0</pose></frame>'
    joint = hinge().replace("<child>arm<", "<child>f<")
    robot = robot_with(tmp_path, BASE, link("arm"), frame, joint, version="1.8")
    assert robot.joint("elbow").child == "arm"
    close(robot.joint("elbow").T_child_joint, (1, 0, 0), (0, 0, 0))


def test_frames_attached_to_each_other_have_no_link(tmp_path):
    frames = '<frame name="f" attached_to="g"/><frame name="g" attached_to="f"/>'
    joint = hinge().replace("<child>arm<", "<child>f<")
    codes = found(tmp_path, BASE, link("arm"), frames, joint, version="1.8")
    assert {"pose-loop", "unknown-child"} <= codes


@pytest.mark.slow
def test_thousands_of_chained_frames_are_read_in_time(tmp_path):
    count = 10_000
    frames = [f'<frame name="f{k}" attached_to="f{k + 1}"/>' for k in range(count)]
    frames.append(f'<frame name="f{count}" attached_to="arm"/>')
    ends = "<parent>base</parent><child>f0</child>"
    joints = [f'<joint name="j{k}" type="fixed">{ends}</joint>' for k in range(count)]
    assert "loop-of-no-length" in found(tmp_path, BASE, link("arm"), *frames, *joints)


def test_model_pose_can_be_relative_to_a_frame_of_the_model(tmp_path):
    placed = "<pose>5 0 0 0 0 0</pose>"
    options = {"version": "1.8", "attributes": ' placement_frame="base"'}
    robot = robot_with(tmp_path, placed, BASE, link("arm"), hinge(), **options)
    close(robot.joints[0].T_parent_joint, (5, 0, 0), (0, 0, 0))


def test_inertial_can_be_rotated_or_relative_to_another_frame(tmp_path):
    quarter = f"<pose>1 2 3 0 0 {math.pi / 2!r}</pose>"
    robot = robot_with(tmp_path, link("base"), link("arm", inertial=quarter), hinge())
    assert robot.link("arm").inertia.ixx == pytest.approx(0.4)
    elsewhere = '<pose relative_to="base">1 0 0 0 0 0</pose>'
    robot = robot_with(tmp_path, BASE, link("arm", inertial=elsewhere), hinge())
    assert robot.link("arm").inertia.com == pytest.approx((C, S, 1))


@pytest.mark.parametrize("type_", ["universal", "revolute2"])
def test_two_axes_become_a_universal_joint(tmp_path, type_):
    robot = robot_with(tmp_path, link("base"), link("arm"), hinge(AXES, type_))
    joint = robot.joint("elbow")
    assert joint.type == "universal"
    assert [motion.axis for motion in joint.motions] == [(1, 0, 0), (0, 1, 0)]
    assert [c.name for c in joint.coordinates] == ["elbow_1", "elbow_2"]


def test_ball_joint_has_three_angles_and_continuous_joint_no_limits(tmp_path):
    robot = robot_with(tmp_path, link("base"), link("arm"), hinge("", "ball"))
    assert robot.joint("elbow").type == "ball"
    assert [c.name for c in robot.coordinates] == ["elbow_alpha", "elbow_beta", "elbow_gamma"]
    limited = AXIS.format(more="<limit><lower>-1</lower><upper>1</upper></limit>")
    robot = robot_with(tmp_path, link("base"), link("arm"), hinge(limited, "continuous"))
    assert robot.coordinates[0].upper == math.inf


def test_limits_of_zero_are_kept(tmp_path):
    zero = AXIS.format(more="<limit><lower>0</lower><upper>0</upper></limit>")
    assert "locked-by-limits" in found(tmp_path, link("base"), link("arm"), hinge(zero))
    assert "locked-by-limits" not in found(tmp_path, link("base"), link("arm"), hinge())


MESH = "<geometry><mesh><uri>{}</uri><scale>1e-3 1e-3 1e-3</scale></mesh></geometry>"
BOX = '<visual name="b"><geometry><box><size>1 1 1</size></box></geometry></visual>'


def test_meshes_are_kept_with_and_without_their_files(tmp_path):
    (tmp_path / "meshes").mkdir()
    (tmp_path / "meshes/here.stl").write_text("")
    uris = ["meshes/here.stl", f"model://{tmp_path.name}/meshes/here.stl"]
    looks = "".join(f'<visual name="v">{MESH.format(uri)}</visual>' for uri in uris)
    pose = "<pose>1 2 3 0 0 0</pose>"
    looks += f'<collision name="c">{pose}{MESH.format("model://x/there.stl")}</collision>'
    folder = write(tmp_path, link("arm", more=looks + BOX))
    reading = read(folder)
    first, _, last = reading.require().links[0].meshes
    assert (first.role, first.uri, first.scale) == ("visual", uris[0], (1e-3, 1e-3, 1e-3))
    assert (last.role, last.name, last.pose) == ("collision", "c", Pose((1, 2, 3)))
    reported = {finding.code: finding.message for finding in reading.findings}
    assert (
        "1 of 3 mesh files are not found, such as 'model://x/there.stl'"
        in reported["missing-meshes"]
    )
    assert "'box' is omitted" in reported["geometry-left-out"]


def test_springs_and_friction_of_a_joint_are_read(tmp_path):
    words = {"damping": 1, "friction": 2, "spring_stiffness": 3, "spring_reference": 4}
    dynamics = "".join(f"<{word}>{number}</{word}>" for word, number in words.items())
    axis = AXIS.format(more=f"<dynamics>{dynamics}</dynamics>")
    (c,) = read(write(tmp_path, link("base"), link("arm"), hinge(axis))).require().coordinates
    assert (c.damping, c.friction, c.stiffness, c.rest) == (1.0, 2.0, 3.0, 4.0)


@pytest.mark.parametrize(("effort", "bound"), [("3", 3.0), ("0", 0.0), ("-1", math.inf)])
def test_effort_of_a_joint_limits_its_motor(tmp_path, effort, bound):
    axis = AXIS.format(more=f"<limit><effort>{effort}</effort></limit>")
    reading = read(write(tmp_path, link("base"), link("arm"), hinge(axis)))
    (c,) = reading.require().coordinates
    assert (c.tau_min, c.tau_max, c.actuated) == (-bound, bound, False)
    assert "joint-not-simulated" not in {finding.code for finding in reading.findings}


def test_all_errors_of_the_tree_are_reported_at_once(tmp_path):
    def joint(name, parent, child):
        ends = f"<parent>{parent}</parent><child>{child}</child>"
        return f'<joint name="{name}" type="fixed">{ends}</joint>'

    joints = [joint("a", "base", "arm"), joint("b", "hand", "arm"), joint("c", "base", "nowhere")]
    joints += [joint("d", "nobody", "hand"), joint("e", "l2", "l1"), joint("f", "l1", "l2")]
    links = [link(name) for name in ("base", "arm", "hand", "l1", "l2", "base")]
    reading = read(write(tmp_path, *links, *joints))
    errors = {f.code: f for f in reading.findings if f.is_error}
    assert set(errors) == {"unknown-child", "unknown-parent", "closed-loop"}
    assert all(finding.line is not None for finding in errors.values())


def muscle(*points, more="", name="biceps"):
    blocks = "\n".join(
        f'<link name="{on}">\n<viaPoint {words}>{at}</viaPoint>\n</link>'
        for on, words, at in points
    )
    return f'<myoMuscle name="{name}">\n{blocks}{more}</myoMuscle>'


FIX = 'type="FIXPOINT"'
START, END = ("base", FIX, "1 0 0"), ("arm", FIX, "0 0 1")
TWO = (link("base"), link("arm"), hinge())
OLD = '<plugin filename="libmusc_plugin.so" name="musc_plugin">{}</plugin>'
NEW = '<plugin filename="libcardsflow_gazebo_plugin.so" name="cardsflow_gazebo_plugin">{}</plugin>'


@pytest.mark.parametrize("plugin", [OLD, NEW])
@pytest.mark.parametrize("name", ["motor12", "shoulder_left_motor0", "M. biceps"])
def test_muscles_are_read_from_any_plugin_name(tmp_path, plugin, name):
    robot = robot_with(tmp_path, *TWO, plugin.format(muscle(START, END, name=name)))
    assert [m.name for m in robot.muscles] == [name]


def test_cardsflow_xml_has_priority_over_plugin_with_a_warning(tmp_path):
    inside, beside = muscle(START, END, name="inside"), muscle(START, END, name="beside")
    reading = read(write(tmp_path, *TWO, OLD.format(inside), beside=beside))
    assert [m.name for m in reading.require().muscles] == ["beside"]
    assert "second-source-left-out" in {finding.code for finding in reading.findings}


MOTOR = (
    "<motor><bemf_constant>0.01</bemf_constant><torque_constant>0.02</torque_constant>"
    "<inductance>1e-4</inductance><resistance>0.7</resistance><inertiaMoment>4e-7</inertiaMoment>"
    "</motor><gear><ratio>53</ratio><efficiency>0.6</efficiency><inertiaMoment>1e-7</inertiaMoment>"
    "</gear><spindle><radius>0.005</radius></spindle>"
    "<SEE><stiffness>30000</stiffness><length>0.056</length></SEE>"
)


def test_motors_and_springs_of_muscles_become_series_elastic_motors(tmp_path):
    reading = read(write(tmp_path, *TWO, beside=muscle(START, END, more=MOTOR)))
    model = reading.require().muscles[0].model
    assert model.kind == "series_elastic_motor"
    assert dict(model.parameters) == {
        "back_emf_constant": 0.01,
        "torque_constant": 0.02,
        "inductance": 1e-4,
        "resistance": 0.7,
        "motor_inertia": 4e-7,
        "gear_ratio": 53.0,
        "gear_efficiency": 0.6,
        "gear_inertia": 1e-7,
        "spindle_radius": 0.005,
        "stiffness": 30000.0,
    }
    reported = {finding.code: finding.message for finding in reading.findings}
    assert "replace the default back_emf_constant, torque_constant" in reported["actuator-read"]
    assert "<length> of <SEE> is ignored" in reported["actuator-part-left-out"]


def test_cable_model_has_priority_over_original_motor_elements(tmp_path):
    model = '<cable_model kind="elastic_cable"><parameter name="stiffness">9</parameter>'
    more = f"{MOTOR}{model}</cable_model>"
    reading = read(write(tmp_path, *TWO, beside=muscle(START, END, more=more)))
    assert reading.require().muscles[0].model == CableModel("elastic_cable", (("stiffness", 9.0),))
    assert "actuator-left-out" in {finding.code for finding in reading.findings}


def test_parameters_of_a_motor_are_checked(tmp_path):
    for word, wrong, code in (
        ("0.7", "seven", "bad-number"),
        ("0.7", "-0.7", "bad-law-parameter"),
        ("0.7", "1 2", "bad-vector"),
    ):
        more = MOTOR.replace(f">{word}<", f">{wrong}<")
        assert code in found(tmp_path, *TWO, beside=muscle(START, END, more=more))


@pytest.mark.parametrize(
    ("words", "surface", "wrap"),
    [
        (
            'type="SPHERICAL" radius="0.02" state="0" revCounter="0"',
            WrapSurface("arm_sphere", "arm", "sphere", 0.02, Pose((0, 0, 2))),
            Wrap("arm_sphere", 0),
        ),
        (
            'type="CYLINDRICAL" radius="0.03" state="1" revCounter="2"',
            WrapSurface("arm_cylinder", "arm", "cylinder", 0.03, Pose((0, 0, 2))),
            Wrap("arm_cylinder", 0, 0, 2),
        ),
        (
            'type="CYLINDRICAL" radius="0.03" state="2" revCounter="0" side="-1"',
            WrapSurface("arm_cylinder", "arm", "cylinder", 0.03, Pose((0, 0, 2))),
            Wrap("arm_cylinder", 0, -1),
        ),
        (
            'type="CYLINDRICAL" radius="0.03" state="0" side="inside"',
            WrapSurface("arm_cylinder", "arm", "cylinder", 0.03, Pose((0, 0, 2))),
            Wrap("arm_cylinder", 0, inside=True),
        ),
    ],
)
def test_wrap_via_points_become_surfaces(tmp_path, words, surface, wrap):
    over = ("arm", words, "0 0 2")
    first = muscle(START, over, END)
    second = muscle(START, (*START[:2], "0 1 0"), over, END, name="triceps")
    reading = read(write(tmp_path, *TWO, beside=first + second))
    robot = reading.require()
    assert robot.wrap_surfaces == (surface,)
    assert [m.wraps[0].segment for m in robot.muscles] == [0, 1]
    assert robot.muscles[0].wraps == (wrap,)
    assert len(robot.muscles[0].via_points) == 2
    assert "wrap-state-left" not in {finding.code for finding in reading.findings}


def test_longer_wrap_path_requires_a_side(tmp_path):
    """The state of the original plugin selects the shorter or longer path, without an axis."""
    over = ("arm", 'type="CYLINDRICAL" radius="0.03" state="2"', "0 0 2")
    reading = read(write(tmp_path, *TWO, beside=muscle(START, over, END)))
    assert reading.require().muscles[0].wraps == (Wrap("arm_cylinder", 0),)
    assert "wrap-state-left" in {finding.code for finding in reading.findings}


SPHERE = 'type="SPHERICAL" radius="0.1" state="0"'


@pytest.mark.parametrize(
    ("points", "code"),
    [
        ([("base", SPHERE, "0 0 0"), START, END], "wrap-not-between-points"),
        ([START, END, ("base", SPHERE, "0 0 0")], "wrap-not-between-points"),
        (
            [START, ("base", SPHERE, "0 0 0"), ("arm", SPHERE, "0 0 0"), END],
            "wrap-not-between-points",
        ),
        ([START, ("base", SPHERE.replace("0.1", "x"), "0 0 0"), END], "bad-number"),
        ([START, ("base", SPHERE.replace('"0"', '"7"'), "0 0 0"), END], "bad-number"),
        ([START, ("base", 'type="MESH"', "0 0 0"), END], "unsupported-via-point"),
        ([START, ("leg", FIX, "0 0 0")], "unknown-via-link"),
        ([START], "too-few-via-points"),
        ([START, ("base", FIX, "0 0 0")], "no-moment-arm"),
    ],
)
def test_invalid_muscles_are_reported_with_their_lines(tmp_path, points, code):
    reading = read(write(tmp_path, *TWO, beside=muscle(*points)))
    findings = [finding for finding in reading.findings if finding.code == code]
    assert findings
    for finding in findings:
        assert (finding.file.name, finding.subject.name) == ("cardsflow.xml", "biceps")
        assert finding.line is not None


def test_link_name_in_other_case_is_found_if_unambiguous(tmp_path):
    beside = muscle(START, ("Arm", FIX, "0 0 1"))
    reading = read(write(tmp_path, *TWO, beside=beside))
    (finding,) = [f for f in reading.findings if f.code == "link-name-case"]
    assert (finding.severity, finding.file.name) == ("warning", "cardsflow.xml")
    assert finding.line is not None
    assert [p.link for p in reading.require().muscles[0].via_points] == ["base", "arm"]
    both = read(write(tmp_path, *TWO, link("ARM"), beside=beside))
    assert "unknown-via-link" in {finding.code for finding in both.findings}


def test_references_to_repeated_names_mean_the_first(tmp_path):
    again = muscle(START, ("arm", FIX, "0 0 1"))
    beside = muscle(START, END) + again + again + EFFECTOR + EFFECTOR
    fixed = hinge(type_="fixed").replace("arm", "hand")
    reading = read(write(tmp_path, *TWO, link("arm"), link("hand"), fixed, beside=beside))
    robot = reading.require()
    assert [m.name for m in robot.muscles] == ["biceps", "biceps_2", "biceps_3"]
    assert [f.name for f in robot.task_frames] == ["hand", "hand_2"]
    assert {link.name for link in robot.links} == {"base", "arm", "arm_2", "hand"}
    assert {joint.name for joint in robot.joints} >= {"elbow", "elbow_2"}
    twice = [f for f in reading.findings if f.code.startswith("duplicate")]
    codes = {"duplicate-link", "duplicate-joint", "duplicate-muscle", "duplicate-task-frame"}
    assert {finding.code for finding in twice} == codes
    assert all(finding.line is not None for finding in twice)


EFFECTOR = '<endEffector link="arm" name="hand">1 2 3</endEffector>'
MARKER = '<marker link="arm">4 5 6</marker>'


@pytest.mark.parametrize("beside", [True, False])
def test_end_effectors_and_markers_are_read_from_both_sources(tmp_path, beside):
    both = EFFECTOR + MARKER
    parts = TWO if beside else (*TWO, NEW.format(both))
    robot = robot_with(tmp_path, *parts, beside=both if beside else None)
    (hand,) = robot.task_frames
    assert (hand.name, hand.position) == ("hand", (1, 2, 3))
    (marker,) = robot.task_sets[1].frames
    assert (robot.task_sets[1].name, marker.name) == ("markers", "marker0")
    assert (marker.link, marker.position) == ("arm", (4, 5, 6))


CHAIN = '<joint name="whole"><coordinate name="a" joint="{0}" motion="0" actuated="true"/></joint>'


OF_MODELS = [
    ('<model name="inner"/>', "no-links", ""),
    ("<include><uri>model://x</uri></include>", "include-not-found", ""),
    ("<static>true</static>", "static-model", ""),
    (link("light", more="<gravity>0</gravity>"), "gravity-not-off", ""),
    (link("x").replace("<inertial>", '<inertial auto="true">'), "unsupported-inertial", ""),
    (link("x", '<pose rotation_format="quat_xyzw">0 0 0 0 0 0 0</pose>'), "bad-quaternion", ""),
    (NEW.format(CHAIN.format("nothing")), "unknown-joint", ""),
    (NEW.format(CHAIN.format("elbow").replace('motion="0"', 'motion="1"')), "bad-chain", ""),
    (NEW.format(CHAIN.format("elbow") * 2), "bad-chain", ""),
    (NEW.format('<joint name="whole"/>'), "bad-chain", ""),
]
OF_JOINTS = [
    (hinge(type_="screw"), "unsupported-joint", "joint type"),
    (hinge(type_="gearbox"), "unsupported-joint", "joint type"),
    (hinge(type_="spring"), "unsupported-joint", "joint type"),
    (
        hinge(AXIS.format(more="<limit><velocity>3</velocity></limit>")),
        "joint-not-simulated",
        "velocity limit",
    ),
    (hinge(AXIS.format(more='<mimic joint="x"/>')), "joint-not-simulated", "<mimic> is ignored"),
]
REPORTED = [(hinge() + text, code, message) for text, code, message in OF_MODELS] + OF_JOINTS


@pytest.mark.parametrize(("text", "code", "message"), REPORTED)
def test_rejected_and_omitted_features_are_reported_with_their_line(tmp_path, text, code, message):
    reading = read(write(tmp_path, link("base"), link("arm"), text))
    (finding,) = [finding for finding in reading.findings if finding.code == code]
    assert message in finding.message
    assert finding.line is not None
    if code == "unsupported-joint":
        assert finding.is_error


def test_coordinate_can_have_a_separate_name_and_motor(tmp_path):
    robot = robot_with(tmp_path, *TWO, NEW.format(CHAIN.format("elbow")))
    (coordinate,) = robot.coordinates
    assert (coordinate.name, coordinate.actuated) == ("a", True)


def test_axis_in_the_model_frame_of_old_versions_rotates_with_the_joint(tmp_path):
    more = "<use_parent_model_frame>true</use_parent_model_frame>"
    turned = link("arm", f"<pose>0 0 0 {' '.join(map(str, TURN))}</pose>")
    for version, text in (("1.6", more), ("1.4", "")):
        joint = hinge(AXIS.format(more=text))
        elbow = robot_with(tmp_path, BASE, turned, joint, version=version).joint("elbow")
        assert rotate(rotation(TURN), elbow.motions[0].axis) == pytest.approx((0, 0, 1))
