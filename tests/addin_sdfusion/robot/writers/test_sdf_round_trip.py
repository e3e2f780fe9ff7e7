"""All features of a robot description are restored exactly from SDF."""

from __future__ import annotations

import math
import tempfile
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import dartpy
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.robots.every_joint import every_joint
from support.robots.loops import four_bar
from support.robots.random_robots import axes, names, poses, robots
from support.robots.writable import writable

from addin_sdfusion.robot import (
    WORLD,
    Joint,
    LimitForce,
    Mesh,
    Motion,
    Pose,
    RobotError,
    Wrap,
    WrapSurface,
    read_robot,
    sdf_losses,
    write_sdf,
)
from addin_sdfusion.robot.model.rotations import compose, inverse
from sim_dart import DartDynamics

scales = st.tuples(*[st.floats(1e-3, 2.0)] * 3)
meshes = st.builds(
    Mesh,
    st.sampled_from(["visual", "collision"]),
    st.sampled_from(["model://a/b c.stl", "meshes/ü.dae", "file:///x.stl"]),
    poses,
    scales,
    st.one_of(st.just(""), names),
)
radii = st.floats(1e-3, 1.0)


@st.composite
def compounds(draw):
    """Return joints with motions of any kind and order, and coordinates in any order."""
    count = draw(st.integers(2, 4))
    order = draw(st.permutations(range(count)))
    kinds = st.sampled_from(["rotation", "translation"])
    return tuple(Motion(draw(kinds), draw(axes), k) for k in order)


@st.composite
def with_everything(draw):
    """Return robots with meshes, wraps, motors and joints with several motions."""
    robot = draw(st.one_of(robots(), robots(caspr=True)))
    links = tuple(
        replace(link, meshes=tuple(draw(st.lists(meshes, max_size=3)))) for link in robot.links
    )
    joints = tuple(draw(changed(joint)) for joint in robot.joints)
    on = [WORLD, *(link.name for link in links)]
    surfaces = tuple(
        WrapSurface(
            name,
            draw(st.sampled_from(on)),
            draw(st.sampled_from(["sphere", "cylinder"])),
            draw(radii),
            draw(poses),
            draw(st.one_of(radii, st.just(math.inf))),
        )
        for name in draw(st.lists(names, max_size=3, unique=True))
    )
    robot = replace(robot, links=links, joints=joints, wrap_surfaces=surfaces)
    if robot.cable_set and surfaces:
        wrapped = [replace(m, wraps=draw(wraps(m, surfaces))) for m in robot.muscles]
        robot = robot.with_muscles(wrapped)
    return writable(robot)


@st.composite
def changed(draw, joint):
    """Return the joint, or a joint with several motions in its place, possibly with motors."""
    if draw(st.booleans()) or not joint.coordinates:
        return replace(joint, coordinates=tuple(draw(driven(c)) for c in joint.coordinates))
    motions = draw(compounds())
    units = {motion.coordinate: motion.unit for motion in motions}
    coordinates = tuple(
        replace(joint.coordinates[0], name=f"{joint.name} {k}", unit=units[k])
        for k in range(len(motions))
    )
    return replace(joint, motions=motions, coordinates=coordinates)


@st.composite
def driven(draw, coordinate):
    """Return the coordinate with or without a motor and symmetric or asymmetric limits."""
    bound = draw(st.one_of(st.floats(0.1, 100.0), st.just(math.inf)))
    least = draw(st.one_of(st.just(-bound), st.floats(-10.0, 0.0), st.just(-math.inf)))
    motor = draw(st.booleans())
    return replace(coordinate, actuated=motor, tau_min=least, tau_max=bound)


@st.composite
def wraps(draw, muscle, surfaces):
    wrap = st.builds(
        Wrap,
        st.sampled_from([surface.name for surface in surfaces]),
        st.integers(0, len(muscle.via_points) - 2),
        st.sampled_from([-1, 0, 1]),
        st.integers(0, 2),
    )
    return tuple(draw(st.lists(wrap, max_size=3)))


@pytest.mark.slow
@given(with_everything())
def test_robot_with_all_features_is_restored_exactly(robot):
    if any(finding.is_error for finding in sdf_losses(robot)):
        with tempfile.TemporaryDirectory() as folder, pytest.raises(RobotError, match="name"):
            write_sdf(robot, folder)
        return
    with tempfile.TemporaryDirectory() as folder:
        write_sdf(robot, folder)
        assert read_robot(folder) == robot
        write_sdf(robot, folder, plugin=False)
        assert "<plugin" not in (Path(folder) / "model.sdf").read_text()
        assert read_robot(folder) == robot


def test_robot_without_our_plugin_is_restored(tmp_path):
    """For Gazebo with other plugins; muscles and other features are in the cardsflow.xml."""
    robot = every_joint()
    write_sdf(robot, tmp_path, plugin=False)
    model = tmp_path / "model.sdf"
    theirs = '<plugin filename="gz-sim-joint-state-publisher-system" name="theirs"/></model>'
    model.write_text(model.read_text().replace("</model>", theirs))
    assert read_robot(tmp_path) == robot


def test_all_joints_are_restored(tmp_path):
    robot = every_joint()
    write_sdf(robot, tmp_path)
    assert read_robot(tmp_path) == robot
    types = {node.get("type") for node in joint_elements(tmp_path)}
    assert types == {"revolute", "prismatic", "universal"}


def joint_elements(folder):
    return ElementTree.parse(folder / "model.sdf").getroot().findall("model/joint")


@pytest.mark.parametrize("name", ["msj_platform", "musc-le", "roboy_upper_body", "test_robot"])
def test_published_robot_is_restored(shared, tmp_path, name):
    robot = read_robot(shared / "robots/cardsflow" / name)
    write_sdf(robot, tmp_path)
    assert read_robot(tmp_path) == robot
    assert (tmp_path / "cardsflow.xml").is_file()


def test_wraps_in_cardsflow_xml_have_the_original_format(shared, tmp_path):
    robot = read_robot(shared / "robots/cardsflow/musc-le")
    write_sdf(robot, tmp_path)
    root = ElementTree.parse(tmp_path / "cardsflow.xml").getroot()
    found = [node for node in root.iter("viaPoint") if node.get("type") == "SPHERICAL"]
    expected = {"radius": "0.02", "state": "0", "revCounter": "0"}
    for node in found:
        assert expected.items() <= node.attrib.items()
    assert len(found) == 2
    (tmp_path / "model.sdf").write_text(without_plugin(tmp_path / "model.sdf"))
    again = read_robot(tmp_path)
    assert again.muscles == robot.muscles
    assert again.wrap_surfaces == robot.wrap_surfaces


def without_plugin(file: Path) -> str:
    text = file.read_text()
    return text[: text.index("<plugin")] + text[text.index("</plugin>") + len("</plugin>") :]


def planar(**changes):
    robot = read_robot(Path(__file__).parents[4] / "examples/planar_2r/robot")
    return replace(robot, joints=(robot.joints[0], replace(robot.joints[1], **changes)))


def codes(robot):
    return {finding.code for finding in sdf_losses(robot)}


def test_losses_are_reported_before_writing(tmp_path):
    assert codes(planar()) == set()
    assert codes(planar(name="link_1")) == {"sdf-name-clash"}
    assert codes(planar(name="a::b")) == codes(planar(name="__a__")) == {"sdf-reserved-name"}
    limited = replace(planar().joints[1].coordinates[0], upper=2e16)
    assert codes(planar(coordinates=(limited,))) == {"sdf-limit"}
    shown = replace(planar().links[0], meshes=(Mesh("visual", " a.stl"),))
    assert codes(replace(planar(), links=(shown, planar().links[1]))) == {"sdf-mesh-text"}
    with pytest.raises(RobotError, match="rename 'link_1'"):
        write_sdf(planar(name="link_1"), tmp_path)
    assert list(tmp_path.iterdir()) == []
    assert codes(every_joint()) == {"joint-in-a-chain"}


def test_different_behaviour_in_other_programs_is_reported():
    assert codes(four_bar()) == {"loops-in-drake"}
    for change in ({"armature": 0.1}, {"limit_force": LimitForce(-1.0, 1.0, 9.0, 9.0)}):
        changed = replace(planar().joints[1].coordinates[0], **change)
        assert codes(planar(coordinates=(changed,))) == {"held-in-the-plugin"}


def old_sdf(robot, folder: Path) -> Path:
    """Return the written file as SDF 1.6, which DART reads, with all links placed in the model."""
    write_sdf(robot, folder)
    tree = ElementTree.parse(folder / "model.sdf")
    model = tree.getroot().find("model")
    tree.getroot().set("version", "1.6")
    poses_ = {"__model__": Pose()}
    relative = {}
    for node in model.findall("link") + model.findall("joint"):
        pose = node.find("pose")
        relative[node.get("name")] = (pose.attrib.pop("relative_to"), pose)
    for name in relative:
        place(name, relative, poses_)
    children = {node.get("name"): node.find("child").text for node in model.findall("joint")}
    for name, (_, pose) in relative.items():
        placed = poses_[name]
        if name in children:
            placed = compose(inverse(poses_[children[name]]), placed)
        pose.text = " ".join(map(repr, (*placed.position, *placed.rpy)))
    tree.write(folder / "old.sdf")
    return folder / "old.sdf"


def place(name, relative, done):
    if name not in done:
        outer, pose = relative[name]
        x, y, z, *rpy = map(float, pose.text.split())
        done[name] = compose(place(outer, relative, done), Pose((x, y, z), tuple(rpy)))
    return done[name]


def skeleton_of(file: Path):
    """Return the skeleton that DART's parser builds from a file."""
    parser = dartpy.utils.SdfParser
    options = parser.Options()
    options.mDefaultRootJointType = parser.RootJointType.FIXED
    return parser.readSkeleton(str(file.resolve()), options)


def test_dart_reads_the_same_robot(tmp_path):
    robot = every_joint()
    skeleton = skeleton_of(old_sdf(robot, tmp_path))
    ours = DartDynamics(robot)
    order = motion_order(robot.joints)
    assert skeleton.getNumDofs() == len(order)
    q = np.random.default_rng(0).uniform(-0.5, 0.5, len(order))
    skeleton.setPositions(q[order])
    theirs = np.zeros((len(order), len(order)))
    theirs[np.ix_(order, order)] = skeleton.getMassMatrix()
    # DART assigns 1e-9 kg to massless links.
    np.testing.assert_allclose(theirs, ours.mass_matrix(q), rtol=1e-7, atol=1e-7)


def motion_order(joints: tuple[Joint, ...]) -> list[int]:
    """Return the index in q of the coordinate of each motion of a chain, from world to tip."""
    order, first = [], 0
    for joint in joints:
        order += [first + motion.coordinate for motion in joint.motions]
        first += len(joint.motions)
    return order


@pytest.mark.parametrize("name", ["msj_platform", "test_robot", "exosuit", "VRpuppet", "musc-le"])
def test_dart_reads_a_published_robot_equally(shared, tmp_path, name):
    folder = shared / "robots/cardsflow" / name
    (tmp_path / "model.sdf").write_bytes((folder / "model.sdf").read_bytes())
    robot = read_robot(tmp_path)
    skeleton = skeleton_of(tmp_path / "model.sdf")
    q = np.random.default_rng(1).uniform(-0.5, 0.5, len(robot.coordinates))
    for coordinate, value in zip(robot.coordinates, q, strict=True):
        skeleton.getDof(coordinate.name).setPosition(value)
    names = [skeleton.getDof(i).getName() for i in range(skeleton.getNumDofs())]
    at = [names.index(coordinate.name) for coordinate in robot.coordinates]
    theirs = skeleton.getMassMatrix()[np.ix_(at, at)]
    np.testing.assert_allclose(theirs, DartDynamics(robot).mass_matrix(q), rtol=1e-9, atol=1e-9)
