"""Commands that read damaged files, with little memory: `python -m support.damaged.trial`.

The kind and the number of a mutation determine its defects. If a mutation takes more than ten
seconds of processor time, SIGPROF ends the process; its last lines contain the number.
"""

from __future__ import annotations

import contextlib
import os
import random
import resource
import shutil
import signal
import sys
import traceback
from functools import cache
from pathlib import Path

from cardsflow_fmu.cli import main

from .kinds import KINDS, SECONDS, Kind, command
from .step import load_once

MEMORY = 2**30
LINE = 4000
NEVER = ("internal error", "Traceback", "Warning:")


def damage_files(kind: Kind, rng: random.Random, folder: Path) -> None:
    """Damage one or two files of a folder."""
    files = sorted(file for file in folder.glob(kind.files) if file.is_file())
    for file in rng.sample(files, min(len(files), rng.choice([1, 1, 2]))):
        kind.damage(rng, file)


def find_fault(kind: Kind, number: int, folder: Path) -> str | None:
    """Run a command on the files in a folder; return its fault, or None."""
    reader = kind.commands[number % len(kind.commands)]
    if callable(reader):
        try:
            with contextlib.redirect_stdout(None), contextlib.redirect_stderr(None):
                reader(folder)
        except Exception:
            return traceback.format_exc()
        return None
    code, err = command(folder, reader)
    lines = err.splitlines()
    if code not in (0, 1, 2) or any(word in err for word in NEVER):
        return f"exit code {code}: {err[:LINE]}"
    if code == 2 and not any(line.startswith("cardsflow: ") for line in lines):
        return f"no message: {err[:LINE]}"
    if any(len(line) > LINE for line in lines):
        return f"a line of {max(map(len, lines))} characters: {err[:300]}"
    return None


def run_mutations(name: str, numbers: range, source: Path, work: Path) -> dict[int, str]:
    """Run mutations of a kind of files.

    Args:
        name: The kind.
        numbers: Numbers of the mutations.
        source: Folder with valid files of the kind.
        work: Folder that does not exist yet.

    Returns:
        The faults, by the numbers of the mutations.
    """
    kind, faults, here = KINDS[name], {}, Path.cwd()
    for number in numbers:
        shutil.copytree(source, work)
        rng = random.Random(f"{name} {number}")
        damage_files(kind, rng, work)
        os.chdir(work)
        print(number, flush=True)
        signal.setitimer(signal.ITIMER_PROF, SECONDS)
        try:
            found = find_fault(kind, number, work)
        finally:
            os.chdir(here)
        if found is not None:
            faults[number] = found
        shutil.rmtree(work)
    signal.setitimer(signal.ITIMER_PROF, 0.0)
    return faults


def trial() -> None:
    """Print the faults; arguments: first number, end, folder of valid files, kinds."""
    first, end, folder = int(sys.argv[1]), int(sys.argv[2]), Path(sys.argv[3])
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    signal.signal(signal.SIGPROF, signal.SIG_DFL)
    main._parser = cache(main._parser)  # takes half of the time of most kinds
    failed = 0
    for name in sys.argv[4:]:
        if name.startswith("step"):
            load_once()  # takes one second per file
        print(name, flush=True)
        faults = run_mutations(name, range(first, end), folder / name, folder / "work")
        for number, text in faults.items():
            print(f"FAULT {name} {number}: {text}", flush=True)
        failed += len(faults)
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    trial()
