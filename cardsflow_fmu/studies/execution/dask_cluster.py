"""A cluster of Dask on this machine that nobody else can talk to: extra `sweep`.

A scheduler or worker of Dask runs the code of whoever connects to it, and every user of this
machine can connect. So both sides show certificates that are made for the run and leave the memory
of its processes only over pipes, and no pages are served.
"""

from __future__ import annotations

import logging
from typing import Any

import distributed

from addin_sdfusion.robot import InputError
from cardsflow_fmu.utils.extras import install

_HERE = "127.0.0.1"
_PROTOCOL = "tls://"


class _WithoutPages:
    """Dask opens a port for pages about the run even where no dashboard is asked for."""

    def start_http_server(self, *args: object, **options: object) -> None:
        """Open none."""


class QuietScheduler(_WithoutPages, distributed.Scheduler):  # type: ignore[misc]
    """A scheduler without pages."""


class QuietWorker(_WithoutPages, distributed.Worker):  # type: ignore[misc]
    """A worker without pages."""


def local_cluster(workers: int) -> Any:
    """Worker processes of one thread each, and their scheduler, as a context.

    Args:
        workers: Number of workers.

    Returns:
        The cluster; its `security` is what a client needs.

    Raises:
        InputError: The certificates cannot be made, as cryptography is missing.
    """
    try:
        security = distributed.Security.temporary()
    except ImportError:
        what = f"needs cryptography: {install('sweep')}"
        raise InputError(what, key="--dask") from None
    common = {"host": _HERE, "protocol": _PROTOCOL, "security": security}
    worker = {
        "cls": distributed.Nanny,
        "options": {
            **common,
            "nthreads": 1,
            "worker_class": QuietWorker,
            "silence_logs": logging.WARNING,
        },
    }
    scheduler = {"cls": QuietScheduler, "options": {**common, "port": 0, "dashboard": False}}
    return distributed.SpecCluster(
        scheduler=scheduler,
        workers=dict.fromkeys(range(workers), worker),
        worker=worker,
        security=security,
        silence_logs=logging.WARNING,
    )
