"""WebAssembly module of pages that simulate: the models and the loop of FMUs, in a browser."""

from __future__ import annotations

import importlib.util
import subprocess
import sys
import tempfile
from pathlib import Path

from addin_sdfusion.robot import InputError

from .sources import BROWSER, ROOT, wasm_command

_ADVICE = "install it with `pip install ziglang` (`uv pip install ziglang`), and start again"


def wasm_module() -> bytes:
    """Return the module of the current sources.

    A wheel with `CARDSFLOW_PLATFORMS=all` contains it. Otherwise, the first call compiles it with
    the ziglang package, which takes about half a minute.
    """
    file = ROOT / f"{BROWSER.target}.wasm"
    mark, fingerprint = file.with_suffix(".sha256"), f"{BROWSER.fingerprint()}\n"
    try:
        if mark.read_text("ascii") == fingerprint:
            return file.read_bytes()
    except (OSError, UnicodeDecodeError):
        pass
    if importlib.util.find_spec("ziglang") is None:
        raise InputError(
            f"the simulation for browsers is not compiled, and the compiler is missing; {_ADVICE}"
        )
    module = _compile()
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        _replace(file, module)
        _replace(mark, fingerprint.encode())
    except OSError:
        print("cannot store the module; the next start compiles it again", file=sys.stderr)
    return module


def _compile() -> bytes:
    print("compiling the simulation for browsers, once (about half a minute)", file=sys.stderr)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "module.wasm")
        done = subprocess.run(
            wasm_command(file), cwd=ROOT, capture_output=True, text=True, check=False
        )
        if done.returncode:
            lines = done.stderr.strip().splitlines() or ["no message"]
            raise InputError(f"the compiler of the ziglang package failed: {lines[-1]}")
        return file.read_bytes()


def _replace(file: Path, contents: bytes) -> None:
    """Write a file that other processes may read at the same time."""
    with tempfile.NamedTemporaryFile(dir=file.parent, delete=False) as aside:
        aside.write(contents)
    Path(aside.name).replace(file)
