"""The Python end of a worker process, which the C library starts beside other hosts."""

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
        version: Of this package, as the FMU needs it.
        resources: Folder of the FMU's resources.
        links: What the library finds the host by.
    """
    for name in ("SIGINT", "SIGHUP"):  # Ctrl-C, or a closed terminal, is the host's to handle
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), signal.SIG_IGN)
    if sys.stderr is not None:
        faulthandler.enable()
    runtime = ctypes.CDLL(library)
    if version != __version__:
        reason = f"has cardsflow {__version__}"
        code = runtime.cardsflow_worker_refuse(links.encode(), reason.encode())
    else:
        folder = os.fsencode(resources)
        code = runtime.cardsflow_worker_run(links.encode(), folder, version.encode())
    for stream in (sys.stdout, sys.stderr):
        if stream is not None:
            stream.flush()
    # What a model has loaded may crash or wait while it is taken down.
    os._exit(code)
