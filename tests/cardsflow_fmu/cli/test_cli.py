"""Tests of all commands: help, exit codes, JSON, progress, scripts, completion."""

from __future__ import annotations

import argparse
import ast
import builtins
import contextlib
import fcntl
import os
import pty
import shlex
import signal
import struct
import subprocess
import sys
import termios
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.command_line import CommandLine
from support.process_output import wait_until
from support.robots.robots import EXAMPLES, PLANAR_2R
from support.small_studies import KP, write_study

from cardsflow_fmu import Experiment, Result, run
from cardsflow_fmu.cli.main import _parser, main
from cardsflow_fmu.cli.parser import EXIT_CODES
from cardsflow_fmu.utils.interrupts import collect_interrupts, raise_on_termination

SHORT = ["--set", "run.duration=0.05"]
CARDSFLOW = [sys.executable, "-m", "cardsflow_fmu.cli"]
ROBOT = str(PLANAR_2R / "robot")


def commands(
    parser: argparse.ArgumentParser, words: tuple[str, ...] = ()
) -> Iterator[tuple[tuple[str, ...], argparse.ArgumentParser]]:
    """Yield every command with its parser, including groups of commands."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for name, inner in action.choices.items():
                yield (*words, name), inner
                yield from commands(inner, (*words, name))


COMMANDS = dict(commands(_parser()))


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("results")
    run(Experiment.load(PLANAR_2R, {"run.duration": 0.05}), folder, coupling="direct")
    return folder


@pytest.mark.parametrize("words", COMMANDS, ids=" ".join)
def test_help_of_every_command_has_a_valid_example(
    words: tuple[str, ...], cardsflow: CommandLine
) -> None:
    code, out, _ = cardsflow(*words, "--help")
    assert code == 0
    name = f"cardsflow {' '.join(words)} "
    begin = out.index("example:\n  ") + len("example:\n  ")
    example = out[begin:].splitlines()[0]
    assert f"{example} ".startswith(name)
    arguments = shlex.split(example.partition(" > ")[0])[1:]
    assert callable(_parser(arguments[0]).parse_args(arguments).command)


def test_help_lists_the_exit_codes(cardsflow: CommandLine) -> None:
    code, out, _ = cardsflow("--help")
    assert code == 0
    assert "example:\n  cardsflow run" in out
    assert EXIT_CODES in out
    for number in ("0", "1", "2", "130"):
        assert f"\n  {number} " in out


# Bad input: one line, exit code 2

PUBLISHER = ["--company", "Us", "--url", "https://example.org", "--email", "us@example.org"]
GROUPS = (("addin",), ("examples",), ("policy",))
MISSING = {
    ("init",): ["nowhere"],
    ("schema",): ["nothing"],
    ("completion",): ["nothing"],
    ("examples", "list"): ["nothing"],
    ("examples", "copy"): ["nothing"],
    ("run",): ["nowhere"],
    ("build",): ["nowhere", "-o", "fmus"],
    ("check",): ["nowhere"],
    ("info",): ["nowhere"],
    ("convert",): ["nowhere", "--to", "mjcf", "-o", "there"],
    ("size",): ["nowhere"],
    ("faults",): ["nowhere"],
    ("policy", "export"): ["nowhere.pt", "nowhere", "-o", "there"],
    ("activations",): ["nowhere", "--motion", "nowhere.mot"],
    ("excite",): ["nowhere", "-o", "there"],
    ("calibrate",): [
        "nowhere",
        "--robot",
        "nowhere",
        "--parameters",
        "muscles.*.offset",
        "-o",
        "there",
    ],
    ("device",): ["nowhere"],
    ("replay-hardware",): ["nowhere"],
    ("import-cad",): ["nowhere.json"],
    ("addin", "install"): ["--folder", "a/file"],
    ("addin", "pack"): ["-o", "a/file/packed", *PUBLISHER],
    ("play",): ["nowhere", "--html", "page.html"],
    ("view",): ["nowhere", "--html", "page.html"],
    ("edit",): ["nowhere", "--html", "page.html"],
    ("plot",): ["nowhere"],
    ("compare",): ["nowhere", "nowhere"],
    ("report",): ["nowhere"],
    ("study",): ["nowhere.toml"],
    ("optimise",): ["nowhere.toml"],
}


@pytest.mark.parametrize(
    "words", [words for words in COMMANDS if words not in GROUPS], ids=" ".join
)
def test_invalid_input_is_one_line_and_exit_code_2(
    words: tuple[str, ...],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    cardsflow: CommandLine,
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a").mkdir()
    (tmp_path / "a/file").write_text("mine")
    code, out, err = cardsflow(*words, *MISSING[words])
    assert (code, out) == (2, "")
    assert "Traceback" not in err
    assert len(err.splitlines()) == 1 or err.startswith("usage: ")
    assert [file.name for file in tmp_path.rglob("*")] == ["a", "file"]
    assert (tmp_path / "a/file").read_text() == "mine"


@pytest.mark.parametrize("words", COMMANDS, ids=" ".join)
def test_unknown_option_is_exit_code_2(words: tuple[str, ...], cardsflow: CommandLine) -> None:
    code, out, err = cardsflow(*words, "--no-such-option")
    assert (code, out) == (2, "")
    assert err.startswith("usage: ")


@pytest.mark.slow
def test_negative_result_is_exit_code_1(
    results: Path, tmp_path: Path, cardsflow: CommandLine
) -> None:
    other = tmp_path / "other.csv"
    other.write_text("time,q.joint_1\n0.0,7.0\n")
    assert cardsflow("compare", str(results), str(results))[0] == 0
    assert cardsflow("compare", str(results), str(other))[0] == 1
    assert cardsflow("check", ROBOT)[0] == 0
    weightless = tmp_path / "model.sdf"
    text = (EXAMPLES / "hill_arm/robot/model.sdf").read_text()
    weightless.write_text(text.replace("<mass>", "<mass>-"))
    assert cardsflow("check", str(weightless))[0] == 1
    assert cardsflow("size", str(PLANAR_2R), *SHORT)[0] == 0


# JSON


@pytest.mark.slow
def test_commands_that_write_files_list_them_as_json(
    results: Path, tmp_path: Path, cardsflow: CommandLine
) -> None:
    for words in (
        ("init", ROBOT, "-o", str(tmp_path / "experiment.toml")),
        ("convert", ROBOT, "--to", "mjcf", "-o", str(tmp_path / "mjcf")),
        ("build", str(PLANAR_2R), *SHORT, "-o", str(tmp_path / "fmus")),
        ("plot", str(results), "-o", str(tmp_path / "plot.svg")),
        ("report", str(results), "-o", str(tmp_path / "report.html")),
        ("view", str(results), "--html", str(tmp_path / "page.html")),
        ("addin", "pack", "-o", str(tmp_path / "packed")),
        ("addin", "install", "--folder", str(tmp_path / "addins")),
    ):
        listed = cardsflow.json(*words)
        assert listed["files"]
        assert all(Path(file).exists() for file in listed["files"])


def test_every_command_with_data_has_json() -> None:
    without = {
        ("schema",),
        ("completion",),
        ("addin",),
        ("examples",),
        ("policy",),
    }  # they print input for other programs
    for words, parser in COMMANDS.items():
        options = {option for action in parser._actions for option in action.option_strings}
        assert ("--json" in options) == (words not in without), words


@pytest.mark.slow
@pytest.mark.parametrize("what", ["run", "info", "check", "size"])
def test_commands_print_json(what: str, tmp_path: Path, cardsflow: CommandLine) -> None:
    words = {
        "run": ("run", str(PLANAR_2R), *SHORT, "--coupling", "direct", "-o", str(tmp_path)),
        "info": ("info", ROBOT),
        "check": ("check", ROBOT),
        "size": ("size", str(PLANAR_2R), *SHORT),
    }[what]
    assert isinstance(cardsflow.json(*words), dict | list)


# Scripts


@pytest.mark.slow
# Interruption


def run_and_interrupt(
    words: list[str], folder: Path, pattern: str, sign: signal.Signals = signal.SIGINT
) -> int:
    """Return the exit code of a command that is interrupted when a file exists."""
    with subprocess.Popen(
        [*CARDSFLOW, *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        start_new_session=True,
    ) as process:
        assert wait_until(lambda: any(folder.glob(pattern)) or process.poll() is not None)
        assert process.poll() is None, process.stderr and process.stderr.read()
        time.sleep(0.1)
        process.send_signal(sign)
        _, err = process.communicate(timeout=300)
    assert b"Traceback" not in err
    assert b"interrupted" in err
    return process.returncode


@pytest.mark.cases(1)
@pytest.mark.slow
@pytest.mark.parametrize("sign", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_interrupted_run_is_exit_code_130(tmp_path: Path, sign: signal.Signals) -> None:
    out = tmp_path / "out"
    words = [
        "run",
        str(PLANAR_2R),
        "--coupling",
        "direct",
        "-o",
        str(out),
        "--set",
        "run.duration=600",
    ]
    words += ["--set", 'reference={spline="linear", points=[{time=0, q=0}, {time=600, q=0.5}]}']
    assert run_and_interrupt(words, out, "results.npy", sign) == 130
    result = Result.load(out)
    assert result.summary["error"] == "interrupted"
    assert len(result.rows) > 0


@pytest.mark.cases(1)
@pytest.mark.slow
@pytest.mark.parametrize("sign", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_interrupted_study_is_exit_code_130(tmp_path: Path, sign: signal.Signals) -> None:
    many = KP.replace("count = 6 ", "count = 600 ")
    assert many != KP
    study = write_study(tmp_path, many)
    out = tmp_path / "out"
    words = ["study", str(study), "-j", "1", "-o", str(out)]
    assert run_and_interrupt(words, out, "runs/*.json", sign) == 130


def test_interruption_that_a_library_replaces_is_exit_code_130(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """C extensions raise ImportError if they are interrupted while they are imported."""

    def replace_interruption(options: argparse.Namespace) -> int:
        try:
            signal.raise_signal(signal.SIGINT)
        except BaseException:
            raise ImportError("initialization failed") from None
        return 0

    monkeypatch.setattr("cardsflow_fmu.cli.robot._check", replace_interruption)
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        assert main(["check", ROBOT]) == 130
    finally:
        signal.signal(signal.SIGINT, before)
    assert capsys.readouterr().err == "cardsflow: interrupted\n"


@pytest.mark.parametrize("name", ["argparse", "addin_sdfusion.robot.files"])
def test_interruption_of_an_import_prints_no_traceback(
    name: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    """Imports of the program and of a command; a missing file reaches both."""
    real = builtins.__import__

    def interrupted(module: str, *arguments: Any, **options: Any) -> Any:
        if module == name:
            raise KeyboardInterrupt
        return real(module, *arguments, **options)

    monkeypatch.setattr(builtins, "__import__", interrupted)
    code = main(["check", str(tmp_path / "missing.sdf")])
    monkeypatch.undo()
    assert code == 130
    assert capsys.readouterr().err == "cardsflow: interrupted\n"


LOADED = """
import sys
before = set(sys.modules)
from cardsflow_fmu.cli.main import main
program = set(sys.modules) - before
try:
    main(["--version"])
except SystemExit:
    print(sorted(program), "numpy" in sys.modules, "addin_sdfusion" in sys.modules)
"""


def test_start_of_the_program_imports_little() -> None:
    """An interruption while the script imports `main` would print a traceback."""
    words = [sys.executable, "-S", "-c", LOADED]
    path = os.pathsep.join([str(Path(__file__).parents[3]), *sys.path])
    found = subprocess.run(
        words, env={**os.environ, "PYTHONPATH": path}, capture_output=True, text=True, check=True
    )
    program, *heavy = found.stdout.splitlines()[-1].rsplit(" ", 2)
    assert heavy == ["False", "False"]
    ours = [name for name in ast.literal_eval(program) if name.startswith("cardsflow_fmu")]
    assert ours == ["cardsflow_fmu", "cardsflow_fmu.cli", "cardsflow_fmu.cli.main", VERSION]
    assert not {"argparse", "traceback"} & set(ast.literal_eval(program))


VERSION = "cardsflow_fmu.version"


def test_interruption_ignored_in_the_background_stays_ignored() -> None:
    """A shell starts jobs of a script in the background with SIGINT ignored."""
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        with raise_on_termination():
            signal.raise_signal(signal.SIGINT)
    finally:
        signal.signal(signal.SIGINT, before)


def test_signals_ignored_by_nohup_stay_ignored() -> None:
    """A run with nohup continues when its terminal is closed."""
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with collect_interrupts() as interrupted, raise_on_termination():
            signal.raise_signal(signal.SIGHUP)
        assert not interrupted
        assert signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGHUP, before)


# Progress

CONTROL = {chr(k).encode() for k in range(32)} - {b"\n"} | {b"\x7f", b"\x1b"}


def long_work(folder: Path) -> list[list[str]]:
    return [
        [
            "run",
            str(PLANAR_2R),
            "--coupling",
            "direct",
            "--set",
            "run.duration=0.3",
            "-o",
            str(folder / "run"),
        ],
        ["study", str(write_study(folder)), "-j", "1", "-o", str(folder / "study")],
    ]


@pytest.mark.cases(1)
@pytest.mark.slow
@pytest.mark.parametrize("k", [0, 1], ids=["run", "study"])
def test_progress_bar_is_only_shown_on_terminals(k: int, tmp_path: Path) -> None:
    words = long_work(tmp_path)[k]
    done = subprocess.run([*CARDSFLOW, *words], capture_output=True, check=True, timeout=300)
    assert not any(sign in done.stdout + done.stderr for sign in CONTROL)
    (tmp_path / "again").mkdir()
    shown = run_on_terminal(long_work(tmp_path / "again")[k])
    assert b"\r" in shown
    assert b"%|" in shown


BAR_AT_ONCE = """
import sys
from cardsflow_fmu.cli.main import main
from cardsflow_fmu.cli.terminal import progress

progress._DELAY, progress._REFRESH = 0.0, 0.005
sys.exit(main(sys.argv[1:]))
"""
"""Program that also shows progress bars of short work."""


def run_on_terminal(words: list[str]) -> bytes:
    """Return the stderr of a command on a terminal; its stdout is a pipe."""
    ours, theirs = pty.openpty()
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 80, 0, 0))
    program = [sys.executable, "-c", BAR_AT_ONCE, *words]
    with subprocess.Popen(program, stdout=subprocess.PIPE, stderr=theirs) as process:
        os.close(theirs)
        shown = b""
        with contextlib.suppress(OSError):  # reading a closed terminal raises an error
            while block := os.read(ours, 4096):
                shown += block
        piped = process.stdout.read()
    os.close(ours)
    assert process.returncode == 0
    assert not any(sign in piped for sign in CONTROL)
    return shown


# Completion


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_completion_contains_all_commands_and_options(shell: str, cardsflow: CommandLine) -> None:
    code, out, _ = cardsflow("completion", shell)
    assert code == 0
    for words, parser in COMMANDS.items():
        assert words[-1] in out
        for action in parser._actions:
            for option in action.option_strings:
                assert option.lstrip("-") in out


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("cardsflow re", {"report", "replay-hardware"}),
        ("cardsflow compare --a", {"--atol"}),
        ("cardsflow build --fmi ", {"2.0", "3.0"}),
        ("cardsflow info exp", {"experiment.toml"}),
        ("cardsflow addin ", {"install", "pack"}),
    ],
)
def test_bash_completes(
    line: str, expected: set[str], tmp_path: Path, cardsflow: CommandLine
) -> None:
    (tmp_path / "completion.sh").write_text(cardsflow("completion", "bash")[1])
    (tmp_path / "experiment.toml").touch()
    script = f"""
source completion.sh
COMP_LINE={line!r}; COMP_POINT=${{#COMP_LINE}}
read -ra COMP_WORDS <<< "$COMP_LINE"; [[ "$COMP_LINE" == *" " ]] && COMP_WORDS+=("")
COMP_CWORD=$((${{#COMP_WORDS[@]}} - 1))
$(complete -p cardsflow | sed 's/.*-F \\([^ ]*\\).*/\\1/')
printf '%s\\n' "${{COMPREPLY[@]}}"
"""
    try:
        done = subprocess.run(
            ["bash", "-c", script], cwd=tmp_path, capture_output=True, text=True, check=False
        )
    except FileNotFoundError:
        pytest.skip("no bash")
    assert expected <= {word.strip() for word in done.stdout.splitlines()}, done.stderr


def test_completion_for_unknown_shell_is_rejected(cardsflow: CommandLine) -> None:
    code, _, err = cardsflow("completion", "csh")
    assert code == 2
    assert "no value 'csh'; did you mean 'zsh'?" in err


def test_json_summary_equals_the_file(results: Path, cardsflow: CommandLine) -> None:
    compared = cardsflow.json("compare", str(results), str(results))
    assert compared["equal"]
    assert np.all([column["largest"] == 0.0 for column in compared["columns"].values()])
