"""Damaged STEP files, which are read in forks of a process with the geometry kernel."""

from __future__ import annotations

import os
import signal
import subprocess
import tempfile
import traceback
from collections.abc import Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from cardsflow_fmu.cad import step_process
from cardsflow_fmu.cad.kernel import kernel

from .kinds import SECONDS


def load_once() -> None:
    """Load the kernel in this process, and let `import-cad` read files in forks of it."""
    for module in ("STEPCAFControl", "XCAFDoc", "BRepMesh", "BRepGProp"):
        kernel(module)
    step_process.subprocess = SimpleNamespace(  # type: ignore[assignment]
        run=_run, TimeoutExpired=subprocess.TimeoutExpired
    )


def _run(words: Sequence[str], **_: Any) -> subprocess.CompletedProcess[str]:
    """Replace `subprocess.run` of `step_process`, with the time limit of a damaged file.

    Raises:
        AssertionError: The file takes too long, or the child process fails.
    """
    asked, answer = map(Path, words[-2:])
    with tempfile.TemporaryFile() as messages:
        child = os.fork()
        if child == 0:
            os.dup2(messages.fileno(), 2)
            signal.setitimer(signal.ITIMER_PROF, SECONDS)
            code = 3
            try:
                code = step_process.main(asked, answer)
            except BaseException:
                os.write(2, traceback.format_exc().encode())
            os._exit(code)
        code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        messages.seek(0)
        said = messages.read().decode(errors="replace")
    assert code != -signal.SIGPROF, "takes too long"
    assert code != 3, said
    return subprocess.CompletedProcess(words, code, stderr=said)
