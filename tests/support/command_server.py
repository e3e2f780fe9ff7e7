"""Server that runs commands in forks of a process with all imports, to save start time.

    python -m support.command_server SOCKET --import MODULES

waits for clients, and

    python -I -S command_server.py SOCKET cardsflow check robot
    python -I -S command_server.py SOCKET script.py

run a command or a script in the client's folder and environment, with its input and output.
"""

from __future__ import annotations

import json
import os
import socket
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

PRELOADED = (
    "cardsflow_fmu.cli.main",
    "cardsflow_fmu.simulation.run",
    "cardsflow_fmu.results.report.run_figures",
    "cardsflow_fmu.studies",
    "matplotlib.backends.backend_agg",
    "matplotlib.backends.backend_pdf",
    "matplotlib.backends.backend_svg",
    "scipy.interpolate",
    "scipy.optimize",
)
MAX_MESSAGE = 100_000


@contextmanager
def command_server(
    folder: Path, environment: Mapping[str, str], modules: Sequence[str] = PRELOADED
) -> Iterator[list[str]]:
    """Run a server with imported modules; yield the command of a client, without its arguments."""
    path = folder / "commands"
    tests = str(Path(__file__).parents[1])
    process = subprocess.Popen(
        [sys.executable, "-m", "support.command_server", str(path), "--import", *modules],
        env={**environment, "PYTHONPATH": tests},
        stdout=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    try:
        assert process.stdout.readline() == "ready\n"
        yield [sys.executable, "-I", "-S", __file__, str(path)]
    finally:
        process.kill()
        process.communicate()


def serve(path: str, modules: Sequence[str]) -> None:
    """Import modules, and serve each client in a fork while the parent process exists."""
    import importlib
    import signal

    parent = os.getppid()
    for name in modules:
        importlib.import_module(name)
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # exit statuses are not collected
    with socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET) as server:
        server.bind(path)
        server.listen()
        print("ready", flush=True)
        server.settimeout(5.0)
        while os.getppid() == parent:  # which an interrupt may end without warning
            try:
                connection, _ = server.accept()
            except TimeoutError:
                continue
            if os.fork() == 0:
                server.close()
                signal.signal(signal.SIGCHLD, signal.SIG_DFL)
                _answer(connection)
            connection.close()


def _answer(connection: socket.socket) -> None:
    """Run the command of a client, and end this process."""
    import atexit
    import traceback

    message, files, _, _ = socket.recv_fds(connection, MAX_MESSAGE, 3)
    for number, file in enumerate(files):
        os.dup2(file, number)
        os.close(file)
    asked = json.loads(message)
    os.chdir(asked["folder"])
    os.environ.clear()
    os.environ.update(asked["environment"])
    try:
        code = _run(asked["words"])
    except SystemExit as end:
        code = end.code if isinstance(end.code, int) else int(end.code is not None)
    except BaseException:
        traceback.print_exc()
        code = 1
    atexit._run_exitfuncs()
    sys.stdout.flush()
    sys.stderr.flush()
    connection.sendall(bytes([code & 255]))
    os._exit(0)


def _run(words: list[str]) -> int:
    sys.argv = words
    if words[0] == "cardsflow":
        from cardsflow_fmu.cli.main import main

        return main(words[1:])
    import runpy

    sys.path[0] = str(Path(words[0]).parent)
    runpy.run_path(words[0], run_name="__main__")
    return 0


def ask(path: str, words: list[str]) -> int:
    """Send a command to the server; return its exit code."""
    asked = {"folder": str(Path.cwd()), "environment": dict(os.environ), "words": words}
    with socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET) as connection:
        connection.connect(path)
        socket.send_fds(connection, [json.dumps(asked).encode()], [0, 1, 2])
        answer = connection.recv(1)
    return answer[0] if answer else 137


if __name__ == "__main__":
    if sys.argv[2] == "--import":
        serve(sys.argv[1], sys.argv[3:])
    else:
        sys.exit(ask(sys.argv[1], sys.argv[2:]))
