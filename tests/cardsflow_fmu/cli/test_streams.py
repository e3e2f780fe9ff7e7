"""Closed and full outputs, limited encodings, control characters, and numbers with many digits."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from unittest.mock import Mock

import pytest
from support.command_line import CommandLine
from support.robots.robots import PLANAR_2R

from addin_sdfusion.robot import Finding, InputError, Subject
from addin_sdfusion.robot.errors import MachineError
from addin_sdfusion.robot.files import file_error
from cardsflow_fmu.cli.main import main
from cardsflow_fmu.cli.terminal.streams import printable

CARDSFLOW = f"{sys.executable} -m cardsflow_fmu.cli"
INFO = f"{CARDSFLOW} info {PLANAR_2R / 'robot'}"
WRONG = f"{CARDSFLOW} info /nowhere"


def shell(command: str, **variables: str) -> tuple[int, str, str]:
    done = subprocess.run(
        command, shell=True, capture_output=True, check=False, env=os.environ | variables
    )
    return done.returncode, done.stdout.decode(), done.stderr.decode()


@pytest.mark.slow
def test_closed_output_does_not_change_the_results(tmp_path: Path) -> None:
    assert shell(f"{INFO} >&-") == (0, "", "")
    assert shell(f"{INFO} >&- 2>&- <&-") == (0, "", "")
    assert shell(f"{WRONG} 2>&-") == (2, "", "")
    assert shell(f"{WRONG} 2>/dev/full") == (2, "", "")
    words = f"--coupling direct --set run.duration=0.02 -o {tmp_path / 'out'}"
    run = f"{CARDSFLOW} run {PLANAR_2R} {words}"
    assert shell(f"{run} >&- 2>&-")[0] == 0
    assert json.loads((tmp_path / "out/summary.json").read_text())["status"] == "complete"


def test_closed_pipe_does_not_change_the_exit_code(
    tmp_path: Path, cardsflow: CommandLine, monkeypatch: pytest.MonkeyPatch
) -> None:
    wrong = tmp_path / "a.urdf"
    wrong.write_text('<robot name="a&#155;"><link name="b"/></robot>')
    for words, expected in ((["info", PLANAR_2R / "robot"], 0), (["check", wrong], 1)):
        assert cardsflow(*words)[0] == expected
        reading, writing = os.pipe()
        os.close(reading)
        with os.fdopen(writing, "w", buffering=1) as stream, monkeypatch.context() as patch:
            patch.setattr(sys, "stdout", stream)
            assert main(list(map(str, words))) == expected


@pytest.mark.slow
@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full")
def test_full_output_is_exit_code_1() -> None:
    for command in (INFO, f"{CARDSFLOW} --version"):
        code, _, err = shell(f"{command} >/dev/full", PYTHONUNBUFFERED="")
        assert (code, err) == (1, "cardsflow: the output: No space left on device\n")


@pytest.mark.slow
def test_characters_outside_the_output_encoding_are_escaped(tmp_path: Path) -> None:
    folder = tmp_path / "r\u00e9sultats"
    words = f"{CARDSFLOW} run {PLANAR_2R} --coupling direct --set run.duration=0.02 -o {folder}"
    code, out, err = shell(words, PYTHONIOENCODING="ascii", PYTHONUTF8="0")
    assert code == 0, err
    assert "r\\xe9sultats" in out


def test_full_disk_is_exit_code_1() -> None:
    full = file_error(OSError(28, "No space left on device"), "cannot be written", "here")
    assert isinstance(full, MachineError)
    assert str(full) == "here: cannot be written: No space left on device"
    denied = file_error(OSError(13, "Permission denied"), "cannot be written", "here")
    assert isinstance(denied, InputError)


def test_folder_without_permission_is_invalid_input(
    tmp_path: Path, cardsflow: CommandLine, monkeypatch: pytest.MonkeyPatch
) -> None:
    denied = PermissionError(13, "Permission denied", "robot/experiment.toml")
    monkeypatch.setattr(Path, "is_file", Mock(side_effect=denied))
    line = cardsflow.error_line("check", tmp_path)
    assert line == "cardsflow: robot/experiment.toml: Permission denied\n"


def test_control_characters_are_escaped() -> None:
    text = "a\x1b[31m\x9b31m\x00\r\x7f\u202e\u200f\u2028b\n\tc \u00e4\u4e2d"
    expected = "a\\x1b[31m\\x9b31m\\x00\\x0d\\x7f\\u202e\\u200f\\u2028b\n\tc \u00e4\u4e2d"
    assert printable(text) == expected
    assert printable("\u00e4\udcff", "ascii") == "\\xe4\\udcff"


def test_messages_have_no_control_characters(cardsflow: CommandLine) -> None:
    err = cardsflow.error_line("info", "/nowhere\x1b[31m\x9b31m")
    assert "\\x1b[31m\\x9b31m" in err
    assert not {"\x1b", "\x9b"} & set(err)


def test_messages_quote_a_limited_length(tmp_path: Path, cardsflow: CommandLine) -> None:
    word = "a" * 30_000
    joint = f'<joint name="j" type="fixed"><parent link="{word}"/><child link="b"/></joint>'
    (tmp_path / "a.urdf").write_text(f'<robot name="r"><link name="b"/>{joint}</robot>')
    assert len(cardsflow.error_line("info", tmp_path / "a.urdf")) < 5000
    assert len(cardsflow.error_line("run", PLANAR_2R, "--set", f"{word}={word}")) < 5000
    assert len(cardsflow.error_line("info", word)) < 2000
    about = Finding("error", "odd", f"no link {word!r}", Subject("link", word))
    assert len(str(about)) < 5000


@pytest.mark.parametrize("digits", [20, 400, 5000])
@pytest.mark.parametrize("key", ["controller.period", "run.duration", "world.ignore"])
def test_numbers_with_many_digits_are_reported(
    tmp_path: Path, cardsflow: CommandLine, digits: int, key: str
) -> None:
    message = cardsflow.error_line("run", PLANAR_2R, "--set", f"{key}=1{'0' * digits}")
    assert key in message
    (tmp_path / "experiment.toml").write_text(f"a = 1{'0' * digits}\n")
    assert "experiment.toml" in cardsflow.error_line("run", tmp_path)
