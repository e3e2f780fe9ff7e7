from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
from support.robots.robots import EXAMPLES, PLANAR_2R
from support.run_modes import RUN_MODES

from addin_sdfusion.robot import InputError
from cardsflow_fmu import Experiment
from cardsflow_fmu.simulation.run import simulate
from controllers import SplineReference

T = np.arange(0.0, 2.0, 0.02)
Q = np.stack([0.3 * np.sin(2 * T) ** 2, -0.2 + 0.2 * np.cos(T)], axis=1)


def reference_positions(
    settings: dict[str, object], start: dict[str, object] | None = None
) -> np.ndarray:
    """Return the joint positions of the reference of the planar arm at the times of the samples."""
    experiment = Experiment.load(PLANAR_2R, {"reference": settings, **(start or {})})
    reference = SplineReference(experiment.reference.curve)  # type: ignore[arg-type]
    assert reference.duration == pytest.approx(T[-1])
    return reference.evaluate(T).q


def write_csv(file: Path, header: str, rows: np.ndarray, delimiter: str = ",") -> Path:
    np.savetxt(file, rows, delimiter=delimiter, header=header, comments="", fmt="%.17g")
    return file


@pytest.mark.parametrize(
    ("header", "rows", "delimiter"),
    [
        ("time,q.joint_1,q.joint_2", [T, Q[:, 0], Q[:, 1]], ","),
        ("time;joint_2;joint_1;remark", [T, Q[:, 1], Q[:, 0], 0 * T], ";"),
        ("joint_1 [deg]\ttime [ms]\tjoint_2 [deg]", [*np.degrees(Q[:, :1].T), 1e3 * T], "\t"),
        ("time,joint_1,joint_2", [T + 17.5, Q[:, 0], Q[:, 1]], ","),
    ],
)
def test_columns_of_a_csv_are_read_by_name(
    tmp_path: Path, header: str, rows: list[np.ndarray], delimiter: str
) -> None:
    if len(rows) < 3:
        rows = [*rows, np.degrees(Q[:, 1])]
    file = write_csv(tmp_path / "motion.csv", header, np.stack(rows, axis=1), delimiter)
    np.testing.assert_allclose(reference_positions({"file": str(file)}), Q, atol=1e-7)


@pytest.mark.slow
def test_results_table_is_a_reference_for_another_run(tmp_path: Path) -> None:
    settings = {"run.duration": 0.5, "run.output": str(tmp_path / "first")}
    first = simulate(Experiment.load(PLANAR_2R, settings), coupling="direct")
    file = write_csv(
        tmp_path / "results.csv",
        ",".join(first.names),
        np.stack([first[name] for name in first.names], axis=1),
    )
    again = simulate(
        Experiment.load(PLANAR_2R, {"reference": {"file": str(file)}, "run.duration": 0.5}),
        coupling="direct",
    )
    np.testing.assert_allclose(again["q.joint_1"], first["q.joint_1"], atol=1e-4)


def test_numpy_arrays_are_read(tmp_path: Path) -> None:
    rows = np.c_[T, Q]
    named = np.zeros(len(T), dtype=[("joint_2", float), ("time", float), ("joint_1", float)])
    named["time"], named["joint_1"], named["joint_2"] = rows.T
    np.save(tmp_path / "rows.npy", rows)
    np.save(tmp_path / "named.npy", named)
    np.savez(tmp_path / "groups.npz", time=T, q=Q)
    np.savez(tmp_path / "columns.npz", **{"time": T, "joint_1": Q[:, 0], "q.joint_2": Q[:, 1]})
    for name in ("rows.npy", "named.npy", "groups.npz", "columns.npz"):
        np.testing.assert_allclose(
            reference_positions({"file": str(tmp_path / name)}), Q, atol=1e-7
        )
    for samples in (rows, named, rows.tolist()):
        np.testing.assert_allclose(reference_positions({"samples": samples}), Q, atol=1e-7)


def test_existing_velocities_and_accelerations_are_used() -> None:
    qd, qdd = np.gradient(Q, T, axis=0), 3.0 + 0.0 * Q
    experiment = Experiment.load(PLANAR_2R, {"reference": {"samples": np.c_[T, Q, qd, qdd]}})
    point = SplineReference(experiment.reference.curve).evaluate(float(T[7]))  # type: ignore[arg-type]
    np.testing.assert_allclose(point.qd, qd[7], atol=1e-12)
    np.testing.assert_allclose(point.qdd, 3.0)


def test_task_coordinates_are_tracked_in_operational_space(tmp_path: Path) -> None:
    rows = np.stack([T, 0.5 + 0.05 * np.sin(T), -0.4 + 0.0 * T, 0.7 + 0.05 * np.cos(T)], axis=1)
    arm = EXAMPLES / "roboy_left_arm"
    file = write_csv(tmp_path / "hand.csv", "time,y.hand.x,hand.y,hand.z", rows)
    experiment = Experiment.load(arm, {"reference": {"file": str(file)}})
    assert experiment.reference.space == "operational"


@pytest.mark.slow
def test_setting_is_packed_in_fmus_and_runs_in_c() -> None:
    experiment = Experiment.load(
        PLANAR_2R, {"reference": {"samples": np.c_[T, Q]}, "run.duration": 0.2}
    )
    direct, fmus = (simulate(experiment, **RUN_MODES[way]) for way in ("direct", "python"))
    np.testing.assert_array_equal(direct["q.joint_1"], fmus["q.joint_1"])


def test_run_lasts_until_the_first_step_after_the_recording() -> None:
    odd = np.c_[T * 0.9973, Q]
    example = EXAMPLES / "recorded_motion"
    experiment = Experiment.load(example, {"reference": {"samples": odd}})
    assert 0.0 <= experiment.run.duration - odd[-1, 0] < experiment.run.step


@pytest.mark.parametrize(
    ("header", "change", "message"),
    [
        ("time,elbow,joint_2", None, "no column q.joint_1 or joint_1; it has time, elbow, joint_2"),
        ("t,joint_1,joint_2", None, "no column 'time'"),
        ("time,joint_1 [turns],joint_2", None, "no unit 'turns'"),
        ("time,joint_1,joint_1", None, "two columns 'joint_1'"),
        (
            "time,joint_1,q.joint_2,extra",
            None,
            "the first line has 4 names, but the rows have 3 numbers",
        ),
        ("time,joint_1,joint_2", (4, 1, np.nan), "row 5 of q.joint_1 is nan"),
        ("time,joint_1,joint_2", (4, 0, T[3]), "has a time in row 5 that is not after"),
        ("time,joint_1,joint_2", (4, 0, 0.0), "the time decreases after row 4"),
    ],
)
def test_error_is_one_line_with_file_and_line(
    tmp_path: Path, header: str, change: tuple[int, int, float] | None, message: str
) -> None:
    rows = np.c_[T, Q]
    if change is not None:
        rows[change[0], change[1]] = change[2]
    file = write_csv(tmp_path / "motion.csv", header, rows)
    with pytest.raises(InputError) as caught:
        reference_positions({"file": str(file)})
    text = str(caught.value)
    assert message in text
    assert "reference.file: motion.csv: " in text
    assert "\n" not in text


def test_pickle_is_never_executed(tmp_path: Path) -> None:
    np.save(tmp_path / "motion.npy", np.array([{"time": 0.0}], dtype=object), allow_pickle=True)
    with pytest.raises(InputError, match=r"motion\.npy: is not a valid NumPy file"):
        reference_positions({"file": str(tmp_path / "motion.npy")})


def test_signalling_nan_is_handled_like_other_nans(tmp_path: Path) -> None:
    rows = np.c_[T, Q]
    rows.view(np.uint64)[4, 1] = 0x7FF0000000000001
    np.save(tmp_path / "motion.npy", rows)
    with pytest.raises(InputError, match=r"row 5 of q\.joint_1 is nan"):
        reference_positions({"file": str(tmp_path / "motion.npy")})


@pytest.mark.slow
def test_example_tracks_recorded_encoder_positions(tmp_path: Path) -> None:
    shutil.copytree(PLANAR_2R / "robot", tmp_path / "planar_2r/robot")
    shutil.copytree(EXAMPLES / "recorded_motion", tmp_path / "recorded_motion")
    result = simulate(Experiment.load(tmp_path / "recorded_motion"), coupling="direct")
    assert result.summary["infeasible_ticks"] == 0
    assert result.summary["tracking"]["rms"] < 1e-4


def test_points_without_a_spline_are_waypoints() -> None:
    """The motion does not stop at inner points; it is at rest at both ends."""
    points = [
        {"time": 0.0, "q": [0.0, 0.0]},
        {"time": 1.0, "q": [0.2, 0.1]},
        {"time": 2.0, "q": [0.4, 0.2]},
    ]
    experiment = Experiment.load(PLANAR_2R, {"reference": {"points": points}})
    reference = SplineReference(experiment.reference.curve)  # type: ignore[arg-type]
    assert reference.evaluate(1.0).qd[0] > 0.2
    np.testing.assert_allclose(reference.evaluate(2.0).qd, 0.0, atol=1e-12)
