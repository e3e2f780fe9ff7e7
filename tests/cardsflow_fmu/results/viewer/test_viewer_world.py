"""Worlds in views: ground, fixed and moving objects, contacts."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from support.browser import Page
from support.experiments import twin_arms
from support.robots.robots import PLANAR_2R
from support.robots.worlds import write_box_mesh

from addin_sdfusion.robot import Pose, Shape
from cardsflow_fmu import Experiment, Result, run
from cardsflow_fmu.results.viewer.scene import shapes as s
from cardsflow_fmu.results.viewer.scene.act import Act
from cardsflow_fmu.results.viewer.scene.motion import Motion
from cardsflow_fmu.results.viewer.scene.solids import box_triangles, cylinder_triangles
from cardsflow_fmu.results.viewer.scene.stage import Stage
from cardsflow_fmu.results.viewer.view import act_of, acts_of, write_page

G = 9.81
PICTURES = True


@pytest.fixture(scope="module")
def falling(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Result]:
    """Run the planar arm with falling, spinning and resting objects."""
    folder = tmp_path_factory.mktemp("world")
    mesh = write_box_mesh(folder, (0.1, 0.2, 0.3))
    near = {"position": [1.5, 0.0, 1.0], "mass": 0.2}
    world = {
        "ground": {"height": -0.4},
        "objects": [
            {"name": "ball", "shape": "sphere", "radius": 0.05} | near,
            {
                "name": "top",
                "shape": "box",
                "size": [0.2, 0.2, 0.2],
                "angular_velocity": [0, 0, 2.0],
            }
            | {"mass": 0.2, "position": [1.5, 1.0, 3.0]},
            {"name": "rod", "shape": "capsule", "radius": 0.04, "length": 0.3}
            | {"position": [2.0, 0.0, 0.0], "rpy": [0.0, math.pi / 2, 0.0]},
            {"name": "tin", "shape": "cylinder", "radius": 0.04, "length": 0.3},
            {"name": "die", "shape": "mesh", "file": str(mesh), "scale": 2.0}
            | {"position": [1.0, 1.0, 1.0]},
            {"name": "lying", "shape": "sphere", "radius": 0.1, "mass": 1.0}
            | {"position": [-2.0, 0.0, -0.3]},
        ],
        "links": "none",
        "contacts": ["lying"],
    }
    experiment = Experiment.load(PLANAR_2R, {"run.duration": 0.4, "world": world})
    return folder / "out", run(experiment, folder / "out", coupling="direct")


@pytest.fixture(scope="module")
def act(falling: tuple[Path, Result]) -> Act:
    return acts_of([falling[0]])[0]


def at(act: Act, k: int) -> dict[str, Any]:
    return {shape.name: shape for shape in act.stage.scene(k)}


@pytest.mark.slow
def test_falling_objects_are_drawn_at_their_positions(act: Act) -> None:
    """Free fall: z = 1 - g t² / 2."""
    times = act.stage.motion.time
    heights = [at(act, k)["objects/ball"].centre[2] for k in range(len(times))]
    np.testing.assert_allclose(heights, 1.0 - 0.5 * G * times**2, atol=0.5 * G * 1e-3 * 0.4 + 1e-9)
    assert heights[-1] < 0.25
    assert at(act, 0)["objects/ball"].radius == 0.05


def test_spinning_box_is_drawn_rotated(act: Act) -> None:
    for k in (0, 5, 10):
        box = at(act, k)["objects/top"]
        angle = 2.0 * act.stage.motion.time[k]
        turned = [math.cos(angle), math.sin(angle), 0.0]
        np.testing.assert_allclose(box.T[:3, 0], turned, atol=1e-6)
        np.testing.assert_allclose(box.T[:3, 2], [0.0, 0.0, 1.0], atol=1e-6)
        size = np.ptp(box.triangles.vertices, axis=0)
        np.testing.assert_allclose(size, [0.2, 0.2, 0.2], atol=1e-12)


def test_objects_at_rest_are_drawn_at_their_poses(act: Act) -> None:
    for k in (0, 7):
        shapes = at(act, k)
        rod, tin, die = (shapes[f"objects/{name}"] for name in ("rod", "tin", "die"))
        np.testing.assert_allclose(rod.points, [[1.85, 0, 0], [2.15, 0, 0]], atol=1e-12)
        np.testing.assert_allclose(tin.points, [[0, 0, -0.15], [0, 0, 0.15]], atol=1e-12)
        assert isinstance(tin, s.Cylinder)
        np.testing.assert_allclose(die.points[0], [1.0, 1.0, 1.0])
        np.testing.assert_allclose(np.ptp(die.triangles.vertices, axis=0), [0.2, 0.4, 0.6])
        assert all(shape.group == s.OBJECTS for shape in (rod, tin, die))


def test_ground_is_drawn_below_objects(act: Act) -> None:
    ground = at(act, 3)["ground"]
    corners = ground.triangles.vertices @ ground.T[:3, :3].T + ground.T[:3, 3]
    np.testing.assert_allclose(corners[:, 2], -0.4, atol=1e-12)
    low, high = act.stage.box
    assert (corners[:, :2].min(axis=0) < low[:2]).all()
    assert (corners[:, :2].max(axis=0) > high[:2]).all()
    assert act.stage.floor == -0.4


def test_contact_forces_on_objects_equal_their_weight(act: Act) -> None:
    last = len(act.stage) - 1
    arrow = at(act, last)["contacts/lying"]
    pull = arrow.end - arrow.start
    np.testing.assert_allclose(pull / np.linalg.norm(pull), [0.0, 0.0, 1.0], atol=1e-6)
    np.testing.assert_allclose(arrow.end, at(act, last)["objects/lying"].centre, atol=1e-12)
    np.testing.assert_allclose(act.stage.motion.contacts["lying"][-1], [0, 0, G], atol=1e-3)


def test_all_frames_have_the_same_shapes(act: Act) -> None:
    names = [list(at(act, k)) for k in range(len(act.stage))]
    assert all(each == names[0] for each in names)


@pytest.mark.parametrize(
    ("surface", "volume"),
    [
        (box_triangles(np.array([0.1, 0.2, 0.3])), 0.2 * 0.4 * 0.6),
        # a prism with 24 sides
        (cylinder_triangles(0.1, 0.5), 12 * np.sin(np.pi / 12) * 0.1**2 * 0.5),
    ],
)
def test_solid_is_closed_with_outward_faces(surface: s.Triangles, volume: float) -> None:
    mesh = trimesh.Trimesh(surface.vertices, surface.faces, process=False)
    assert mesh.is_watertight
    assert mesh.volume == pytest.approx(volume)


def test_collision_shapes_of_links_without_mesh_are_drawn() -> None:
    tilted = Shape("cylinder", (0.05, 0.4), Pose((0.0, 0.0, 0.2), (np.pi / 2, 0.0, 0.0)))
    robot = Experiment.load(PLANAR_2R).robot
    links = tuple(replace(link, shapes=(tilted,)) for link in robot.links[:1])
    stage = Stage(replace(robot, links=(*links, *robot.links[1:])), Motion.still(np.zeros(2)))
    (drawn,) = (shape for shape in stage.scene(0) if isinstance(shape, s.MeshShape))
    size = np.ptp(drawn.triangles.vertices, axis=0)
    np.testing.assert_allclose(size, (0.1, 0.4, 0.1), rtol=1e-12)
    assert stage.reach > Stage(robot, Motion.still(np.zeros(2))).reach


def test_missing_mesh_is_drawn_as_small_sphere(tmp_path: Path) -> None:
    mesh = write_box_mesh(tmp_path)
    world = {"objects": [{"name": "die", "shape": "mesh", "file": str(mesh)}], "links": "none"}
    experiment = Experiment.load(PLANAR_2R, {"run.duration": 0.01, "world": world})
    result = run(experiment, tmp_path / "out", coupling="direct")
    mesh.unlink()
    drawn = {shape.name: shape for shape in act_of(result).stage.scene(0)}["objects/die"]
    assert isinstance(drawn, s.Sphere)
    shown = {shape.name: shape for shape in acts_of([tmp_path / "out"])[0].stage.scene(0)}
    assert isinstance(shown["objects/die"], s.MeshShape)  # the results contain the mesh


@pytest.mark.browser
def test_page_shows_and_hides_a_world(act: Act, page: Page, tmp_path: Path) -> None:
    file = write_page([act], tmp_path / "world.html")
    page.open(file.as_uri(), offline=True)
    page.wait_for("document.body?.dataset.drawn !== undefined")
    shown = page.screenshot()
    for name in ("objects", "ground", "contacts"):
        page.evaluate(f"document.querySelector('input[name=\"{name}\"]').click()")
        page.show_changes()
        hidden = page.screenshot()
        assert np.count_nonzero(np.abs(hidden - shown).max(axis=2) > 8) > 100, name
        shown = hidden
    assert page.errors == []
    assert page.requests == [file.as_uri()]


def test_all_robots_of_a_plant_are_drawn(tmp_path: Path) -> None:
    result = run(twin_arms(tmp_path, 5.0), tmp_path / "out", coupling="direct")
    shapes = {shape.name: shape for shape in act_of(result).stage.scene(0)}
    for part in ("links/{}_link_1/0", "muscles/{}_cable_1"):
        a, b = (shapes[part.format(name)].points for name in "ab")
        np.testing.assert_allclose(b - a, np.tile([5.0, 0.0, 0.0], (len(a), 1)), atol=1e-12)
