"""Connection to a Dask scheduler with certificates."""

from __future__ import annotations

import pytest

from addin_sdfusion.robot import InputError
from cardsflow_fmu.studies.execution.dask_executor import dask_executor, dask_warning

pytestmark = pytest.mark.extra("sweep")


def test_a_scheduler_with_certificates_is_used() -> None:
    pytest.importorskip("cryptography")
    import dask
    import distributed

    security = distributed.Security.temporary()
    with distributed.LocalCluster(
        1, processes=False, protocol="tls://", security=security, dashboard_address=":0"
    ) as cluster:
        address = cluster.scheduler_address
        with (
            pytest.raises(InputError, match="no Dask scheduler at tls://"),
            dask_executor(address),
        ):
            pass
        texts = {
            "distributed.comm.tls.ca-file": security.tls_ca_file,
            "distributed.comm.tls.client.key": security.tls_client_key,
            "distributed.comm.tls.client.cert": security.tls_client_cert,
        }
        with (
            dask.config.set(texts),
            dask_executor(address) as executor,
        ):
            assert executor.attempts == 2


@pytest.mark.slow
def test_unencrypted_addresses_cause_a_warning() -> None:
    assert dask_warning("tls://host:8786") is None
    for address in ("tcp://host:8786", "host:8786", "ws://host:8786"):
        assert "can run code on them" in str(dask_warning(address))
