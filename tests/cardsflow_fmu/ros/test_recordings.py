"""Recordings, checked with independent readers: bytes, values and frames."""

from __future__ import annotations

import types as python_types
from collections import defaultdict
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from support.cases import sample_cases
from support.command_line import CommandLine
from support.recorded import sinusoidal_result, with_columns
from support.robots.every_joint import every_joint
from support.robots.random_robots import random_robot, random_tree
from support.robots.robots import PLANAR_2R, planar_2r

from addin_sdfusion.robot import WORLD, InputError, Pose, Robot
from cardsflow_fmu import Experiment, run
from cardsflow_fmu.cosim.signals.ports import coordinate_signals, motor_signals, muscle_signals
from cardsflow_fmu.hardware.protocol.recording import Recorder, RecordingHeader
from cardsflow_fmu.results.run_data import ExperimentRunData, RunData
from cardsflow_fmu.results.viewer.scene.colours import RAMP
from cardsflow_fmu.results.viewer.scene.link_poses import link_poses
from cardsflow_fmu.ros.recording import convert_run, write_recording
from cardsflow_fmu.ros.robot_frames import quaternion_values
from cardsflow_fmu.ros.topics import nanoseconds
from cardsflow_fmu.ros_interface.message_types import type_store
from sim_dart import MusclePaths
from sim_dart.core.frames import transform

pytestmark = pytest.mark.extra("ros2")

Messages = dict[str, list[tuple[int, Any]]]


def run_of(robot: Robot, folder: Path, seconds: float = 0.5) -> ExperimentRunData:
    """Return an artificial run with rates, lengths, ticks without forces, and other columns."""
    plain = sinusoidal_result(robot, seconds)
    rng = np.random.default_rng(5)
    names = coordinate_signals("qd", robot) + muscle_signals("l", robot)
    names += [*coordinate_signals("slack", robot), *motor_signals("tau", robot), "energy.kinetic"]
    more = {name: rng.normal(size=len(plain.rows)) for name in names}
    more["infeasible"] = (np.arange(len(plain.rows)) % 20 > 16).astype(float)
    more[names[0]][3] = np.nan
    run = with_columns(plain, more)
    about = python_types.SimpleNamespace(robot=robot, folder=folder, roots=(folder,), scene=None)
    known = vars(run) | {"units": dict.fromkeys(run.names, "unit")}
    return ExperimentRunData(**known, experiment=about)  # type: ignore[arg-type]


def messages_in(file: Path) -> Messages:
    """Return all messages by topic, read by rosbags with the message types in the file.

    Writing each message again must result in the same bytes.
    """
    from rosbags.rosbag2 import Reader
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    store, found = get_typestore(Stores.EMPTY), defaultdict(list)
    with Reader(file) as reader:
        for connection in reader.connections:
            store.register(get_types_from_msg(connection.msgdef.data, connection.msgtype))
        for connection, time, content in reader.messages():
            message = store.deserialize_cdr(content, connection.msgtype)
            assert bytes(store.serialize_cdr(message, connection.msgtype)) == bytes(content)
            found[connection.topic].append((time, message))
    return found


def column(messages: Messages, topic: str, field: str) -> np.ndarray:
    """Return a field of all messages of a topic."""
    return np.array([getattr(message, field) for _, message in messages[topic]])


ROBOTS = [
    planar_2r(),
    every_joint(),
    *sample_cases([random_tree(seed) for seed in range(3, 9)], 0),
    *sample_cases([random_robot(seed) for seed in range(4)], 0),
]


@pytest.mark.cases(3)
@pytest.mark.slow
@pytest.mark.parametrize("robot", ROBOTS, ids=lambda robot: robot.name)
def test_all_bytes_and_values_round_trip(robot: Robot, tmp_path: Path) -> None:
    run = run_of(robot, tmp_path)
    recorded = write_recording(run, tmp_path / "run.mcap")
    messages = messages_in(recorded.file)
    assert set(messages) <= set(recorded.topics)
    values = {
        ("/joint_states", "position"): coordinate_signals("q", robot),
        ("/joint_states", "velocity"): coordinate_signals("qd", robot),
        ("/tendon_states", "effort"): muscle_signals("f", robot),
        ("/tendon_states", "position"): muscle_signals("l", robot),
        ("/tendon_commands", "effort"): muscle_signals("f", robot),
    }
    if robot.motors:
        values["/joint_commands", "effort"] = motor_signals("tau", robot)
    for (topic, field), names in values.items():
        np.testing.assert_array_equal(column(messages, topic, field), run.columns(names))
    names = messages["/signals"][0][1].name
    assert names == [*coordinate_signals("slack", robot), "energy.kinetic", "infeasible"]
    np.testing.assert_array_equal(column(messages, "/signals", "value"), run.columns(names))
    times = [time for time, _ in messages["/joint_states"]]
    np.testing.assert_allclose(np.array(times) * 1e-9, run["time"], atol=1e-9, rtol=0.0)
    stamps = [m.header.stamp for _, m in messages["/joint_states"]]
    assert [s.sec * 10**9 + s.nanosec for s in stamps] == times
    levels = [m.status[0].level for _, m in messages["/diagnostics"] if "contr" in m.status[0].name]
    changes = np.count_nonzero(np.diff(run["infeasible"]))
    assert levels[:3] == [0, 2, 0]
    assert len(levels) == changes + 1


@pytest.mark.cases(3)
@pytest.mark.slow
@pytest.mark.parametrize("robot", ROBOTS, ids=lambda robot: robot.name)
def test_frames_agree_with_the_description(robot: Robot, tmp_path: Path) -> None:
    """/tf agrees with the URDF at the recorded joint states, and with the link poses."""
    run = run_of(robot, tmp_path)
    messages = messages_in(write_recording(run, tmp_path / "run.mcap").file)
    (_, description), *more = messages["/robot_description"]
    assert not more
    urdf = ElementTree.fromstring(description.data)
    q = dict(zip(coordinate_signals("q", robot), range(len(robot.coordinates)), strict=True))
    names = messages["/joint_states"][0][1].name
    assert names == [c.name for c in robot.coordinates]
    assert set(names) <= {joint.get("name") for joint in urdf.iter("joint")}
    by_time = dict(messages["/joint_states"])
    for time, frames in messages["/tf"][::7]:
        state = by_time[time]
        by_child = {t.child_frame_id: t for t in frames.transforms}
        assert {link.get("name") for link in urdf.iter("link")} == {WORLD, *by_child}
        values = dict(zip(state.name, state.position, strict=True))
        for joint in urdf.iter("joint"):
            moved = by_child[joint.find("child").get("link")]
            assert moved.header.frame_id == joint.find("parent").get("link")
            np.testing.assert_allclose(matrix(moved.transform), by_urdf(joint, values), atol=1e-9)
        poses = link_poses(robot, np.array([state.position]))
        for joint in robot.joints:
            T = poses[joint.child][0] @ transform(joint.T_child_joint)
            np.testing.assert_allclose(chain(by_child, joint.child), T, atol=1e-9)
    assert len(q) == len(names)


def by_urdf(joint: ElementTree.Element, values: dict[str, float]) -> np.ndarray:
    """Return the transform of a joint as defined by URDF."""
    origin = joint.find("origin")
    assert origin is not None
    T = np.eye(4)
    T[:3, 3] = [float(x) for x in origin.get("xyz", "").split()]
    T[:3, :3] = Rotation.from_euler(
        "xyz", [float(x) for x in origin.get("rpy", "").split()]
    ).as_matrix()
    axis = joint.find("axis")
    if axis is None:
        return T
    way = values[joint.get("name", "")] * np.array([float(x) for x in axis.get("xyz", "").split()])
    moved = np.eye(4)
    if joint.get("type") == "prismatic":
        moved[:3, 3] = way
    else:
        moved[:3, :3] = Rotation.from_rotvec(way).as_matrix()
    return T @ moved


def matrix(moved: Any) -> np.ndarray:
    """Return the matrix of a transform message."""
    T, r = np.eye(4), moved.rotation
    T[:3, 3] = [moved.translation.x, moved.translation.y, moved.translation.z]
    T[:3, :3] = Rotation.from_quat([r.x, r.y, r.z, r.w]).as_matrix()
    return T


def chain(by_child: dict[str, Any], link: str) -> np.ndarray:
    """Return T_world_link from the transforms of a message."""
    T = np.eye(4)
    while link != WORLD:
        T = matrix(by_child[link].transform) @ T
        link = by_child[link].header.frame_id
    return T


def test_a_run_that_diverged_is_recorded_without_a_warning(tmp_path: Path) -> None:
    run = run_of(planar_2r(), tmp_path)
    run.rows[3:, 1:] = 1e308
    run.rows[5:, 1:] = np.nan
    assert write_recording(run, tmp_path / "run.mcap").topics


def test_orientations_that_are_not_finite_are_nan() -> None:
    """Rows of a diverged run contain such poses."""
    R = np.stack([transform(turned_by(0.3))[:3, :3]] * 2)
    R[1, 0, 0] = np.nan
    quaternions = quaternion_values(R)
    assert quaternions["z"][0] == pytest.approx(np.sin(0.15), rel=1e-15)
    assert np.isnan([values[1] for values in quaternions.values()]).all()


def turned_by(angle: float) -> Pose:
    return Pose((1.0, 2.0, 3.0), (0.0, 0.0, angle))


@pytest.mark.slow
def test_efforts_and_rates_agree_with_the_muscle_jacobian(tmp_path: Path) -> None:
    """The expected values use the principle of virtual work and central differences for L."""
    robot = random_robot(3)
    run = run_of(robot, tmp_path)
    messages = messages_in(write_recording(run, tmp_path / "run.mcap").file)
    paths, k, h = MusclePaths(robot), 17, 1e-6
    q = run.columns(coordinate_signals("q", robot))[k]
    qd = run.columns(coordinate_signals("qd", robot))[k]
    f = run.columns(muscle_signals("f", robot))[k]
    steps = h * np.eye(len(q))
    lengths = [[paths.evaluate(q + s * e).lengths.copy() for s in (1, -1)] for e in steps]
    L = np.stack([(a - b) / (2 * h) for a, b in lengths], axis=1)
    np.testing.assert_allclose(column(messages, "/joint_states", "effort")[k], -L.T @ f, atol=1e-5)
    np.testing.assert_allclose(column(messages, "/tendon_states", "velocity")[k], L @ qd, atol=1e-7)


@pytest.mark.slow
def test_cables_contain_their_points_and_are_coloured_by_tension(tmp_path: Path) -> None:
    robot = planar_2r()
    run = run_of(robot, tmp_path)
    messages = messages_in(write_recording(run, tmp_path / "run.mcap").file)
    highest = max(run[name].max() for name in muscle_signals("f", robot))
    time, array = max(messages["/cables"], key=lambda row: row[0])
    row = int(np.argmin(np.abs(run["time"] - time * 1e-9)))
    poses = link_poses(robot, run.columns(coordinate_signals("q", robot))[row][np.newaxis])
    markers = [m for m in array.markers if m.ns == "cables"]
    for marker, muscle, name in zip(
        markers, robot.muscles, muscle_signals("f", robot), strict=True
    ):
        for point, via in zip(marker.points, muscle.via_points, strict=True):
            T = poses[via.link][0]
            place = T[:3, :3] @ via.position + T[:3, 3]
            np.testing.assert_allclose([point.x, point.y, point.z], place, atol=1e-12)
        assert marker.color.a == 1.0
        if run[name][row] == highest:
            colour = marker.color.r, marker.color.g, marker.color.b
            np.testing.assert_allclose(colour, np.divide(RAMP[-1], 255))
    lowest = min(
        zip(markers, muscle_signals("f", robot), strict=True), key=lambda m: run[m[1]][row]
    )
    assert lowest[0].color.b > lowest[0].color.r


@pytest.mark.slow
def test_the_file_contains_schemas_and_qualities_of_service(tmp_path: Path) -> None:
    """Read by the package mcap: schemas, qualities of service, hashes, meshes, checksums."""
    from mcap.reader import make_reader

    experiment = Experiment.load(Path(__file__).parents[3] / "examples/roboy_left_arm")
    known = vars(sinusoidal_result(experiment.robot, 0.2))
    run = ExperimentRunData(**known, experiment=experiment)
    recorded = write_recording(run, tmp_path / "run.mcap")
    with recorded.file.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        assert reader.get_header().profile == "ros2"
        summary = reader.get_summary()
        assert summary is not None
        count = sum(1 for _ in reader.iter_messages())
        attached = {a.name: a.data for a in reader.iter_attachments()}
    assert count == summary.statistics.message_count  # type: ignore[union-attr]
    for channel in summary.channels.values():
        schema = summary.schemas[channel.schema_id]
        assert schema.encoding == "ros2msg"
        assert channel.metadata["topic_type_hash"] == type_store().hash_rihs01(schema.name)
        latched = channel.topic in ("/robot_description", "/robot_bodies")
        assert ("transient_local" in channel.metadata["offered_qos_profiles"]) == latched
    urdf = messages_in(recorded.file)["/robot_description"][0][1].data
    for mesh in ElementTree.fromstring(urdf).iter("mesh"):
        package, _, name = mesh.get("filename", "").removeprefix("package://").partition("/")
        assert package == experiment.robot.name
        assert attached[name]


def test_results_without_a_robot_and_hardware_recordings_are_converted(
    tmp_path: Path, cardsflow: CommandLine
) -> None:
    header = RecordingHeader(("f.a",), ("N",), ("q.b", "l.a"), ("rad", "m"), 1, 1e-3)
    with Recorder(tmp_path / "hardware.rec", header) as recorder:
        for k in range(5):
            came = python_types.SimpleNamespace(
                state=None if k == 3 else np.array([0.1 * k, 0.5]),
                seq=k,
                age=0.0,
                round_trip=1e-4,
                device_flags=0,
            )
            recorder.write(1e-3 * k, np.array([10.0 + k]), came)  # type: ignore[arg-type]
    code, _, err = cardsflow("convert", tmp_path / "hardware.rec", "--to", tmp_path / "h.mcap")
    assert code == 0
    assert "the robot is unknown" in err
    messages = messages_in(tmp_path / "h.mcap")
    np.testing.assert_array_equal(
        column(messages, "/joint_states", "position")[:, 0], [0.0, 0.1, 0.2, np.nan, 0.4]
    )
    np.testing.assert_array_equal(
        column(messages, "/tendon_commands", "effort")[:, 0], 10.0 + np.arange(5)
    )
    assert messages["/joint_states"][0][1].name == ["b"]
    assert list(messages["/signals"][0][1].name) == ["age", "round_trip_time", "seq", "flags"]


@pytest.mark.slow
def test_a_run_writes_a_recording_if_requested(tmp_path: Path) -> None:
    settings = {"run.recording": "mcap", "run.duration": 0.05}
    result = run(Experiment.load(PLANAR_2R, settings), tmp_path / "out", coupling="direct")
    messages = messages_in(result.files["recording.mcap"])
    names = coordinate_signals("q", result.experiment.robot)
    np.testing.assert_array_equal(
        column(messages, "/joint_states", "position"), result.columns(names)
    )
    place = messages["/signals"][0][1].name.index("solve_time")
    times = column(messages, "/signals", "value")[:, place]
    np.testing.assert_array_equal(times[np.isfinite(times)], result.solve_times[:, 1])
    run(Experiment.load(PLANAR_2R, {"run.duration": 0.01}), tmp_path / "out", coupling="direct")
    assert not (tmp_path / "out/recording.mcap").exists()


def test_times_are_nanoseconds_and_are_clipped() -> None:
    times = nanoseconds(np.array([-1e-9, 1.5, 1e300, np.inf, -np.inf, np.nan]))
    assert times[:2].tolist() == [-1, 1_500_000_000]
    assert (np.abs(times[2:]) > 9.2e18).all()


def test_runs_without_rows_and_files_of_other_programs_are_rejected(tmp_path: Path) -> None:
    empty = RunData(("time", "q.a"), np.zeros((0, 2)), {}, {"status": "incomplete"})
    with pytest.raises(InputError, match="no rows"):
        write_recording(empty, tmp_path / "run.mcap")
    assert not list(tmp_path.iterdir())
    (tmp_path / "theirs.mcap").write_bytes(b"\x89MCAP0\r\n of somebody else")
    (tmp_path / "a.csv").write_text("time,q.a\n0,1\n1,2\n")
    with pytest.raises(InputError, match="not written by cardsflow"):
        convert_run(tmp_path / "a.csv", tmp_path / "theirs.mcap")


def test_the_error_without_the_extra_names_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, cardsflow: CommandLine
) -> None:
    import sys

    (tmp_path / "a.csv").write_text("time,q.a\n0,1\n1,2\n")
    monkeypatch.setitem(sys.modules, "mcap.writer", None)
    line = cardsflow.error_line("convert", tmp_path / "a.csv", "--to", tmp_path / "a.mcap")
    assert line.startswith("cardsflow: --to: recordings of ROS 2 need mcap: ")
    assert "ros2" in line
