"""Only one program writes into a folder; temporary files of killed programs are deleted later."""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest
from support.command_line import CommandLine
from support.robots.robots import PLANAR_2R

from addin_sdfusion.robot import InputError
from cardsflow_fmu.results.folder import OutputFolder
from cardsflow_fmu.utils.folder_lock import LOCK, lock_folder

LONG = ["--set", "run.duration=100"]  # short enough for a table in CSV
SHORT = ["--set", "run.duration=0.02"]


@contextmanager
def running(folder: Path, temporary: Path) -> Iterator[subprocess.Popen[bytes]]:
    """Start a run that writes rows into a folder; kill it at the end."""
    temporary.mkdir(exist_ok=True)
    words = ["run", str(PLANAR_2R), "-o", str(folder), "--realtime", *LONG]
    environment = os.environ | {"TMPDIR": str(temporary)}
    process = subprocess.Popen(
        [sys.executable, "-m", "cardsflow_fmu.cli", *words], env=environment, stderr=-3
    )
    try:
        table = folder / "results.csv"
        while not (table.is_file() and table.read_bytes().count(b"\n") > 1):
            assert process.poll() is None
            time.sleep(0.02)
        yield process
    finally:
        process.kill()
        process.wait()


@pytest.mark.slow
def test_second_run_into_a_folder_is_rejected_with_the_first_process(
    tmp_path: Path, cardsflow: CommandLine, monkeypatch: pytest.MonkeyPatch
) -> None:
    out, temporary = tmp_path / "out", tmp_path / "temporary"
    with running(out, temporary) as first:
        message = cardsflow.error_line("run", PLANAR_2R, "--coupling", "direct", "-o", out, *SHORT)
        holder = f"run of process {first.pid} on {socket.gethostname()} since 2"
        assert holder in message
        (out / f".summary.json.{first.pid}.cardsflow.tmp").write_text("half")
    assert list(temporary.iterdir()), "a killed process leaves its temporary files"
    monkeypatch.setattr("tempfile.tempdir", str(temporary))
    from cardsflow_fmu.utils import temporary as module

    module._remove_abandoned.cache_clear()
    code, _, err = cardsflow("run", PLANAR_2R, "--coupling", "direct", "-o", out, *SHORT)
    assert code == 0, err
    assert list(temporary.iterdir()) == []
    assert not [path.name for path in out.iterdir() if path.name.startswith(".")]
    assert json.loads((out / "summary.json").read_text())["status"] == "complete"


def test_temporary_folders_in_use_or_of_others_are_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from cardsflow_fmu.utils import temporary

    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    for name in ("cardsflow-main", "cardsflow_tmp_", "cardsflow_tmp_users"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "mine.txt").write_text("mine")
    (tmp_path / "cardsflow_tmp_link").symlink_to(tmp_path / "cardsflow-main")
    (tmp_path / "cardsflow_tmp_empty").mkdir()
    (tmp_path / "cardsflow_tmp_dead").mkdir()
    (tmp_path / "cardsflow_tmp_dead" / LOCK).write_text("temporary files of process 1\n")
    used = temporary.TemporaryFolder()
    temporary._remove_abandoned.cache_clear()
    temporary._remove_abandoned()
    names = {path.name for path in tmp_path.iterdir()}
    kept = {"cardsflow-main", "cardsflow_tmp_", "cardsflow_tmp_users", "cardsflow_tmp_link"}
    assert names == {*kept, used.path.name}
    used.remove()
    assert {path.name for path in tmp_path.iterdir()} == kept


@pytest.mark.slow
def test_concurrent_locks_are_acquired_one_at_a_time(tmp_path: Path) -> None:
    """The owner of a lock deletes its file, and never while another program uses it."""
    inside, most, done = [0], [0], [0]

    def work() -> None:
        while done[0] < 300:
            try:
                with lock_folder(tmp_path, "test"):
                    inside[0] += 1
                    most[0] = max(most[0], inside[0])
                    time.sleep(0)
                    inside[0] -= 1
                    done[0] += 1
            except InputError:
                continue

    threads = [threading.Thread(target=work) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert most == [1]
    assert list(tmp_path.iterdir()) == []


CALIBRATE = ["calibrate", "nothing.csv", "--parameters", "x", "--robot", PLANAR_2R / "robot", "-o"]
EXCITE = ["excite", "nothing.urdf", "-o"]
CONVERT = ["convert", PLANAR_2R / "robot", "--to", "mjcf", "-o"]


BUILD = pytest.param(["build", PLANAR_2R, "-o"], marks=pytest.mark.slow)


@pytest.mark.parametrize("words", [CALIBRATE, EXCITE, CONVERT, BUILD], ids=lambda words: words[0])
def test_commands_that_write_folders_use_the_lock(
    tmp_path: Path, words: list[object], cardsflow: CommandLine
) -> None:
    with lock_folder(tmp_path, "test"):
        message = cardsflow.error_line(*words, tmp_path)
    assert f"another program uses this folder (test of process {os.getpid()}" in message
    (tmp_path / ".robot.sdf.1.cardsflow.tmp").write_text("of one that was killed")
    if words[0] not in ("build", "convert"):
        assert "nothing." in cardsflow.error_line(*words, tmp_path)
        assert list(tmp_path.iterdir()) == []
        assert "nothing." in cardsflow.error_line(*words, tmp_path / "not/there")
        assert list(tmp_path.iterdir()) == []
        (tmp_path / "mine.txt").write_text("mine")
        assert "choose a new folder" in cardsflow.error_line(*words, tmp_path)
        assert "choose a new folder" in cardsflow.error_line(*words, tmp_path / "mine.txt")


@pytest.mark.parametrize("kind", ["folder", "link"])
def test_lock_that_is_not_a_file_is_rejected(tmp_path: Path, kind: str) -> None:
    if kind == "folder":
        (tmp_path / LOCK).mkdir()
    else:
        (tmp_path / "mine").write_text("mine")
        (tmp_path / LOCK).symlink_to(tmp_path / "mine")
    with pytest.raises(InputError, match="cannot be written"), OutputFolder(tmp_path):
        pass
    assert kind == "folder" or (tmp_path / "mine").read_text() == "mine"


def test_unused_lock_file_is_ignored(tmp_path: Path) -> None:
    (tmp_path / LOCK).write_text("run of process 1 on elsewhere since 2020\n")
    with ExitStack() as stack:
        stack.enter_context(OutputFolder(tmp_path))
        with pytest.raises(InputError, match=f"process {os.getpid()}"), OutputFolder(tmp_path):
            pass
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_interrupted_run_releases_the_folder(tmp_path: Path) -> None:
    with running(tmp_path / "out", tmp_path / "temporary") as process:
        process.send_signal(signal.SIGINT)
        assert process.wait() == 130
    assert not (tmp_path / "out" / LOCK).exists()
    assert list((tmp_path / "temporary").iterdir()) == []
