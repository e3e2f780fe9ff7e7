"""Results are on disk during a run, and readable at any time."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from io import FileIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.robots.robots import PLANAR_2R

from addin_sdfusion.robot import InputError
from addin_sdfusion.robot.errors import MachineError
from cardsflow_fmu import Experiment, run
from cardsflow_fmu.results import row_store
from cardsflow_fmu.results.folder import OutputFolder
from cardsflow_fmu.results.journal import STARTED, Journal
from cardsflow_fmu.results.row_store import RowStore
from cardsflow_fmu.results.saved_run import opened_run, read_results
from cardsflow_fmu.results.summary_text import describe_summary
from cardsflow_fmu.simulation.run import RunError
from cardsflow_fmu.utils.csv_table import csv_text

NAMES = ("time", "q.a", "q.b")
SUMMARY = {"status": "incomplete", "error": str(STARTED), "versions": {"cardsflow": "1"}}


def begin_journal(folder: OutputFolder, count: int = 5000) -> Journal:
    journal = Journal(folder, {"plant.fmu": b"new"})
    journal.begin(NAMES, dict.fromkeys(NAMES, "rad"), count, dict(SUMMARY))
    return journal


def unusual_numbers(count: int) -> np.ndarray:
    """Return numbers of all magnitudes, and values that are not finite."""
    rng = np.random.default_rng(3)
    rows = rng.normal(size=(count, 3)) * 10.0 ** rng.integers(-300, 300, size=(count, 3))
    rows[::7, 1], rows[::11, 2], rows[::13, 1] = np.nan, np.inf, -0.0
    rows[:, 0].sort()  # increasing times
    return rows


def test_streamed_rows_are_read_back_exactly(tmp_path: Path) -> None:
    rows = unusual_numbers(5000)
    with OutputFolder(tmp_path) as folder, begin_journal(folder) as journal:
        for k, row in enumerate(rows):
            journal.rows[k] = row
            journal.update(k + 1)
    back = read_results(tmp_path)
    np.testing.assert_array_equal(back.rows, rows)
    np.testing.assert_array_equal(np.signbit(back.rows), np.signbit(rows))
    assert back.names == NAMES
    assert not back.complete
    whole = csv_text(NAMES, rows)
    assert (tmp_path / "results.csv").read_text() == whole


def test_rows_are_in_the_file_during_the_run(tmp_path: Path) -> None:
    with OutputFolder(tmp_path) as folder, begin_journal(folder) as journal:
        for k in range(3):
            journal.rows[k] = k
            time.sleep(0.06)
            journal.update(k + 1)
            assert len(read_results(tmp_path).rows) == k + 1


def test_truncated_last_line_is_ignored(tmp_path: Path) -> None:
    with OutputFolder(tmp_path) as folder, begin_journal(folder) as journal:
        journal.rows[:2] = 0.125
        journal.update(2)
    table = tmp_path / "results.csv"
    whole = table.read_bytes()
    for cut in range(1, len("0.125,0.125,0.125\n")):
        table.write_bytes(whole[:-cut])
        assert len(read_results(tmp_path).rows) == 1
    summary = json.loads((tmp_path / "summary.json").read_text()) | {"status": "complete"}
    (tmp_path / "summary.json").write_text(json.dumps(summary))
    with pytest.raises(InputError, match="is not a table of results"):
        read_results(tmp_path)


def test_old_results_are_kept_until_a_run_begins(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    experiment = Experiment.load(PLANAR_2R, {"run.duration": 0.02})
    run(experiment, tmp_path, coupling="direct")
    before = {p.name: p.read_bytes() for p in tmp_path.iterdir()}

    def broken(self: Any, *_: Any) -> None:
        raise InputError("does not start")

    monkeypatch.setattr("cardsflow_fmu.models.plant.PlantModel.__init__", broken)
    with pytest.raises(InputError, match="does not start"):
        run(experiment, tmp_path, coupling="direct")
    assert {p.name: p.read_bytes() for p in tmp_path.iterdir()} == before


def test_full_disk_ends_the_run_with_complete_lines(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The disk accepts half of a block, then no more data."""
    write, room = FileIO.write, [20_000]

    class Full(FileIO):
        def write(self, data: Any) -> int:
            if room[0] == 0:
                raise OSError(28, "No space left on device")
            taken = min(len(data), room[0])
            room[0] -= taken
            return write(self, data[:taken])

    monkeypatch.setattr("cardsflow_fmu.results.journal.FileIO", Full)
    experiment = Experiment.load(PLANAR_2R, {"run.duration": 2.0})
    with pytest.raises(RunError, match="cannot be written: No space left") as error:
        run(experiment, tmp_path, coupling="direct")
    assert (tmp_path / "results.csv").stat().st_size <= 22_000
    assert (tmp_path / "results.csv").read_text().endswith("\n")
    kept = read_results(tmp_path)
    np.testing.assert_array_equal(kept.rows, error.value.result.rows[: len(kept.rows)])


def test_insufficient_disk_space_is_rejected_before_the_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "results.csv").write_text("time\n")
    (tmp_path / "summary.json").write_text(json.dumps(SUMMARY))
    with (
        OutputFolder(tmp_path) as folder,
        pytest.raises(MachineError, match=r"not enough space for a run of \d+ rows, \d+ MiB"),
    ):
        begin_journal(folder, 2**52)
    assert (tmp_path / "results.csv").read_text() == "time\n"


def test_large_table_is_an_unnamed_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(row_store, "IN_MEMORY", 0)
    store, rows = RowStore(400_000, 3, tmp_path), np.arange(1_200_000.0).reshape(-1, 3)
    for first in range(0, len(rows), 1000):
        store.rows[first : first + 1000] = rows[first : first + 1000]
        store.release(first + 1000)
    assert list(tmp_path.iterdir()) == []
    np.testing.assert_array_equal(store.rows, rows)


# Large tables


def large(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    monkeypatch.setattr(row_store, "IN_MEMORY", 0)
    return {"run.duration": 0.3, "controller.period": 0.005}


def test_large_table_is_an_array_with_the_same_numbers(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    settings = large(monkeypatch)
    result = run(Experiment.load(PLANAR_2R, settings), tmp_path / "large", coupling="direct")
    names = set(result.files)
    assert {"results.npy", "solve_times.npy"} < names
    assert names & {"results.csv", "solve_times.csv"} == set()
    csv = Experiment.load(PLANAR_2R, settings | {"run.format": "csv"})
    expected = run(csv, tmp_path / "small", coupling="direct")
    array = np.load(tmp_path / "large/results.npy")
    np.testing.assert_array_equal(array, expected.rows)
    np.testing.assert_array_equal(result.rows, expected.rows)
    units = json.loads((tmp_path / "large/results.units.json").read_text())
    assert tuple(units) == expected.names
    with opened_run(tmp_path / "large") as back:
        np.testing.assert_array_equal(back.rows, expected.rows)
        np.testing.assert_array_equal(back.solve_times, result.solve_times)
        assert back.complete
    run(csv, tmp_path / "large", coupling="direct")
    assert not (tmp_path / "large/results.npy").exists()
    with pytest.raises(ValueError, match="read-only"):
        result.rows[0] = 1.0  # the file would change


def test_large_table_is_complete_at_any_time(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A killed process leaves the file as it is."""
    monkeypatch.setattr(row_store, "IN_MEMORY", 0)
    rows = np.arange(15_000.0).reshape(-1, 3)
    with OutputFolder(tmp_path) as folder:
        journal = Journal(folder, {}, form="auto")
        journal.begin(NAMES, dict.fromkeys(NAMES, "rad"), 5000, dict(SUMMARY))
        assert read_results(tmp_path).rows.shape == (0, 3)
        for filled in (600, 1400):
            journal.rows[:filled] = rows[:filled]
            journal.update(filled)
            np.testing.assert_array_equal(read_results(tmp_path).rows, rows[:filled])
        journal.close()
    assert (tmp_path / "results.npy").stat().st_size == 128 + 8 * 3 * 1400
    assert [p.name for p in tmp_path.glob(".results*")] == []


@pytest.mark.parametrize(
    "content",
    [b"", b"PK\x03\x04", np.lib.format.magic(1, 0), b"1,2\n"],
    ids=["empty", "zip", "header", "csv"],
)
def test_damaged_array_is_one_clear_line(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "results.npy").write_bytes(content)
    (tmp_path / "results.units.json").write_text('{"time": "s", "q.a": "rad"}')
    (tmp_path / "summary.json").write_text(json.dumps(SUMMARY))
    with pytest.raises(InputError, match=r"results\.npy: is not an array of numbers"):
        read_results(tmp_path)


def test_array_of_another_size_is_rejected(tmp_path: Path) -> None:
    np.save(tmp_path / "results.npy", np.zeros((3, 5)))
    (tmp_path / "results.units.json").write_text('{"time": "s", "q.a": "rad"}')
    (tmp_path / "summary.json").write_text(json.dumps(SUMMARY))
    with pytest.raises(InputError, match=r"2 columns, but float64 of shape \(3, 5\)"):
        read_results(tmp_path)


# The memory of written rows is released. The table has 250 MB, which would otherwise be resident.
_GROWTH = """
import sys
from pathlib import Path
from cardsflow_fmu.results.row_store import RowStore

def resident():
    line = next(l for l in open("/proc/self/status") if l.startswith("VmRSS"))
    return int(line.split()[1]) // 1024

store, most, begin = RowStore(520_000, 60, Path(sys.argv[1])), 0, resident()
for k in range(520_000):
    store.rows[k] = k
    if k % 512 == 511:
        store.release(k + 1)
        most = max(most, resident() - begin)
print(most)
"""


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="needs Linux")
def test_memory_is_bounded_during_a_run(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-c", _GROWTH, tmp_path], capture_output=True, text=True, check=True
    )
    assert int(done.stdout) < 16  # MiB, of 238


@pytest.mark.slow
def test_summary_of_a_killed_run_is_computed_when_it_is_read(tmp_path: Path) -> None:
    """The same rows have the summary of a started run, and of a completed run."""
    settings = {"run.duration": 0.3, "plant.mass_scale": 1.2, "controller.period": 0.005}
    result = run(Experiment.load(PLANAR_2R, settings), tmp_path, coupling="direct")
    assert result.summary["tracking"]["rms"] > 1e-5
    unknown = {"rms": None, "max": None, "unit": None, "per_signal": {}}
    begun = result.summary | {"status": "incomplete", "error": str(STARTED), "tracking": unknown}
    (tmp_path / "summary.json").write_text(json.dumps(begun | {"ticks": 0, "forces": None}))
    with opened_run(tmp_path) as back:
        for key in ("tracking", "forces", "slack", "infeasible_ticks", "duration"):
            assert back.summary[key] == result.summary[key]
        assert (
            back.summary["ticks"] == result.summary["ticks"] + 1
        )  # there is no tick at the last row
        assert not back.complete
    lines = (tmp_path / "results.csv").read_text().splitlines()
    k = lines[0].split(",").index("q_d.joint_1")
    cells = lines[1].split(",")
    lines[1] = ",".join([*cells[:k], "inf", *cells[k + 1 :]])
    (tmp_path / "results.csv").write_text("\n".join([*lines, ""]))
    with opened_run(tmp_path) as back:
        assert back.summary["tracking"]["max"] == np.inf


@pytest.mark.slow
@pytest.mark.parametrize(("rows", "form"), [(0, "csv"), (1000, "csv"), (1000, "npy")])
def test_killed_run_leaves_readable_results(tmp_path: Path, rows: int, form: str) -> None:
    """The run is killed after a number of rows, long before its end."""
    out = tmp_path / "out"
    points = [{"time": 0, "q": 0}, {"time": 600, "q": 0.5}]
    settings = {"run.duration": 600.0, "reference": {"spline": "linear", "points": points}}
    words = "reference={spline='linear', points=[{time=0, q=0}, {time=600, q=0.5}]}"
    command = [sys.executable, "-m", "cardsflow_fmu.cli", "run", str(PLANAR_2R), "-o", str(out)]
    command += ["--set", "run.duration=600", "--set", words, "--set", f"run.format={form}"]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL) as process:
        begin = time.monotonic()
        while (seen := whole_rows(out / f"results.{form}")) < rows:
            assert process.poll() is None
            assert time.monotonic() - begin < 300.0
            time.sleep(0.005)
        os.kill(process.pid, signal.SIGKILL)
    summary = json.loads((out / "summary.json").read_text())
    assert (summary["status"], summary["error"]) == ("incomplete", str(STARTED))
    with opened_run(out) as killed:
        assert len(killed.rows) >= seen
        np.testing.assert_allclose(killed["time"], 1e-3 * np.arange(len(killed.rows)), atol=1e-12)
        assert killed.experiment.robot == Experiment.load(PLANAR_2R).robot
        assert describe_summary(killed.summary)[0].startswith(
            f"planar_2r: {killed['time'].max(initial=0):.6g} s"
        )
    settings["run.duration"] = max(len(killed.rows), 1) * 1e-3  # the last row has no tick
    again = run(Experiment.load(PLANAR_2R, settings), out, coupling="direct")
    np.testing.assert_allclose(killed.rows, again.rows[: len(killed.rows)], rtol=0, atol=1e-12)


def whole_rows(table: Path) -> int:
    """Return the number of complete rows of a file without its header; -1 if it does not exist."""
    if not table.exists():
        return -1
    if table.suffix == ".npy":
        return int(np.lib.format.open_memmap(table, mode="r").shape[0])
    return max(len(table.read_bytes().splitlines()) - 2, 0)
