"""The executor of Dask's workers, on this machine or others: extra `sweep`."""

from __future__ import annotations

import contextlib
import gc
import re
import socket
import traceback
from collections.abc import Iterator
from typing import Any

from addin_sdfusion.robot import InputError
from cardsflow_fmu.utils.extras import install

from .executors import ExecutorAdapter

LOCAL = "local"
_PATIENCE = 10.0
_SAFE = ("tls://", "wss://")


@contextlib.contextmanager
def dask_executor(address: str, jobs: int) -> Iterator[ExecutorAdapter]:
    """Dask's workers; Dask itself resubmits the run of a worker that dies.

    The experiment's folder is to be found under the same path on every machine.

    Args:
        address: Of a scheduler, such as `tls://host:8786`; `local` for a cluster on this machine,
            which has certificates of its own.
        jobs: Number of workers of a local cluster.

    Raises:
        InputError: Dask is not installed, there is no scheduler, or `jobs` is not positive.
    """
    try:
        import distributed
    except ImportError:
        what = f"needs Dask: {install('sweep')}"
        raise InputError(what, key="--dask") from None
    dask: Any = distributed
    if jobs < 1:
        raise InputError(f"must be at least 1, not {jobs}", key="jobs")
    if address != LOCAL:
        _require_answer(address)
    with contextlib.ExitStack() as stack:
        target: Any = address
        if address == LOCAL:
            from .dask_cluster import local_cluster

            target = stack.enter_context(local_cluster(jobs))
        try:
            client = stack.enter_context(
                dask.Client(target, timeout=_PATIENCE, set_as_default=False)
            )
        except (OSError, ValueError, TypeError, RuntimeError) as error:
            reason = " ".join(str(error).split())
            _drop_client(error)
            raise InputError(f"no Dask scheduler at {address}: {reason}", key="--dask") from None
        workers = sum(client.nthreads().values()) or 1
        executor = stack.enter_context(client.get_executor(pure=False))
        yield ExecutorAdapter(executor, workers, attempts=2)


def dask_warning(address: str) -> str | None:
    """What is unsafe about a scheduler's address; None if nothing is.

    Args:
        address: As `dask_executor` takes it.
    """
    if address == LOCAL or address.startswith(_SAFE):
        return None
    return (
        f"{address} is not encrypted: whoever reaches scheduler or workers can run code as their "
        "users; give them certificates and use tls://, as docs/how_to/studies.md tells"
    )


def _drop_client(error: BaseException | None) -> None:
    """Collect Dask's half-made client now: while another client starts it would deadlock."""
    while error is not None:
        traceback.clear_frames(error.__traceback__)
        error = error.__context__
    gc.collect()


def _require_answer(address: str) -> None:
    """Reject an address without listener: Dask's own client gives up late, and loudly."""
    _, _, location = address.rpartition("://")
    host, _, port = location.rstrip("/").rpartition(":")
    if not host or not re.fullmatch("[0-9]{1,5}", port) or not 0 < int(port) < 65536:
        what = f"no Dask scheduler at {address}: an address is tls://HOST:PORT, or {LOCAL!r}"
        raise InputError(what, key="--dask")
    try:
        socket.create_connection((host.strip("[]"), int(port)), timeout=_PATIENCE).close()
    except OSError as error:
        reason = error.strerror or str(error)
        raise InputError(f"no Dask scheduler at {address}: {reason}", key="--dask") from None
