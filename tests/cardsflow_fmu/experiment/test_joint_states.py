"""Joint states of ROS 2 recordings as references: rosbag2, our recordings, and damaged files."""

from __future__ import annotations

import contextlib
import io
import sqlite3
import struct
from pathlib import Path

import numpy as np
import pytest
from support.command_line import CommandLine
from support.recorded import COUNT, joint_state, sinusoidal_result, write_bag
from support.robots.robots import PLANAR_2R, planar_2r

from addin_sdfusion.robot import InputError, limits
from cardsflow_fmu import Experiment
from cardsflow_fmu.cosim.signals.ports import coordinate_signals
from cardsflow_fmu.experiment import joint_states, recorded_messages
from cardsflow_fmu.experiment.joint_states import read_joint_states
from cardsflow_fmu.ros.recording import write_recording

pytestmark = pytest.mark.extra("ros2")

JOINTS = ("joint_1", "joint_2")


@pytest.mark.slow
@pytest.mark.parametrize("mcap", [True, False], ids=["mcap", "sqlite"])
def test_publisher_with_all_joints_is_used(mcap: bool, tmp_path: Path) -> None:
    """The order of the joints is arbitrary. The recording is a folder or a file."""
    arm = ("gripper", *reversed(JOINTS))
    folder = write_bag(
        tmp_path / "bag", ("/joint_states", ("gripper",)), ("/joint_states", arm), mcap=mcap
    )
    (inside,) = [file for file in folder.iterdir() if file.suffix != ".yaml"]
    for path in (folder, inside):
        found = read_joint_states(path, JOINTS)
        assert found.names == arm
        np.testing.assert_array_equal(found.time, np.arange(COUNT) / 1e3)
        np.testing.assert_array_equal(found.q, [joint_state(k, arm).position for k in range(COUNT)])
        np.testing.assert_array_equal(
            found.qd, [joint_state(k, arm).velocity for k in range(COUNT)]
        )
    settings = {"reference": {"file": str(folder)}, "controller.type": "joint_space"}
    points = Experiment.load(PLANAR_2R, settings).reference.curve.points  # type: ignore[union-attr]
    order = [arm.index(name) for name in JOINTS]
    np.testing.assert_array_equal([p.q for p in points], found.q[:, order])
    np.testing.assert_array_equal([p.qd for p in points], found.qd[:, order])  # type: ignore[index]


def test_recorded_run_as_reference_is_the_same_motion(
    tmp_path: Path, cardsflow: CommandLine
) -> None:
    robot = planar_2r()
    run = sinusoidal_result(robot, 0.5)
    recorded = write_recording(run, tmp_path / "run.mcap").file
    names = coordinate_signals("q", robot)
    code, out, _ = cardsflow("convert", recorded, "--to", tmp_path / "motion.csv")
    assert (code, out.strip()) == (0, str(tmp_path / "motion.csv"))
    columns = np.genfromtxt(tmp_path / "motion.csv", delimiter=",", names=True, deletechars="")
    np.testing.assert_array_equal([columns[n] for n in names], run.columns(names).T)
    assert "already" in cardsflow.error_line("convert", recorded, "--to", tmp_path / "motion.csv")


@pytest.mark.slow
def test_recording_of_another_robot_is_reported_in_one_line(
    tmp_path: Path, cardsflow: CommandLine
) -> None:
    other = write_bag(tmp_path / "other", ("/joint_states", ("wheel",)))
    two = write_bag(tmp_path / "two", ("/left", JOINTS), ("/right", JOINTS))
    (tmp_path / "no.mcap").write_bytes(b"no recording")
    (tmp_path / "none").mkdir()
    (tmp_path / "none/metadata.yaml").touch()
    none = write_bag(tmp_path / "empty", ("/joint_states", ()))
    for path, what in (
        (other, "no column q.joint_1"),
        (none, "no column q.joint_1"),
        (two, "/left, /right, but not in /joint_states"),
        (tmp_path / "no.mcap", "damaged"),
        (tmp_path / "missing.mcap", "missing.mcap"),
        (tmp_path / "none", "no files"),
    ):
        words = ("--set", f"reference={{file='{path}'}}", "--set", "controller.type=joint_space")
        assert what in cardsflow.error_line("run", PLANAR_2R, *words, "-o", tmp_path / "out")
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_truncated_recording_is_read_up_to_its_end(tmp_path: Path) -> None:
    whole = write_bag(tmp_path / "bag", ("/joint_states", JOINTS)) / "bag_0.mcap"
    file = next(whole.parent.glob("*.mcap"))
    run = sinusoidal_result(planar_2r(), 40.0)
    content = write_recording(run, tmp_path / "run.mcap").file.read_bytes()
    (tmp_path / "cut.mcap").write_bytes(content[: len(content) // 2])
    found = read_joint_states(tmp_path / "cut.mcap")
    assert 100 < len(found.time) < len(run.rows)
    np.testing.assert_array_equal(found.q, run.columns(["q.joint_1", "q.joint_2"])[: len(found.q)])
    assert len(read_joint_states(file).time) == COUNT


@pytest.mark.slow
def test_damaged_recordings_are_rejected_or_read(tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    for mcap in (True, False):
        folder = write_bag(tmp_path / f"bag{mcap}", ("/joint_states", JOINTS), mcap=mcap)
        (inside,) = [file for file in folder.iterdir() if file.suffix != ".yaml"]
        whole = np.frombuffer(inside.read_bytes(), np.uint8)
        damaged = tmp_path / f"damaged{inside.suffix}"
        for _ in range(60):
            content = whole.copy()
            where = rng.integers(len(content), size=rng.integers(1, 20))
            content[where] = rng.integers(256, size=len(where))
            damaged.write_bytes(content[: rng.integers(1, len(content) + 1)].tobytes())
            with contextlib.suppress(InputError):
                read_joint_states(damaged)


@pytest.mark.slow
@pytest.mark.parametrize("compression", ["zstd", "lz4"])
def test_chunk_that_unpacks_to_too_many_bytes_is_rejected(compression: str, tmp_path: Path) -> None:
    """The chunk specifies its true size, or a smaller one."""
    import lz4.frame
    import zstandard
    from mcap.data_stream import RecordBuilder
    from mcap.records import Chunk, Header

    content = bytes(400 * 2**20)
    packed = (zstandard if compression == "zstd" else lz4.frame).compress(content)
    for said in (len(content), 1000):
        builder = RecordBuilder()
        Header("ros2", "test").write(builder)
        Chunk(compression, packed, 0, 0, 0, said).write(builder)
        stream = io.BytesIO(b"\x89MCAP0\r\n" + builder.end())
        (tmp_path / "bomb.mcap").write_bytes(stream.getvalue() + struct.pack("<B", 0))
        with pytest.raises(InputError, match=r"larger than|differs from its declared size"):
            read_joint_states(tmp_path / "bomb.mcap")


@pytest.mark.parametrize(
    ("name", "most", "what"),
    [
        ("JOINT_STATES", 2 * COUNT - 1, "joint states"),
        ("ARRAYS", 130 * COUNT, "joint states"),
        ("RECORDS", 2 * COUNT, "messages"),
        ("RECORDING", 12_000, "larger than"),
    ],
)
def test_folder_with_too_much_data_is_rejected(
    name: str, most: int, what: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The limit applies to all files together."""
    folder = write_bag(tmp_path / "bag", ("/joint_states", JOINTS))
    (file,) = folder.glob("*.mcap")
    assert len(read_joint_states(folder).time) == COUNT
    (folder / "bag_1.mcap").write_bytes(file.read_bytes())
    assert len(read_joint_states(folder).time) == 2 * COUNT
    monkeypatch.setattr(limits, name, most)
    with pytest.raises(InputError, match=what):
        read_joint_states(folder)


def test_folder_with_many_publishers_is_rejected(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(joint_states, "_MAX_PUBLISHERS", 50)
    names = [(f"joint_{k}",) for k in range(17)]
    folder = write_bag(
        tmp_path / "bag", *(("/joint_states", each * k) for each in names for k in range(4))
    )
    with pytest.raises(InputError, match="more than 50 sets of joints"):
        read_joint_states(folder)


ENDLESS = (
    "WITH RECURSIVE k(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM k) "
    "SELECT 1 AS topic_id, i AS timestamp, zeroblob(100000) AS data FROM k"
)
LARGE = "data AS (zeroblob(1000000 + 0 * topic_id))"


@pytest.mark.parametrize(
    "messages", [f"VIEW messages AS {ENDLESS}", f"TABLE messages(topic_id, timestamp, {LARGE})"]
)
def test_sql_in_a_database_is_not_executed(messages: str, tmp_path: Path) -> None:
    with contextlib.closing(sqlite3.connect(tmp_path / "a.db3")) as database, database:
        database.execute("CREATE TABLE topics(id, name, type, serialization_format)")
        topic = (1, "/joint_states", "sensor_msgs/msg/JointState", "cdr")
        database.execute("INSERT INTO topics VALUES (?, ?, ?, ?)", topic)
        database.execute(f"CREATE {messages}")
        if "TABLE" in messages:
            database.executemany("INSERT INTO messages VALUES (?, ?)", [(1, k) for k in range(9)])
    with pytest.raises(InputError, match=r"only plain tables are read|computed"):
        read_joint_states(tmp_path / "a.db3")


@pytest.mark.parametrize("computed", ["hex(zeroblob(20000000))", "instr(zeroblob(9), 'a')"])
def test_virtual_table_does_not_hide_computed_columns(computed: str, tmp_path: Path) -> None:
    with contextlib.closing(sqlite3.connect(tmp_path / "a.db3")) as database, database:
        database.execute("CREATE TABLE topics(id, name, type, serialization_format)")
        topic = (1, "/joint_states", "sensor_msgs/msg/JointState", "cdr")
        database.execute("INSERT INTO topics VALUES (?, ?, ?, ?)", topic)
        database.execute(f"CREATE TABLE messages(topic_id, timestamp, data AS ({computed}))")
        database.execute("INSERT INTO messages VALUES (1, 1)")
        database.execute("CREATE VIRTUAL TABLE pragma_table_xinfo USING fts4(arg, hidden)")
    with pytest.raises(InputError, match="only plain tables are read"):
        read_joint_states(tmp_path / "a.db3")


def test_endless_query_is_stopped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Wrong statistics make SQLite scan all topics for each message."""
    monkeypatch.setattr(recorded_messages, "_ROUNDS", 3)
    with contextlib.closing(sqlite3.connect(tmp_path / "a.db3")) as database, database:
        database.execute("CREATE TABLE topics(id, name, type, serialization_format)")
        database.execute("CREATE TABLE messages(topic_id, timestamp, data)")
        topics = [(k, "/a", "sensor_msgs/msg/JointState", "cdr") for k in range(3000)]
        database.executemany("INSERT INTO topics VALUES (?, ?, ?, ?)", topics)
        database.executemany("INSERT INTO messages VALUES (?, 0, 'a')", [(-1,)] * 3000)
        database.execute("ANALYZE")
        database.execute("UPDATE sqlite_stat1 SET stat = '1'")
    with pytest.raises(InputError, match="interrupted"):
        read_joint_states(tmp_path / "a.db3")
