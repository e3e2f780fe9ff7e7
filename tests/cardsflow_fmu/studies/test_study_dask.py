"""Security of the local Dask cluster: its workers run only the code of the study."""

from __future__ import annotations

import contextlib
import gc
import os
import socket
import ssl
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from addin_sdfusion.robot import InputError
from cardsflow_fmu.studies.execution.dask_executor import dask_executor, dask_warning

ALERT = b"\x15"  # of TLS

pytestmark = pytest.mark.extra("sweep")


@pytest.fixture(scope="module")
def ports() -> Iterator[list[int]]:
    """Return all ports at which a local cluster listens."""
    psutil = pytest.importorskip("psutil")
    this = psutil.Process()
    before = set(listening(this))  # other tests may have started servers
    with dask_executor("local", 1):
        yield sorted(set(listening(this)) - before)


def listening(this: Any) -> Iterator[int]:
    """Yield the ports at which a process and its children listen."""
    for process in (this, *this.children(recursive=True)):
        for connection in process.net_connections(kind="inet"):
            if connection.status == "LISTEN":
                assert connection.laddr.ip == "127.0.0.1"
                yield connection.laddr.port


def test_only_scheduler_nanny_and_worker_listen(ports: list[int]) -> None:
    assert len(ports) == 3
    assert 8787 not in ports


def test_no_port_answers_without_a_certificate(ports: list[int]) -> None:
    context = ssl.create_default_context()
    context.check_hostname, context.verify_mode = False, ssl.CERT_NONE
    for port in ports:
        for wrap in (lambda s: s, context.wrap_socket):
            answer = b""
            with (
                socket.create_connection(("127.0.0.1", port), timeout=10) as raw,
                contextlib.suppress(OSError),  # any of these calls can be rejected
                contextlib.closing(wrap(raw)) as opened,  # type: ignore[no-untyped-call]
            ):
                opened.sendall(b"GET /status HTTP/1.1\r\n\r\n")
                answer = opened.recv(1000)
            assert answer[:1] in (b"", ALERT)


def is_refused(address: str, security: Any, folder: Path) -> bool:
    import distributed

    try:
        with distributed.Client(address, timeout=3, security=security) as client:
            client.submit(os.mkdir, str(folder)).result(timeout=3)
    except (OSError, RuntimeError):
        return True
    return False


@pytest.mark.parametrize("scheme", ["tcp", "tls"])
def test_an_unauthorised_client_is_rejected(ports: list[int], scheme: str, tmp_path: Path) -> None:
    import distributed

    # other certificates of the same kind
    security = distributed.Security.temporary() if scheme == "tls" else None
    for port in ports:
        assert is_refused(f"{scheme}://127.0.0.1:{port}", security, tmp_path / "mine")
        gc.collect()  # an incomplete client would block the start of the next client
    assert not (tmp_path / "mine").exists()


def test_a_scheduler_with_certificates_is_used() -> None:
    import dask
    import distributed

    security = distributed.Security.temporary()
    with distributed.LocalCluster(
        1, processes=False, protocol="tls://", security=security, dashboard_address=":0"
    ) as cluster:
        address = cluster.scheduler_address
        with (
            pytest.raises(InputError, match="no Dask scheduler at tls://"),
            dask_executor(address, 1),
        ):
            pass
        texts = {
            "distributed.comm.tls.ca-file": security.tls_ca_file,
            "distributed.comm.tls.client.key": security.tls_client_key,
            "distributed.comm.tls.client.cert": security.tls_client_cert,
        }
        with (
            dask.config.set(texts),
            dask_executor(address, 1) as executor,
        ):
            assert executor.attempts == 2


@pytest.mark.slow
def test_unencrypted_addresses_cause_a_warning() -> None:
    assert dask_warning("local") is None
    assert dask_warning("tls://host:8786") is None
    for address in ("tcp://host:8786", "host:8786", "ws://host:8786"):
        assert "can run code on them" in str(dask_warning(address))
