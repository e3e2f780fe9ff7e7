"""Initial view: the robot with its meshes and hulls, and labels on request."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.browser import Page
from support.recorded import sinusoidal_result
from support.robots.robots import EXAMPLES, planar_2r

from addin_sdfusion.robot import Muscle, Robot, ViaPoint, read_robot
from cardsflow_fmu.results.viewer import Motion, Stage, motion_of
from cardsflow_fmu.results.viewer.scene import shapes as s
from cardsflow_fmu.results.viewer.scene.act import Act
from cardsflow_fmu.results.viewer.scene.camera import motion_plane
from cardsflow_fmu.results.viewer.scene.link_bodies import platform_hull
from cardsflow_fmu.results.viewer.scene.shapes import Triangles
from cardsflow_fmu.results.viewer.view import write_page


def with_attachments(points: np.ndarray) -> Robot:
    """Return an arm with muscles from the world to points on its last link."""
    robot = planar_2r()
    link = robot.links[-1].name
    muscles = tuple(
        Muscle(f"m{i}", (ViaPoint("world", (0.0, 0.0, 1.0)), ViaPoint(link, tuple(p.tolist()))))
        for i, p in enumerate(points)
    )
    return robot.with_muscles(muscles)


def volume(hull: Triangles) -> float:
    """Return the volume by the divergence theorem; positive for outward faces."""
    a, b, c = (hull.vertices[hull.faces[:, i]] for i in range(3))
    return float(np.einsum("fi,fi->", a, np.cross(b, c))) / 6.0


BOX = np.array([[x, y, z] for x in (-0.3, 0.3) for y in (-0.2, 0.2) for z in (0.0, 0.1)])


def test_platform_is_drawn_as_hull_of_its_attachments() -> None:
    inside = np.array([[0.01, 0.02, 0.05]])
    robot = with_attachments(np.concatenate([BOX, inside]))
    hull = platform_hull(robot, robot.links[-1], 0.01)
    assert hull is not None
    assert volume(hull) == pytest.approx(0.6 * 0.4 * 0.1)
    assert len(hull.vertices) == 8
    assert platform_hull(robot, robot.links[0], 0.01) is None


def test_hull_of_coplanar_points_is_a_plate_and_of_collinear_points_none() -> None:
    flat = with_attachments(BOX[::2])
    hull = platform_hull(flat, flat.links[-1], 0.01)
    assert hull is not None
    assert volume(hull) == pytest.approx(0.6 * 0.4 * 0.01)
    for bone in (BOX * [1.0, 0.1, 0.1], BOX[:2], np.repeat(BOX[:1], 4, axis=0)):
        robot = with_attachments(bone)
        assert platform_hull(robot, robot.links[-1], 0.01) is None


def test_hull_is_drawn_for_links_without_a_mesh() -> None:
    robot = with_attachments(BOX)
    link = robot.links[-1].name
    motion = motion_of(robot, sinusoidal_result(robot, 0.2))

    def meshes(stage: Stage) -> list[str]:
        return [shape.name for shape in stage.scene(0) if isinstance(shape, s.MeshShape)]

    assert meshes(Stage(robot, motion)) == [f"links/{link}/hull"]
    own = {link: (Triangles(BOX, np.array([[0, 1, 2]])),)}
    assert meshes(Stage(robot, motion, own)) == [f"links/{link}/0"]


def arm_with_mast() -> tuple[Stage, np.ndarray]:
    """Return an arm with a mast as link mesh, and the corners of the mast in all frames."""
    robot = planar_2r()
    mast = np.array([[-0.02, -0.02, -9.0], [0.02, 0.02, -9.0], [0.0, 0.0, 4.0]])
    link = robot.links[0].name
    meshes = {link: (Triangles(mast, np.array([[0, 1, 2]])),)}
    stage = Stage(robot, motion_of(robot, sinusoidal_result(robot, 1.0)), meshes)
    placed = []
    for k in range(len(stage)):
        (T,) = (x.T for x in stage.scene(k) if isinstance(x, s.MeshShape))
        placed.append(mast @ T[:3, :3].T + T[:3, 3])
    return stage, np.concatenate(placed)


def test_box_contains_meshes_in_all_frames() -> None:
    stage, points = arm_with_mast()
    low, high = stage.box
    assert (points >= low - 1e-12).all()
    assert (points <= high + 1e-12).all()
    assert stage.reach > 13.0


def test_plane_of_planar_robots_is_found_and_of_others_not() -> None:
    planar = Stage(planar_2r(), Motion.still([0.3, 0.2]))
    np.testing.assert_allclose(np.abs(motion_plane(planar)), [0.0, 1.0, 0.0], atol=1e-12)
    arm = read_robot(EXAMPLES / "roboy_left_arm/robot")
    assert motion_plane(Stage(arm, Motion.still(np.zeros(4)))) is None


@pytest.mark.browser
def test_label_is_shown_near_the_pointer_or_on_request(page: Page, tmp_path: Path) -> None:
    robot = planar_2r()
    act = Act(Stage(robot, motion_of(robot, sinusoidal_result(robot, 1.0))), "waving")
    file = write_page([act], tmp_path / "page.html")
    page.open(file.as_uri(), offline=True)
    page.wait_for("document.body?.dataset.drawn !== undefined")
    shown = "[...document.querySelectorAll('.label')].filter(l => !l.hidden).length"
    assert page.evaluate(shown) == 0
    box = 'input[name="joint values"]'
    page.evaluate(f"document.querySelector('{box}').click()")
    page.wait_for(f"{shown} === 2")
    x, y = page.evaluate(
        "(r => [r.x + r.width / 2, r.y + r.height / 2])"
        "(document.querySelector('.label').getBoundingClientRect())"
    )
    page.evaluate(f"document.querySelector('{box}').click()")
    page.wait_for(f"{shown} === 0")
    page.send("Input.dispatchMouseEvent", type="mouseMoved", x=x + 15, y=y)
    page.wait_for(f"{shown} >= 1")
    assert not page.evaluate("document.querySelector('.label').hidden")
    page.send("Input.dispatchMouseEvent", type="mouseMoved", x=40, y=300)
    page.wait_for(f"{shown} === 0")
    assert page.errors == []


@pytest.mark.browser
@pytest.mark.parametrize("size", [(1000, 700), (420, 700)])
def test_page_shows_meshes_in_all_frames(page: Page, tmp_path: Path, size: tuple[int, int]) -> None:
    stage, points = arm_with_mast()
    file = write_page([Act(stage, "mast")], tmp_path / "page.html")
    page.resize(*size)
    page.open(file.as_uri(), offline=True)
    page.wait_for("document.body?.dataset.drawn !== undefined")
    places = np.array(
        page.evaluate(
            "unpack(document.getElementById('motion').textContent).then(motion => {"
            "const box = document.querySelector('.act');"
            "const aspect = box.clientWidth / box.clientHeight;"
            "const camera = new Camera(surroundings(motion.acts[0]), aspect);"
            f"return {points.tolist()}.map(p => project(camera.uniforms(aspect).view, p)); }})"
        )
    )
    assert places.min() > 0.0
    assert places.max() < 1.0
    assert np.ptp(places, axis=0).max() > 0.5  # and fills the view
