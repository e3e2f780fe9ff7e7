"""`cardsflow calibrate`: calibration from recordings, and rejected recordings."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from support.command_line import CommandLine
from support.robots.recorded_arm import MARKERS, marker_positions, write_markers
from support.robots.robots import PLANAR_2R

from addin_sdfusion.robot import read_robot
from cardsflow_fmu import Experiment
from cardsflow_fmu.hardware.protocol.exchange import Exchange
from cardsflow_fmu.hardware.protocol.recording import Recorder, RecordingHeader
from cardsflow_fmu.results.report.calibration import calibrate_files
from cardsflow_fmu.results.report.readings import read_readings
from cardsflow_fmu.results.run_data import RunData
from cardsflow_fmu.simulation.run import simulate

ROBOT = PLANAR_2R / "robot"
OFFSETS = (2e-3, -1e-3, 3e-3, -2e-3)


@pytest.fixture(scope="module")
def result() -> RunData:
    settings = {"run.duration": 2.0}
    return simulate(Experiment.load(PLANAR_2R, settings), coupling="direct")


def table_of(result: RunData) -> tuple[list[str], np.ndarray]:
    """Return time, positions, lengths with offsets and noise, and forces, at 200 Hz."""
    names = [n for n in result.names if n == "time" or n.split(".")[0] in ("q", "l", "f")]
    rows = np.stack([result[name] for name in names], axis=1)[::5]
    rng = np.random.default_rng(1)
    for k, name in enumerate(names):
        if name[:2] in ("q.", "l."):
            rows[:, k] += 1e-4 * rng.normal(size=len(rows))
        if name[:2] == "l.":
            rows[:, k] += OFFSETS[int(name[-1]) - 1]
    return names, rows


def write_table(file: Path, names: list[str], rows: np.ndarray) -> Path:
    np.savetxt(file, rows, delimiter=",", header=",".join(names), comments="", fmt="%.17g")
    return file


def command(recording: Path, folder: Path) -> list[object]:
    free = "muscles.*.offset, joints.*.damping"
    return ["calibrate", recording, "--robot", ROBOT, "--parameters", free, "-o", folder]


def test_calibrated_robot_and_report_are_written(
    cardsflow: CommandLine, tmp_path: Path, result: RunData
) -> None:
    file = write_table(tmp_path / "run.csv", *table_of(result))
    code, out, _ = cardsflow(*command(file, tmp_path / "new"))
    assert code == 0, out
    assert "muscles.cable_1.offset" in out
    table = json.loads((tmp_path / "new" / "calibration.json").read_text())
    sds = {one["name"]: one["sd"] for one in table["parameters"]}
    for k, offset in enumerate(OFFSETS, 1):
        sd = sds[f"muscles.cable_{k}.offset"]
        assert sd < 1e-4
        assert abs(table["offsets"][f"cable_{k}"] - offset) < 4 * sd
    assert [m.name for m in read_robot(tmp_path / "new").muscles] == [
        m.name for m in read_robot(ROBOT).muscles
    ]
    assert "choose a new folder" in cardsflow.error_line(*command(file, tmp_path / "new"))


def test_calibration_reports_its_progress_to_python(tmp_path: Path, result: RunData) -> None:
    """The first call is without completed work; the last one is after all work."""
    file = write_table(tmp_path / "run.csv", *table_of(result))
    calls: list[tuple[int, int]] = []
    calibrate_files(
        [file],
        ROBOT,
        ["joints.*.damping"],
        tmp_path / "new",
        progress=lambda done, total: calls.append((done, total)),
    )
    done = [call[0] for call in calls]
    assert done[0] == 0
    assert done == sorted(done)
    assert all(work < total for work, total in calls[:-1])
    assert calls[-1][0] == calls[-1][1]


def test_recording_of_another_robot_is_reported_in_one_line_by_calibrate(
    cardsflow: CommandLine, tmp_path: Path, result: RunData, monkeypatch: pytest.MonkeyPatch
) -> None:
    """No file is written."""
    names, rows = table_of(result)
    blind = [k for k, name in enumerate(names) if not name.startswith("q.")]
    foreign = [name.replace("cable_4", "biceps") for name in names]
    late = rows.copy()
    late[50:, 0] -= 0.5
    uneven = rows.copy()
    uneven[:, 0] += np.arange(len(rows)) ** 2 * 1e-5
    huge = rows[:60].copy()
    huge[3, names.index("f.cable_2")] = 1e300
    cases = {
        "muscle lengths are not sufficient": ([names[k] for k in blind], rows[:, blind]),
        "is of another robot": (foreign, rows),
        "time decreases after row 50": (names, late),
        "requires times with equal steps": (names, uneven),
        "record for longer": (names, rows[:60]),
        "f.cable_2 is 1e+300 at 0.015 s": (names, huge),
    }
    for message, table in cases.items():
        file = write_table(tmp_path / "case.csv", *table)
        assert message in cardsflow.error_line(*command(file, tmp_path / "new"))
        assert not (tmp_path / "new").exists()
    assert cardsflow.error_line(*command(tmp_path / "none.csv", tmp_path / "new"))
    folder = tmp_path / "recorded"
    short = ["run", PLANAR_2R, "--coupling", "direct", "--set", "run.duration=0.3", "-o", folder]
    assert cardsflow(*short)[0] == 0
    monkeypatch.chdir(folder)
    assert "recorded: only " in cardsflow.error_line(*command(Path(), tmp_path / "new"))
    missing = ["calibrate", file, "--robot", ROBOT, "-o", tmp_path / "new"]
    assert "--parameters" in cardsflow.error_line(*missing)


def test_hardware_recording_is_calibrated(cardsflow: CommandLine, tmp_path: Path) -> None:
    """A state is at the end of the step of the next command; truncated recordings are rejected.

    Measured tensions act during the step that ends with the state.
    """
    robot = read_robot(ROBOT)
    forces, lengths, measured = (
        [f"{x}.cable_{k}" for k in range(1, 5)] for x in ["f", "l", "tension"]
    )
    q = ["q.joint_1", "q.joint_2"]
    file = tmp_path / "hardware.rec"
    for more in (measured, []):
        states = (*q, *lengths, *more)
        units = ("rad", "rad", *("m",) * 4, *("N",) * len(more))
        header = RecordingHeader(tuple(forces), ("N",) * 4, states, units, 1, 0.01)
        with Recorder(file, header) as recorder:
            for k in range(6):
                state = None if k == 2 else np.arange(float(len(states))) + k
                recorder.write(0.01 * k, np.full(4, 10.0 + k), Exchange(state, k, 0.0, 0.0, 0))
        readings = read_readings(file, robot)
        assert readings.step == pytest.approx(0.01)
        np.testing.assert_array_equal(readings.q[:, 0], [0.0, 1.0, np.nan, 3.0, 4.0])
        np.testing.assert_array_equal(readings.lengths[0], [2.0, 3.0, 4.0, 5.0])
        acting = [7.0, np.nan, 9.0, 10.0, 11.0] if more else [11.0, 12.0, 13.0, 14.0, 15.0]
        np.testing.assert_array_equal(readings.tensions[:, 0], acting)
    file.write_bytes(file.read_bytes()[:-7])
    assert "cut short" in cardsflow.error_line(*command(file, tmp_path / "new"))
    assert not (tmp_path / "new").exists()


def write_capture(file: Path, result: RunData) -> Path:
    """Write noisy markers at 100 Hz as motion capture does; hidden markers are empty."""
    rng, q = np.random.default_rng(3), result.columns(["q.joint_1", "q.joint_2"])[::10]
    seen = marker_positions(q) + 1e-4 * rng.normal(size=(len(q), 9))
    names = [f"{marker.name}.{axis}" for marker in MARKERS for axis in "xyz"]
    rows = [",".join(["time", *names])]
    for k, (time, row) in enumerate(zip(result["time"][::10], seen, strict=True)):
        cells = ["" if k % 40 < 3 and j < 3 else repr(float(x)) for j, x in enumerate(row)]
        rows.append(",".join([repr(float(time)), *cells]))
    file.write_text("\n".join(rows) + "\n")
    return file


@pytest.mark.slow
def test_markers_replace_encoders(cardsflow: CommandLine, tmp_path: Path, result: RunData) -> None:
    names, rows = table_of(result)
    kept = [k for k, name in enumerate(names) if not name.startswith("q.")]
    file = write_table(tmp_path / "run.csv", [names[k] for k in kept], rows[:, kept])
    markers = write_markers(tmp_path / "markers.toml")
    capture = write_capture(tmp_path / "seen.csv", result)
    words = [*command(file, tmp_path / "new"), "--markers", markers, "--capture", capture]
    code, out, _ = cardsflow(*words)
    assert code == 0, out
    assert "markers, mm" in out
    table = json.loads((tmp_path / "new" / "calibration.json").read_text())
    sds = {one["name"]: one["sd"] for one in table["parameters"]}
    for k, offset in enumerate(OFFSETS, 1):
        sd = sds[f"muscles.cable_{k}.offset"]
        assert sd < 2e-4
        assert abs(table["offsets"][f"cable_{k}"] - offset) < 4 * sd
    assert max(table["errors"]["kept_after"]["markers"]) < 2e-4


def test_invalid_markers_are_reported_in_one_line(
    cardsflow: CommandLine, tmp_path: Path, result: RunData
) -> None:
    file = write_table(tmp_path / "run.csv", *table_of(result))
    markers = write_markers(tmp_path / "markers.toml")
    capture = write_capture(tmp_path / "seen.csv", result)
    broken, far = tmp_path / "broken.toml", tmp_path / "far.csv"
    whole = markers.read_text()
    head, *rows = capture.read_text().splitlines()
    rows[7] = ",".join([*rows[7].split(",")[:-1], "-1e300"])
    far.write_text("\n".join([head, *rows]))
    (empty := tmp_path / "empty.csv").write_text(head)
    for more, content, message in (
        ([], whole, "run.csv: has no column 'elbow.x'"),
        (
            ["--capture", capture, "--capture", capture],
            whole,
            "must be given once per recording: 1 times, not 2",
        ),
        (["--capture", file], whole, "run.csv: has no column 'elbow.x'"),
        (["--capture", empty], whole, "empty.csv: has markers at only 0 times"),
        (["--capture", far], whole, "far.csv: tip.z is -1e+300 at 0.07 s"),
        (["--capture", capture], whole.replace("link_2", "hand"), "no link 'hand'"),
        (["--capture", capture], "[elbow]\nlink = 1\nposition = [0, 0, 0]", "elbow.link"),
        (["--capture", capture], "elbow = 3", "elbow"),
        (["--capture", capture], "", "has no markers"),
        (["--capture", tmp_path / "none.csv"], whole, "none.csv"),
    ):
        broken.write_text(content)
        words = [*command(file, tmp_path / "new"), "--markers", broken, *more]
        assert message in cardsflow.error_line(*words)
        assert not (tmp_path / "new").exists()
    assert "--markers" in cardsflow.error_line(
        *command(file, tmp_path / "new"), "--capture", capture
    )
