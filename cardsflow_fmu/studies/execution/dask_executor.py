"""Executor with the workers of a Dask scheduler (extra `sweep`)."""

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

_TIMEOUT = 10.0
_ENCRYPTED = ("tls://", "wss://")


@contextlib.contextmanager
def dask_executor(address: str) -> Iterator[ExecutorAdapter]:
    """Return an executor with the workers of a Dask scheduler, as a context.

    Dask resubmits the run of a worker that dies. The folder of the experiment must have the same
    path on every computer.

    Args:
        address: Address of the scheduler, such as `tls://host:8786`.

    Raises:
        InputError: Dask is not installed, or the scheduler does not answer.
    """
    try:
        import distributed
    except ImportError:
        what = f"requires Dask: {install('sweep')}"
        raise InputError(what, key="--dask") from None
    dask: Any = distributed
    _require_answer(address)
    with contextlib.ExitStack() as stack:
        try:
            client = stack.enter_context(
                dask.Client(address, timeout=_TIMEOUT, set_as_default=False)
            )
        except (OSError, ValueError, TypeError, RuntimeError) as error:
            reason = " ".join(str(error).split())
            _drop_client(error)
            raise InputError(f"no Dask scheduler at {address}: {reason}", key="--dask") from None
        workers = sum(client.nthreads().values()) or 1
        executor = stack.enter_context(client.get_executor(pure=False))
        yield ExecutorAdapter(executor, workers, attempts=2)


def dask_warning(address: str) -> str | None:
    """Return a warning about an unencrypted scheduler address, or None.

    Args:
        address: Address, see `dask_executor`.
    """
    if address.startswith(_ENCRYPTED):
        return None
    return (
        f"{address} is not encrypted: everyone who can connect to the scheduler or its workers can "
        "run code on them; use certificates and tls://, see docs/how_to/studies.md"
    )


def _drop_client(error: BaseException | None) -> None:
    """Delete Dask's incomplete client now, since it would block the start of another client."""
    while error is not None:
        traceback.clear_frames(error.__traceback__)
        error = error.__context__
    gc.collect()


def _require_answer(address: str) -> None:
    """Reject an address without a server, since Dask's client would only report it much later."""
    _, _, location = address.rpartition("://")
    host, _, port = location.rstrip("/").rpartition(":")
    if not host or not re.fullmatch("[0-9]{1,5}", port) or not 0 < int(port) < 65536:
        what = f"no Dask scheduler at {address}: the address must be tls://HOST:PORT"
        raise InputError(what, key="--dask")
    try:
        socket.create_connection((host.strip("[]"), int(port)), timeout=_TIMEOUT).close()
    except OSError as error:
        reason = error.strerror or str(error)
        raise InputError(f"no Dask scheduler at {address}: {reason}", key="--dask") from None
