"""Scenes: rejected values, mass properties of bodies, and collision pairs."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
import trimesh
from support.robots.plants import steps
from support.robots.worlds import block, pincers, two_link_arm, write_box_mesh

from addin_sdfusion.robot import InputError, Pose, UnknownNameError
from addin_sdfusion.robot.mesh_files import mesh_file
from addin_sdfusion.robot.model.rotations import apply
from sim_dart import Plant
from sim_dart.dart.collision_pairs import connected_links
from sim_dart.dart.link_shapes import between, link_shapes
from sim_dart.dart.meshes import convex_hull, dart_mesh, load_mesh
from sim_dart.dart.shapes import solid_shape
from sim_dart.dart.skeleton_group import trees
from sim_dart.scene import (
    Box,
    Capsule,
    Cylinder,
    Ground,
    LinkShape,
    MeshShape,
    Scene,
    SceneObject,
    Sphere,
)

BALL = Sphere(0.1)
BAD = {
    "radius": (lambda: Sphere(0.0), "radius must be above 0, not 0.0"),
    "endless radius": (lambda: Sphere(math.inf), "radius must be at most"),
    "size": (lambda: Box((1.0, -1.0, 1.0)), "size must be above 0, not -1.0"),
    "length": (lambda: Capsule(0.1, math.nan), "length must be above 0"),
    "cylinder": (lambda: Cylinder(-0.1, 1.0), "radius"),
    "scale": (lambda: MeshShape(Path("a.stl"), (1.0, 0.0, 1.0)), "scale must be above 0"),
    "large": (lambda: Sphere(2e6), r"radius must be at most 1e\+06, not 2000000.0"),
    "height": (lambda: Ground(math.inf), r"height must be within 1e\+06 of 0, not inf"),
    "fast": (
        lambda: SceneObject("a", BALL, mass=1.0, angular_velocity=(0, 0, 2e6)),
        "angular_velocity must be within",
    ),
    "friction": (lambda: Ground(friction=-0.1), "friction must be 0 or above"),
    "restitution": (lambda: Scene(restitution=1.2), "within 0 and 1, not 1.2"),
    "mass": (lambda: SceneObject("a", BALL, mass=-1.0), "mass must be 0 or a positive number"),
    "still": (lambda: SceneObject("a", BALL, velocity=(1.0, 0.0, 0.0)), "a fixed body"),
    "place": (lambda: SceneObject("a", BALL, Pose((math.nan, 0, 0))), "position must be within"),
    "turn": (lambda: LinkShape("a", BALL, Pose(rpy=(math.inf, 0, 0))), "rpy must be finite"),
    "capsules": (lambda: Scene(capsule_radius=0.0), "capsule_radius must be above 0"),
}


@pytest.mark.parametrize("case", BAD)
def test_constructors_reject_invalid_values(case: str) -> None:
    make, message = BAD[case]
    with pytest.raises(InputError, match=message):
        make()


UNFIT = {
    "object twice": (
        Scene(objects=(SceneObject("a", BALL), SceneObject("a", BALL))),
        "the object name 'a' is already used",
    ),
    "ground twice": (
        Scene(objects=(SceneObject("ground", BALL),)),
        "the object name 'ground' is already used",
    ),
    "name of a link": (
        Scene(objects=(SceneObject("left", BALL),), link_shapes=(LinkShape("left", BALL),)),
        "name of a link",
    ),
    "no such link": (Scene(link_shapes=(LinkShape("lft", BALL),)), "did you mean 'left'"),
    "nothing to report": (Scene(reported=("left",)), "no link or object that collides 'left'"),
    "nothing to ignore": (Scene(Ground(), ignored=(("ground", "x"),)), "'x'"),
    "far ground": (Scene(Ground(-1e6)), r"'ground' is 1e\+06 m away at the start"),
    "more than all pairs of": (
        Scene(objects=tuple(SceneObject(f"o{k}", BALL) for k in range(500)), links="capsules"),
        r"50\d bodies can collide, more than the maximum of 500",
    ),
    "in each other": (
        Scene(objects=(SceneObject("a", BALL, mass=1.0), SceneObject("b", Box((1, 1, 1))))),
        r"overlap by 0\.\d+ m at the start",
    ),
}


@pytest.mark.parametrize("case", UNFIT)
def test_scene_that_does_not_match_the_robot_is_rejected(case: str) -> None:
    scene, message = UNFIT[case]
    with pytest.raises(InputError, match=message):
        Plant(pincers()[0], scene=scene)


def test_ignored_pairs_may_overlap() -> None:
    things = (SceneObject("a", BALL, mass=1.0), SceneObject("b", Box((1.0, 1.0, 1.0))))
    plant = Plant(block(), scene=Scene(objects=things, ignored=(("a", "b"),)))
    steps(plant, 100, [])
    fall = 0.5 * 9.81 * 1e-3**2 * 100 * 101
    assert plant.world.object_poses()[0, 2] == pytest.approx(-fall)


# Moments of inertia of solids of mass 1: textbook formulas.
r, h = 0.2, 0.5
INERTIAS = {
    "sphere": (Sphere(r), [0.4 * r**2] * 3),
    "box": (Box((0.1, 0.2, 0.4)), [(0.04 + 0.16) / 12, (0.01 + 0.16) / 12, (0.01 + 0.04) / 12]),
    "cylinder": (
        Cylinder(r, h),
        [(3 * r**2 + h**2) / 12, (3 * r**2 + h**2) / 12, r**2 / 2],
    ),
}


@pytest.mark.parametrize("kind", INERTIAS)
def test_moments_of_inertia_equal_textbook_formulas(kind: str) -> None:
    shape, moments = INERTIAS[kind]
    np.testing.assert_allclose(solid_shape(shape).gyration, np.diag(moments), rtol=1e-12)


def test_capsule_inertia_is_the_sum_of_its_parts() -> None:
    """Use the parallel-axis theorem for a cylinder and two half spheres."""
    cylinder, ball = r**2 * h, 4 / 3 * r**3
    m_c, m_b = cylinder / (cylinder + ball), ball / (cylinder + ball)
    along = m_c * r**2 / 2 + m_b * 0.4 * r**2
    across = m_c * (3 * r**2 + h**2) / 12 + m_b * (0.4 * r**2 + h**2 / 4 + 3 * h * r / 8)
    expected = np.diag([across, across, along])
    np.testing.assert_allclose(solid_shape(Capsule(r, h)).gyration, expected, rtol=1e-12)


def test_mass_properties_of_mesh_are_those_of_its_hull(tmp_path: Path) -> None:
    mesh = trimesh.creation.box((100.0, 200.0, 400.0))
    mesh.apply_translation((10.0, 20.0, 30.0))
    (tmp_path / "box.stl").write_bytes(trimesh.exchange.stl.export_stl(mesh))
    solid = solid_shape(MeshShape(tmp_path / "box.stl", (1e-3, 1e-3, 1e-3)))
    box = solid_shape(Box((0.1, 0.2, 0.4)))
    np.testing.assert_allclose(solid.com, [0.01, 0.02, 0.03], atol=1e-9)
    np.testing.assert_allclose(solid.gyration, box.gyration, atol=1e-9)
    np.testing.assert_allclose(solid.half, box.half, atol=1e-9)
    assert solid.thinnest == pytest.approx(0.05)


def test_dart_collides_with_the_hull_of_a_mesh(tmp_path: Path) -> None:
    hull = convex_hull(write_box_mesh(tmp_path, (0.1, 0.2, 0.4)))
    assert len(hull.faces) == 12
    bounds = dart_mesh(hull).getBoundingBox()
    np.testing.assert_allclose(bounds.computeFullExtents(), [0.1, 0.2, 0.4], rtol=1e-6)


def test_hull_closes_hollow_meshes(tmp_path: Path) -> None:
    ring = trimesh.creation.annulus(0.5, 1.0, 0.2)
    (tmp_path / "ring.stl").write_bytes(trimesh.exchange.stl.export_stl(ring))
    hull = convex_hull(tmp_path / "ring.stl")
    assert hull.is_convex
    assert hull.volume == pytest.approx(math.pi * 0.2, rel=0.02)


@pytest.mark.slow
def test_hulls_with_too_many_corners_are_not_computed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The hull of a box with the same number of points is computed."""
    ball, box = trimesh.creation.icosphere(6), trimesh.creation.box()
    for _ in range(6):
        box = box.subdivide()
    assert min(len(ball.vertices), len(box.vertices)) > 20_000
    for name, mesh in (("ball.stl", ball), ("box.stl", box)):
        (tmp_path / name).write_bytes(trimesh.exchange.stl.export_stl(mesh))
    assert convex_hull(tmp_path / "box.stl").volume == pytest.approx(1.0)
    monkeypatch.delattr(trimesh.Trimesh, "convex_hull")
    with pytest.raises(InputError, match=r"more than 2000 triangles; simplify"):
        convex_hull(tmp_path / "ball.stl")


BAD_MESHES = {
    "missing": (None, "none.stl: cannot be read: No such file"),
    "nonsense": (b"what is this", "line 1 has an unexpected keyword"),
    "empty": (b"", "no line begins with solid"),
    "flat": (
        trimesh.exchange.stl.export_stl(
            trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
        ),
        "its convex hull cannot be computed",
    ),
}


@pytest.mark.parametrize("case", BAD_MESHES)
def test_invalid_mesh_is_named(case: str, tmp_path: Path) -> None:
    data, message = BAD_MESHES[case]
    file = tmp_path / ("none.stl" if data is None else "bad.stl")
    if data is not None:
        file.write_bytes(data)
    with pytest.raises(InputError, match=message) as caught:
        convex_hull(file)
    assert str(file) in str(caught.value)


def test_unknown_mesh_format_is_named(tmp_path: Path) -> None:
    (tmp_path / "mesh.xyz123").write_bytes(b"1 2 3")
    with pytest.raises(InputError, match="cannot be used as a mesh"):
        load_mesh(tmp_path / "mesh.xyz123")


def test_uris_of_meshes(tmp_path: Path) -> None:
    robot = tmp_path / "arm"
    (robot / "meshes").mkdir(parents=True)
    (robot / "meshes/a.stl").write_bytes(b"")
    assert mesh_file("meshes/a.stl", robot) == robot / "meshes/a.stl"
    assert mesh_file("model://arm/meshes/a.stl", robot) == robot / "meshes/a.stl"
    assert mesh_file("model://other/meshes/a.stl", robot) == robot / "meshes/a.stl"  # renamed
    assert mesh_file("model://other/b.stl", robot) == tmp_path / "other/b.stl"
    assert mesh_file(f"file://{robot}/meshes/a.stl", None) == robot / "meshes/a.stl"


def test_capsules_run_from_joint_to_joint() -> None:
    robot = two_link_arm()
    shapes = link_shapes(robot, Scene(links="capsules", capsule_radius=0.03))
    assert [s.link for s in shapes] == ["link_1", "link_2"]
    for shape in shapes:
        assert isinstance(shape.shape, Capsule)
        assert shape.shape.length == pytest.approx(0.3)
        assert shape.pose.position == pytest.approx((0.0, 0.0, -0.15))


@pytest.mark.parametrize("end", [(1.0, 2.0, 3.0), (0.0, 0.0, -1.0), (-1.0, 0.0, 0.0), (0, 0, 2)])
def test_between_returns_pose_along_the_line(end: tuple[float, float, float]) -> None:
    begin = (0.1, 0.2, 0.3)
    half = 0.5 * math.dist(begin, end)
    pose = between(begin, end)
    assert apply(pose, (0.0, 0.0, half)) == pytest.approx(end)
    assert apply(pose, (0.0, 0.0, -half)) == pytest.approx(begin)


def test_links_connected_by_a_joint_do_not_collide() -> None:
    robot, _ = pincers()
    pairs = connected_links(robot)
    assert frozenset(("carriage", "left")) in pairs
    assert frozenset(("world", "carriage")) in pairs
    assert frozenset(("left", "right")) not in pairs
    assert frozenset(("world", "left")) not in pairs


def test_trees_keep_links_and_joints_in_order() -> None:
    robot = two_link_arm()
    (tree,) = trees(robot)
    assert tree.links == robot.links
    assert tree.joints == robot.joints
    assert not tree.muscles


def test_unknown_links_for_wrenches_are_named() -> None:
    with pytest.raises(UnknownNameError, match="did you mean 'link_2'"):
        Plant(two_link_arm(), wrenched=("link2",))
