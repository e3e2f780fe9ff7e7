"""Secure local Dask cluster (extra `sweep`).

Dask schedulers and workers execute code from every client, and every user of this computer can
connect to them. Therefore all connections require temporary certificates. These are created for
each run, kept in memory and passed to worker processes through pipes. HTTP pages are disabled.
"""

from __future__ import annotations

import logging
from typing import Any

import distributed

from addin_sdfusion.robot import InputError
from cardsflow_fmu.utils.extras import install

_LOCALHOST = "127.0.0.1"
_PROTOCOL = "tls://"


class _WithoutPages:
    """Mixin that disables Dask's HTTP pages, which it serves even without a dashboard."""

    def start_http_server(self, *args: object, **options: object) -> None:
        """Do nothing."""


class QuietScheduler(_WithoutPages, distributed.Scheduler):  # type: ignore[misc]
    """A scheduler without HTTP pages."""


class QuietWorker(_WithoutPages, distributed.Worker):  # type: ignore[misc]
    """A worker without HTTP pages."""


def local_cluster(workers: int) -> Any:
    """Return a cluster with a scheduler and single-threaded worker processes, as a context.

    Args:
        workers: Number of workers.

    Returns:
        The cluster; clients require its `security`.

    Raises:
        InputError: The package cryptography, which creates the certificates, is not installed.
    """
    try:
        security = distributed.Security.temporary()
    except ImportError:
        what = f"requires cryptography: {install('sweep')}"
        raise InputError(what, key="--dask") from None
    common = {"host": _LOCALHOST, "protocol": _PROTOCOL, "security": security}
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
