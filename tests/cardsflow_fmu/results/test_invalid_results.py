"""Empty, truncated, changed or damaged results; and files of other programs, which are kept."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from support.cases import sample_cases
from support.command_line import CommandLine
from support.experiments import twin_arms
from support.process_output import files_of
from support.robots.robots import EXAMPLES, PLANAR_2R

from cardsflow_fmu import Experiment, run
from cardsflow_fmu.results.report.page import report

Change = Callable[[Path], object]


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("good") / "results"
    settings = {"run.duration": 0.1, "run.figures": True}
    run(Experiment.load(PLANAR_2R, settings), folder, coupling="direct")
    return folder


def table(change: Callable[[list[bytes]], list[bytes]]) -> Change:
    def edit(folder: Path) -> None:
        file = folder / "results.csv"
        file.write_bytes(b"\n".join(change(file.read_bytes().split(b"\n"))))

    return edit


def fill_column(value: bytes) -> Change:
    def row(line: bytes) -> bytes:
        time, *rest = line.split(b",")
        return b",".join([time, *[value] * len(rest)])

    return table(lambda lines: [lines[0], *map(row, lines[1:-1]), b""])


def head(old: bytes, new: bytes) -> Change:
    return table(lambda lines: [lines[0].replace(old, new, 1), *lines[1:]])


def at_row(k: int, new: Callable[[bytes], bytes]) -> Change:
    return table(lambda lines: [*lines[:k], new(lines[k]), *lines[k + 1 :]])


def note(name: str, text: str) -> Change:
    return lambda folder: (folder / name).write_text(text)


def change_summary(**changes: Any) -> Change:
    def edit(folder: Path) -> None:
        file = folder / "summary.json"
        file.write_text(json.dumps(json.loads(file.read_text()) | changes))

    return edit


def as_folder(name: str) -> Change:
    def edit(folder: Path) -> None:
        (folder / name).unlink()
        (folder / name).mkdir()

    return edit


DRAWN: dict[str, Change] = {
    "one row": table(lambda lines: [*lines[:2], b""]),
    "two rows": table(lambda lines: [*lines[:3], b""]),
    "nan": fill_column(b"nan"),
    "inf": fill_column(b"inf"),
    "huge": fill_column(b"1e308"),
    "bom": head(b"time", b"\xef\xbb\xbftime"),
    "crlf": table(lambda lines: [line + b"\r" for line in lines[:-1]] + [b""]),
    "one time": table(lambda lines: [lines[0], *[lines[1]] * 20, b""]),
    "no forces": head(b"f.cable_1,", b"fff,"),
    "late tick": note("solve_times.csv", "time,solve_time\n1e308,7e-6\n"),
    "long name": head(b"slack", b"x" * 100_000),
}
"""Unusual results that can be drawn."""


def commands(folder: Path, aside: Path) -> dict[str, list[str]]:
    return {
        "plot": ["plot", str(folder), "-o", str(aside / "plot.png")],
        "report": ["report", str(folder), "-o", str(aside / "report.html")],
        "view": ["view", str(folder), "--html", str(aside / "view.html")],
    }


@pytest.mark.cases(4)
@pytest.mark.slow
@pytest.mark.parametrize("case", DRAWN)
def test_unusual_results_are_drawn(
    case: str, results: Path, tmp_path: Path, cardsflow: CommandLine
) -> None:
    folder = tmp_path / "größe 日本"
    shutil.copytree(results, folder)
    DRAWN[case](folder)
    for name in ("plot", "report"):  # the report contains a view
        code, out, err = cardsflow(*commands(folder, tmp_path)[name])
        assert (code, err) == (0, "")
        assert Path(out.strip()).stat().st_size > 1000


ANY = ("plot", "report", "view")
WITH_ROBOT = ("report", "view")
REFUSED: dict[str, tuple[Change, str, tuple[str, ...]]] = {
    "no rows": (table(lambda x: [x[0], b""]), "no rows", ANY),
    "empty": (table(lambda x: [b""]), "is empty", ANY),
    "time without number": (at_row(3, lambda x: b"nan" + x[x.index(b",") :]), "time of row 3", ANY),
    "time decreases": (table(lambda x: [x[0], *x[-2:0:-1], b""]), "decreases after row 1", ANY),
    "no time": (head(b"time,", b"tim,"), "its first column must be 'time'", ANY),
    "no q": (head(b"q.joint_1,", b"qqq,"), "no column 'q.joint_1'", WITH_ROBOT),
    "twice": (head(b"q.joint_2,", b"q.joint_1,"), "two columns 'q.joint_1'", ANY),
    "no name": (head(b"q.joint_2,", b","), "column 3 has no name", ANY),
    "ragged": (at_row(4, lambda x: x + b",1,2"), "number of columns changed", ANY),
    "text": (at_row(4, lambda x: b"hello" + x), "could not convert", ANY),
    "binary": (table(lambda x: [bytes(range(256))]), "is not UTF-8 text", ANY),
    "latin": (head(b"q.joint_1", b"q.gr\xf6\xdfe"), "is not UTF-8 text", ANY),
    "nul": (at_row(4, lambda x: b"\0" * 200 + x), "could not convert", ANY),
    "folder": (as_folder("results.csv"), "", ANY),
    "zip": (
        lambda f: (f / "experiment.zip").write_bytes(b"PK\3\4junk"),
        "is not a valid archive",
        ANY,
    ),
    "no zip": (lambda f: (f / "experiment.zip").unlink(), "has no experiment.zip", WITH_ROBOT),
    "zip folder": (as_folder("experiment.zip"), "has no experiment.zip", WITH_ROBOT),
    "summary": (note("summary.json", "{"), "summary.json: is not valid JSON", ANY),
    "list": (note("summary.json", "[]"), "summary.json: is invalid", ANY),
    "nothing": (note("summary.json", "{}"), "summary.json: status: is invalid", ANY),
    "deep": (note("summary.json", '{"a":' * 50_000), "nested too deeply", ANY),
    "status": (change_summary(status=5), "status: is invalid", ANY),
    "tracking": (change_summary(tracking=7), "tracking: is invalid", ANY),
    "rms": (change_summary(tracking={"rms": "x"}), "tracking.rms: is invalid", ANY),
    "signal": (change_summary(tracking={"per_signal": {"q": 5}}), "per_signal: is invalid", ANY),
    "muscle": (change_summary(forces={"per_muscle": {"m": {}}}), "per_muscle: is invalid", ANY),
    "engine": (change_summary(engine=["core"]), "engine: is invalid", ANY),
    "hardware": (change_summary(hardware=[1]), "hardware: is invalid", ANY),
    "round trip": (
        change_summary(hardware={"round_trip": 3}),
        "hardware.round_trip: is invalid",
        ANY,
    ),
    "lateness": (
        change_summary(real_time={"lateness": [1]}),
        "real_time.lateness: is invalid",
        ANY,
    ),
    "versions": (change_summary(versions=[]), "versions: is invalid", ANY),
    "units": (note("results.units.json", '{"time": 5}'), "time: is invalid", ANY),
    "no units": (lambda f: (f / "results.units.json").unlink(), "results.units.json", ANY),
    "times": (note("solve_times.csv", "time,solve_time\nx,y\n"), "solve_times.csv", ANY),
    "one time column": (note("solve_times.csv", "time\n1\n"), "times of ticks", ANY),
}


@pytest.mark.parametrize("case", REFUSED)
def test_invalid_results_are_reported_in_one_line(
    case: str, results: Path, tmp_path: Path, cardsflow: CommandLine
) -> None:
    change, message, names = REFUSED[case]
    folder = tmp_path / "results"
    shutil.copytree(results, folder)
    change(folder)
    for name in names:
        err = cardsflow.error_line(*commands(folder, tmp_path)[name])
        assert len(err) < 1500
        assert message in err
    assert [
        file.name for file in tmp_path.iterdir() if file.is_file() and "plot" not in names
    ] == []
    if case not in ("no rows", "no q", "no zip", "zip folder", "zip"):
        err = cardsflow.error_line("compare", folder, results)
        assert message.removesuffix("; did you mean 'tim'") in err


@pytest.mark.slow
def test_results_of_another_robot_are_reported(
    results: Path, tmp_path: Path, cardsflow: CommandLine
) -> None:
    other = tmp_path / "other"
    settings = {"run.duration": 0.01, "reference.flower.duration": 1.0}
    run(Experiment.load(EXAMPLES / "roboy_left_arm", settings), other, coupling="direct")
    code, out, _ = cardsflow("compare", results, other)
    assert (code, "missing in the second: " in out) == (1, True)
    shutil.copy(results / "experiment.zip", other)
    err = cardsflow.error_line("view", other, "--html", tmp_path / "page.html")
    assert "experiment.zip: is of robot 'planar_2r'" in err


# Where to write


def outputs(results: Path, place: Path) -> list[list[str]]:
    return [
        ["plot", str(results), "-o", f"{place}.png"],
        ["plot", str(results), "-o", f"{place}.svg"],
        ["plot", str(results), "-o", f"{place}.pdf"],
        ["report", str(results), "-o", f"{place}.html"],
        ["view", str(results), "--html", f"{place}.html"],
    ]


@pytest.mark.slow
@pytest.mark.parametrize("k", sample_cases(range(5), 2))
def test_files_of_other_programs_are_kept_and_our_files_are_replaced(
    k: int, results: Path, tmp_path: Path, cardsflow: CommandLine
) -> None:
    words = outputs(results, tmp_path / "größe")[k]
    file = Path(words[-1])
    assert cardsflow(*words)[0] == 0
    first = file.read_bytes()
    assert cardsflow(*words)[0] == 0
    assert file.read_bytes() == first
    file.write_text("mine")
    assert f"{file}: already exists and was not written by cardsflow" in cardsflow.error_line(
        *words
    )
    assert file.read_text() == "mine"
    file.unlink()
    file.mkdir()
    assert "is a folder" in cardsflow.error_line(*words)


@pytest.mark.cases(5)
@pytest.mark.slow
@pytest.mark.parametrize("k", sample_cases(range(5), 2))
@pytest.mark.parametrize("place", ["file/x", "x" * 300, "a\0b", "/proc/x"])
def test_output_that_cannot_be_written_is_reported(
    k: int, place: str, results: Path, tmp_path: Path, cardsflow: CommandLine
) -> None:
    (tmp_path / "file").write_text("mine")
    assert "cannot be written" in cardsflow.error_line(*outputs(results, tmp_path / place)[k])
    assert [file.name for file in tmp_path.iterdir()] == ["file"]


@pytest.mark.slow
def test_results_file_is_never_overwritten(results: Path, cardsflow: CommandLine) -> None:
    before = files_of(results)
    for name in ("results.csv", "summary.json", "experiment.zip"):
        for words in (["report", results, "-o"], ["view", results, "--html"]):
            assert "must end in .html" in cardsflow.error_line(*words, results / name)
        cardsflow.error_line("plot", results, "-o", results / name)
    cardsflow.error_line("plot", results, "-o", results / "tracking.png")
    assert files_of(results) == before


@pytest.mark.slow
def test_report_of_several_robots_contains_each_robot(tmp_path: Path) -> None:
    twins = twin_arms(tmp_path, 0.0, "[muscles.b_cable_1]\nf_max = 77.25\n")
    run(twins, tmp_path / "out", coupling="direct")
    page = tmp_path / "report.html"
    report(tmp_path / "out", page)
    text = page.read_text()
    assert "<h3>a</h3>" in text
    assert text.count("77.25") >= 2
    assert text.count("links, 2 coordinates") == 2
    assert str(tmp_path) not in text
    assert "/tmp/" not in text
