"""Experiments with a world: read, written, run, and rejected with file and key."""

from __future__ import annotations

import csv
import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.robots.robots import PLANAR_2R
from support.robots.worlds import write_box_mesh
from support.run_modes import RUN_MODES

from addin_sdfusion.robot import InputError, Pose
from cardsflow_fmu import Experiment, build, run
from cardsflow_fmu.experiment.writer import experiment_data
from cardsflow_fmu.models.plant import PlantModel
from cardsflow_fmu.results.analysis.drive_check import experiment_findings
from cardsflow_fmu.simulation.run import RunError, simulate
from sim_dart.scene import Box, Capsule, Cylinder, Ground, MeshShape, SceneObject, Sphere

SHORT = {"run.duration": 0.05}
BALL = {"name": "ball", "shape": "sphere", "radius": 0.05, "mass": 0.2, "position": [3, 0, 1]}


DIE = {"name": "die", "shape": "mesh", "mass": 0.2}


def load(world: dict[str, Any] | None = None, **settings: Any) -> Experiment:
    given = {} if world is None else {"world": world}
    return Experiment.load(PLANAR_2R, SHORT | given | settings)


def test_experiment_without_world_has_no_world_ports() -> None:
    """The ports are the same, and the packed experiment has no table [world]."""
    plain = load()
    assert plain.scene is None
    assert "world" not in experiment_data(plain)
    names = [port.name for port in PlantModel.table(plain)]
    assert not [n for n in names if n.startswith(("contact.", "object.")) or n.endswith(".tx")]


def test_empty_world_does_not_change_results() -> None:
    """Both runs use the engine that a world requires."""
    alone = load()
    in_dart = replace(alone, plant=alone.plant.copy_with(engine="dart"))
    plain = simulate(in_dart, coupling="direct")
    world = simulate(load({"friction": 0.5}), coupling="direct")
    assert world.names == plain.names
    columns = [k for k, name in enumerate(plain.names) if name != "solve_time"]
    np.testing.assert_array_equal(world.rows[:, columns], plain.rows[:, columns])


def test_every_key_is_read(tmp_path: Path) -> None:
    mesh = write_box_mesh(tmp_path)
    experiment = load(
        {
            "ground": {"height": -0.5, "friction": 0.3},
            "friction": 0.8,
            "restitution": 0.1,
            "friction_law": "cone",
            "links": "capsules",
            "capsule_radius": 0.03,
            "self_collision": True,
            "ignore": [["link_1", "ball"]],
            "contacts": ["link_2", "ball"],
            "objects": [
                BALL | {"velocity": [0, 0, 1], "angular_velocity": [0, 1, 0], "restitution": 0.5},
                {"name": "wall", "shape": "box", "size": [1, 1, 1], "position": [5, 0, 0]},
                {"name": "rod", "shape": "capsule", "radius": 0.1, "length": 0.2},
                {"name": "tin", "shape": "cylinder", "radius": 0.1, "length": 0.2},
                {"name": "die", "shape": "mesh", "file": str(mesh), "scale": 2.0, "friction": 0.9},
            ],
            "shapes": [{"link": "link_2", "shape": "box", "size": [0.1, 0.1, 0.1]}],
        }
    )
    scene = experiment.scene
    assert scene is not None
    assert scene.ground == Ground(-0.5, 0.3)
    ball, wall, rod, tin, die = scene.objects
    assert ball == SceneObject(
        "ball", Sphere(0.05), Pose((3, 0, 1)), 0.2, (0, 0, 1), (0, 1, 0), None, 0.5
    )
    assert wall.shape == Box((1, 1, 1))
    assert rod.shape == Capsule(0.1, 0.2)
    assert tin.shape == Cylinder(0.1, 0.2)
    assert die.shape == MeshShape(mesh, (2.0, 2.0, 2.0))
    assert die.friction == 0.9
    assert (scene.friction, scene.restitution, scene.friction_law) == (0.8, 0.1, "cone")
    assert (scene.links, scene.capsule_radius, scene.self_collision) == ("capsules", 0.03, True)
    assert scene.ignored == (("link_1", "ball"),)
    assert scene.reported == ("link_2", "ball")
    assert scene.link_shapes[0].link == "link_2"
    assert scene.mesh_folder == (PLANAR_2R / "robot").resolve()


def test_all_colliding_links_report_contacts_by_default() -> None:
    scene = load({"links": "capsules"}).scene
    assert scene is not None
    assert scene.reported == ("link_1", "link_2")


def test_experiment_with_a_world_is_read_back_unchanged(tmp_path: Path) -> None:
    mesh = write_box_mesh(tmp_path)
    first = load(
        {
            "ground": True,
            "links": "capsules",
            "objects": [BALL, DIE | {"file": str(mesh)}],
            "contacts": [],
        },
        **{"plant.wrenches": ["link_2"]},
    )
    (tmp_path / "experiment.json").write_text(json.dumps(experiment_data(first)))
    second = Experiment.load(tmp_path / "experiment.json")
    assert second.scene == first.scene
    assert second.plant == first.plant
    assert experiment_data(second) == experiment_data(first)


def test_contacts_objects_and_wrenches_are_ports_with_units() -> None:
    experiment = load(
        {"links": "capsules", "contacts": ["link_2"], "objects": [BALL]},
        **{"plant.wrenches": ["link_2"]},
    )
    ports = {p.name: p for p in PlantModel.table(experiment)}
    assert ports["contact.link_2.fz"].unit == "N"
    assert ports["object.ball.x"].unit == "m"
    assert ports["object.ball.qw"].unit == ""
    assert ports["w.link_2.fx"].causality == "input"
    assert ports["w.link_2.ty"].unit == "N.m"
    assert ports["contact.link_2.fz"].causality == ports["object.ball.qz"].causality == "output"


def falling_ball() -> dict[str, Any]:
    return {"ground": {"height": 0.5}, "objects": [BALL], "contacts": ["ball"]}


@pytest.mark.slow
def test_ball_comes_to_rest_next_to_the_arm() -> None:
    experiment = load(falling_ball(), **{"run.duration": 1.2})
    direct = simulate(experiment, coupling="direct")
    time = direct["time"]
    in_flight = time < 0.29  # 0.45 m take 0.303 s
    fall = 0.5 * 9.81 * time * (time + 1e-3)
    np.testing.assert_allclose(
        direct["object.ball.z"][in_flight], (1 - fall)[in_flight], atol=1e-12
    )
    # the penetration of the impact step decreases by 1 mm/s
    assert direct["object.ball.z"].min() > 0.55 - 3e-3
    assert direct["object.ball.z"][-1] == pytest.approx(0.55, abs=1e-3)
    assert direct["contact.ball.fz"][-1] == pytest.approx(0.2 * 9.81, rel=1e-3)
    assert direct["contact.ball.fz"][0] == 0.0
    assert direct["object.ball.qw"][-1] == pytest.approx(1.0)


@pytest.mark.slow
def test_world_and_its_meshes_are_packed_in_fmus(tmp_path: Path) -> None:
    mesh = write_box_mesh(tmp_path)
    die = DIE | {"file": str(mesh), "position": [4, 0, 0.8]}
    world = falling_ball() | {"objects": [BALL, die]}
    experiment = load(world, **{"run.duration": 0.4})
    expected = simulate(experiment, coupling="direct")
    folder = tmp_path / "elsewhere"
    files = build(experiment, folder)
    mesh.unlink()
    from fmpy import extract

    unpacked = Path(extract(str(files["plant"])))
    again = Experiment.from_resources(unpacked / "resources")
    assert again.scene is not None
    (copy,) = (t.shape for t in again.scene.objects if t.name == "die")
    assert isinstance(copy, MeshShape)
    assert copy.file.is_relative_to(unpacked)
    model = PlantModel(again)
    model.initialize()
    assert expected["object.die.z"][-1] < 0.8


def test_wrench_is_an_input_that_wiring_can_connect() -> None:
    settings = {"plant.wrenches": ["link_2"], "wiring.plant": {"w.link_2.ty": 5.0}}
    pushed, free = load(**settings), load(**{"plant.wrenches": ["link_2"]})
    moved = simulate(pushed, coupling="direct")["q.joint_2"]
    still = simulate(free, coupling="direct")["q.joint_2"]
    plain = simulate(load(), coupling="direct")["q.joint_2"]
    np.testing.assert_array_equal(still, plain)
    assert (moved - still)[5:].max() > 1e-6


def test_state_contains_the_objects() -> None:
    model = PlantModel(load(falling_ball()))
    model.initialize()
    for k in range(320):
        model.step(1e-3 * k, 1e-3)
    state, outputs = model.get_state(), model.outputs.copy()
    for k in range(50):
        model.step(0.32 + 1e-3 * k, 1e-3)
    later = model.outputs.copy()
    model.set_state(state)
    where = [k for k, p in enumerate(model.ports) if p.name.startswith("object.")]
    np.testing.assert_array_equal(model.values[where], outputs[np.array(where) - model.inputs.size])
    for k in range(50):
        model.step(0.32 + 1e-3 * k, 1e-3)
    np.testing.assert_array_equal(model.outputs, later)


@pytest.mark.slow
def test_too_fast_object_ends_the_run_with_time_and_names(tmp_path: Path) -> None:
    wall = {"name": "wall", "shape": "box", "size": [0.002, 1, 1], "position": [4, 0, 1]}
    world = {"objects": [BALL | {"velocity": [90, 0, 0]}, wall]}
    with pytest.raises(RunError, match=r"at t = 0.0\d+ s 'ball' could pass through 'wall'"):
        run(load(world), tmp_path)
    assert json.loads((tmp_path / "summary.json").read_text())["status"] == "incomplete"


# Several robots.


def two_arms(**changes: Any) -> dict[str, Any]:
    path = str(PLANAR_2R / "robot/planar_2r_bodies.xml")
    points = [
        {"time": 0.0, "q": [-0.5, 0.5, -0.5, 0.5]},
        {"time": 1.0, "q": [-0.4, 0.5, -0.5, 0.6]},
    ]
    return {
        "robots": [
            {"name": "left", "path": path},
            {"name": "right", "path": path, "position": [3.0, 0.0, 0.0]},
        ],
        "reference": {"spline": "quintic", "points": points},
        "controller": {"type": "joint_space", "kp": 2000.0, "kd": 90.0, "period": 0.001},
        "run": {"duration": 0.2},
    } | changes


def write_experiment(folder: Path, data: dict[str, Any]) -> Experiment:
    (folder / "experiment.json").write_text(json.dumps(data))
    return Experiment.load(folder / "experiment.json")


@pytest.mark.slow
def test_two_robots_in_one_plant_move_as_single_robots(tmp_path: Path) -> None:
    both = simulate(write_experiment(tmp_path, two_arms()))
    assert both.summary["infeasible_ticks"] == 0
    assert both.summary["tracking"]["max"] < 1e-4
    for side, rows in (("left", slice(0, 2)), ("right", slice(2, 4))):
        data = two_arms()
        points = [p | {"q": p["q"][rows]} for p in data["reference"]["points"]]
        alone = {"robot": {"path": data["robots"][0]["path"]}} | {
            k: v for k, v in data.items() if k != "robots"
        }
        alone["reference"] = {"spline": "quintic", "points": points}
        (tmp_path / side).mkdir()
        single = simulate(write_experiment(tmp_path / side, alone), coupling="direct")
        for joint in ("joint_1", "joint_2"):
            np.testing.assert_allclose(both[f"q.{side}_{joint}"], single[f"q.{joint}"], atol=1e-9)
        np.testing.assert_allclose(both[f"f.{side}_cable_1"], single["f.cable_1"], atol=1e-4)


@pytest.mark.slow
def test_robots_are_packed_in_fmus_and_read_back(tmp_path: Path) -> None:
    first = write_experiment(tmp_path, two_arms())
    (tmp_path / "again").mkdir()
    second = write_experiment(tmp_path / "again", experiment_data(first))
    assert second.robot == first.robot
    assert experiment_data(second) == experiment_data(first)
    direct, fmu = (simulate(first, **RUN_MODES[way]) for way in ("direct", "python"))
    names = [n for n in direct.names if n != "solve_time"]
    np.testing.assert_array_equal(fmu.columns(names), direct.columns(names))


@pytest.mark.slow
def test_two_robots_collide_in_a_world(tmp_path: Path) -> None:
    """The left arm moves to the position of the right arm, so that they touch."""
    data = two_arms(world={"links": "capsules", "capsule_radius": 0.05})
    data["robots"][1]["position"] = [1.2, 0.0, 0.0]
    data["reference"]["points"][1]["q"] = [0.3, 0.8, -0.5, 0.5]
    data["run"]["duration"] = 1.0
    result = simulate(write_experiment(tmp_path, data), coupling="direct")
    touched = max(np.abs(result[n]).max() for n in result.names if n.startswith("contact."))
    assert touched > 1.0


@pytest.mark.slow
def test_objects_of_an_sdf_world_are_added(tmp_path: Path) -> None:
    (tmp_path / "scene.world").write_text(
        "<sdf version='1.6'><world name='w'><model name='table'><static>1</static>"
        "<pose>3 0 0.4 0 0 0</pose><link name='l'><collision name='c'><geometry><box>"
        "<size>1 1 0.2</size></box></geometry></collision></link></model><model name='floor'>"
        "<static>1</static><link name='l'><collision name='c'><geometry><plane/></geometry>"
        "</collision></link></model></world></sdf>"
    )
    experiment = load({"sdf": str(tmp_path / "scene.world"), "objects": [BALL]})
    scene = experiment.scene
    assert scene is not None
    assert scene.ground == Ground(0.0)
    assert [t.name for t in scene.objects] == ["ball", "table"]
    settings = {"run.duration": 1.2}
    world = {"sdf": str(tmp_path / "scene.world"), "objects": [BALL], "ground": False}
    result = simulate(load(world, **settings), coupling="direct")
    assert result["object.ball.z"][-1] == pytest.approx(0.55, abs=1e-3)


def test_omitted_content_of_an_sdf_world_reaches_check_and_summary(tmp_path: Path) -> None:
    sdf = tmp_path / "scene.world"
    sdf.write_text(
        "<sdf version='1.6'><world name='w'>\n<include><uri>model://table</uri></include>\n"
        "<model name='cup'><link name='l'/></model></world></sdf>"
    )
    experiment = load({"sdf": str(sdf)})
    findings = [f for f in experiment_findings(experiment) if f.file == sdf]
    assert [(f.code, f.line) for f in findings] == [
        ("include-left-out", 2),
        ("moving-model-left-out", 3),
    ]
    warnings = simulate(experiment, coupling="direct").summary["warnings"]
    assert warnings[:2] == [f"{sdf}:{f.line}: {f.message}" for f in findings]


BAD_ROBOTS: dict[str, tuple[Callable[[dict[str, Any]], object], str]] = {
    "none": (lambda d: d.update(robots=[]), "must be a list of tables"),
    "no name": (lambda d: d["robots"][0].pop("name"), r"robots\[0\].name: missing"),
    "name": (lambda d: d["robots"][0].update(name="a b"), "must consist of letters"),
    "same name": (
        lambda d: d["robots"][1].update(name="left"),
        "two robots would have the name 'left'",
    ),
    "key": (lambda d: d["robots"][0].update(x=1), r"robots\[0\].x: no key 'x'"),
    "gravity": (lambda d: d["robots"][0].update(gravity=[0, 0, 0]), "different gravity"),
    "path": (lambda d: d["robots"][0].update(path="none"), "none"),
}


@pytest.mark.parametrize("case", BAD_ROBOTS)
def test_invalid_robots_are_rejected(case: str, tmp_path: Path) -> None:
    change, message = BAD_ROBOTS[case]
    data = two_arms()
    change(data)
    with pytest.raises(InputError, match=message):
        write_experiment(tmp_path, data)


def test_invalid_mesh_is_reported_when_the_plant_is_created(tmp_path: Path) -> None:
    (tmp_path / "bad.stl").write_bytes(b"nonsense")
    die = DIE | {"file": str(tmp_path / "bad.stl")}
    with pytest.raises(InputError, match=r"bad.stl: "):
        simulate(load({"objects": [die]}), coupling="direct")


@pytest.mark.slow
def test_results_have_columns_of_objects_and_contacts(tmp_path: Path) -> None:
    run(load(falling_ball()), tmp_path)
    with (tmp_path / "results.csv").open() as file:
        names = next(csv.reader(file))
    assert {"object.ball.z", "contact.ball.fz"} <= set(names)
