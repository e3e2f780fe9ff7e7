"""Python part of a worker process, which the C library starts for hosts without Python."""

from __future__ import annotations

import ctypes
import faulthandler
import os
import signal
import sys
from typing import NoReturn

from cardsflow_fmu.version import __version__


def main(library: str, version: str, resources: str, links: str) -> NoReturn:
    """Run the model of an FMU for its host, then end this process.

    Args:
        library: The FMU's C library.
        version: Version of this package that the FMU requires.
        resources: Folder of the FMU's resources.
        links: Identifiers by which the library connects to the host.
    """
    for name in ("SIGINT", "SIGHUP"):  # the host handles Ctrl-C and a closed terminal
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), signal.SIG_IGN)
    if sys.stderr is not None:
        faulthandler.enable()
    runtime = ctypes.CDLL(library)
    if version != __version__:
        reason = f"has cardsflow {__version__}"
        code = runtime.cardsflow_worker_reject(links.encode(), reason.encode())
    else:
        folder = os.fsencode(resources)
        code = runtime.cardsflow_worker_run(links.encode(), folder, version.encode())
    for stream in (sys.stdout, sys.stderr):
        if stream is not None:
            stream.flush()
    # modules of a model may crash or wait during shutdown
    os._exit(code)
