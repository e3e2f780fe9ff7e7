"""Every command and every piece of Python in README, docs and examples runs, as by a reader.

Each document has a folder of its own with the examples in it, and its blocks run there one after
another. What a comment before a block may say is in `documents`.
"""

from __future__ import annotations

import os
import re
import shlex
import shutil
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from support import documents
from support.command_server import command_server
from support.documents import ROOT, Block, blocks

MAX_WAIT = 1200.0
"""Of a block, in [s]."""
_WATCHDOG = "--watchdog 60000"
_PATIENT = " ".join(
    f"--set {setting}"
    for setting in (
        *("hardware.max_missed=100000", "hardware.watchdog=60", "hardware.timeout=60"),
        *("hardware.position_margin=1000", "run.accept=any"),
    )
)
"""What lets a run and its device continue where either side has to wait for a busy machine."""

_ENVIRONMENT = {
    "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}",
    "MPLBACKEND": "Agg",
    "BROWSER": "true",
    "PYTHONUNBUFFERED": "1",
    "CARDSFLOW_CFLAGS": "",
}
_COMPILE = """
import sys
sys.path.insert(0, sys.argv[1])
import hatch_build
hatch_build.write_headers()
hatch_build.compile_libraries(hatch_build.ROOT, ["-O0"])  # further flags: equal ones for all
"""
_SHELL = """
set -euo pipefail
uv() { shift; "$@"; }
cardsflow() {
    if [ "$1" = run ] && [ "${2##*.}" != ssp ]; then $CARDSFLOW "$@" $RUN_WITH
    else $CARDSFLOW "$@"; fi
}
"""


def runnable() -> list[Path]:
    """The documents with blocks that run; those with most blocks first."""
    every = [*documents.documents(), *documents.example_documents()]
    run = {file: sum(_runs(block) for block in blocks(file)) for file in every}
    return sorted(filter(run.__getitem__, every), key=run.__getitem__, reverse=True)


def _runs(block: Block) -> bool:
    known = block.language in ("sh", "bash", "python", "diff")
    return known and block.argument(documents.NOT_RUN) is None


@pytest.mark.slow
@pytest.mark.first
@pytest.mark.parametrize("file", runnable(), ids=lambda file: str(file.relative_to(ROOT)))
def test_all_blocks_run(file: Path, tmp_path: Path, client: list[str]) -> None:
    folder = tmp_path / "clone"
    shutil.copytree(ROOT / "examples", folder / "examples", ignore=_results)
    run = [block for block in blocks(file) if _runs(block)]
    place = Place(folder, client, [block for block in run if block.language == "diff"])
    for block in run:
        place.run(block)


@pytest.fixture(scope="module")
def client(tmp_path_factory: pytest.TempPathFactory) -> Iterator[list[str]]:
    """What runs a command or a script without the time that it takes to start."""
    folder = tmp_path_factory.mktemp("server")
    with command_server(folder, {**os.environ, **_ENVIRONMENT}) as command:
        yield command


def _results(folder: str, names: list[str]) -> list[str]:
    return [name for name in names if name == "results"]


class Place:
    """Folder in which the blocks of a document run.

    Args:
        folder: The folder, with the examples.
        client: Command that runs `cardsflow` or a script in a running server.
        patches: All patches of the document.
    """

    def __init__(self, folder: Path, client: list[str], patches: list[Block]) -> None:
        self.folder, self._before, self._port = folder, "", _free_port()
        self._client, self._patches = client, patches
        self._changed: Path | None = None

    def run(self, block: Block) -> None:
        """Run a block; fails with what it said."""
        if block.language == "diff":
            self._change_sources()
        elif block.language == "python":
            self._python(block)
        elif block.argument(documents.UNTIL_INTERRUPTED) is not None:
            for line in _lines(block):
                self._until_interrupted(f"{line} --no-browser", block)
        elif block.argument(documents.SIDE_BY_SIDE) is not None:
            self._side_by_side(block)
        else:
            self._shell(block)

    def _shell(self, block: Block) -> None:
        self._finish(["bash", "-c", _SHELL + block.text], block)

    def _python(self, block: Block) -> None:
        goes_on = block.argument(documents.CONTINUES) is not None
        self._before = (self._before if goes_on else "") + block.text
        file = self.folder / "block.py"
        file.write_text(self._before)
        python = self._client if self._changed is None else [sys.executable]
        self._finish([*python, str(file)], block)

    def _change_sources(self) -> None:
        """Apply all patches to a copy of the source tree at the first one, and compile it once."""
        if self._changed is not None:
            return
        self._changed = self.folder.parent / "changed"
        for name in ("addin_sdfusion", "cardsflow_fmu", "controllers", "sim_dart"):
            unwanted = shutil.ignore_patterns("__pycache__")
            shutil.copytree(ROOT / name, self._changed / name, ignore=unwanted)
        shutil.copy(ROOT / "hatch_build.py", self._changed)
        patch = ["patch", "--strip=1", "--batch", "--fuzz=0", f"--directory={self._changed}"]
        for block in self._patches:
            done = subprocess.run(
                patch, input=block.text, capture_output=True, text=True, check=False
            )
            assert done.returncode == 0, f"{block}\n{done.stdout}{done.stderr}"
        if any("csrc/" in block.text for block in self._patches):
            compile_all = [sys.executable, "-P", "-c", _COMPILE, str(self._changed)]
            self._finish(compile_all, self._patches[0])

    def _side_by_side(self, block: Block) -> None:
        *others, last = _lines(block)
        opened = []
        try:
            for line in others:
                process = self._open(f"{line.partition('#')[0]} {_WATCHDOG}")
                opened.append(process)
                _wait_for("listening", process, block)
            self._finish(["bash", "-c", _SHELL + self._here(last)], block)
        finally:
            for process in opened:
                _interrupt(process)

    def _until_interrupted(self, line: str, block: Block) -> None:
        process = self._open(line)
        try:
            _wait_for("http://", process, block)
        finally:
            code = _interrupt(process)
        assert code in (0, 1, 130), f"{block}: exit code {code}"

    def _open(self, line: str) -> subprocess.Popen[str]:
        return subprocess.Popen(
            ["bash", "-c", "exec " + self._here(line)],
            cwd=self.folder,
            env=self._environment(),
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )

    def _here(self, line: str) -> str:
        """A port that nobody else has."""
        return line.replace("5005", str(self._port))

    def _finish(self, command: list[str], block: Block) -> None:
        done = subprocess.run(
            command,
            cwd=self.folder,
            env=self._environment(_added_to_runs(block)),
            capture_output=True,
            text=True,
            check=False,
            timeout=MAX_WAIT,
        )
        said = f"{done.stdout[-2000:]}\n{done.stderr[-4000:]}"
        assert done.returncode == 0, f"{block}: exit code {done.returncode}\n{block.text}\n{said}"

    def _environment(self, run_with: str = "") -> dict[str, str]:
        own = {"RUN_WITH": run_with, "CARDSFLOW": shlex.join([*self._client, "cardsflow"])}
        if self._changed is not None:
            own |= {"PYTHONPATH": str(self._changed), "CARDSFLOW": "command cardsflow"}
        return {**os.environ, **_ENVIRONMENT, **own}


def _lines(block: Block) -> list[str]:
    return [line.split("  #")[0].strip() for line in block.text.splitlines() if line.strip()]


def _free_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taken:
        taken.bind(("127.0.0.1", 0))
        return int(taken.getsockname()[1])


def _wait_for(word: str, process: subprocess.Popen[str], block: Block) -> None:
    """Until a process says the word."""
    said = []
    for line in _said(process):
        said.append(line)
        if word in line:
            return
    raise AssertionError(f"{block}: ended without {word!r}\n{''.join(said)}")


def _said(process: subprocess.Popen[str]) -> Iterator[str]:
    assert process.stdout is not None
    begin = time.monotonic()
    while time.monotonic() - begin < MAX_WAIT and (line := process.stdout.readline()):
        yield line


def _added_to_runs(block: Block) -> str:
    """What the block says; on a busy machine, a robot's answers may take their time."""
    by_the_clock = block.argument(documents.SIDE_BY_SIDE) is not None
    return block.argument(documents.RUN_WITH) or (_PATIENT if by_the_clock else "")


def _interrupt(process: subprocess.Popen[str]) -> int:
    """End it as Ctrl-C does; its exit code."""
    process.send_signal(signal.SIGINT)
    try:
        process.communicate(timeout=300)
    except subprocess.TimeoutExpired:
        process.kill()
        process.communicate()
        raise
    return int(process.returncode)


def test_examples_are_run_with_what_users_type() -> None:
    """The two commands of the README are those that the checks before a change run themselves."""
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    steps = (ROOT / ".ci/run").read_text(encoding="utf-8")
    for command in ("uv run cardsflow run examples/planar_2r", "uv run pytest"):
        assert re.search(rf"^{command}$", readme, re.MULTILINE), command
        assert re.search(rf"^{command}$|{command}\b", steps, re.MULTILINE), command
