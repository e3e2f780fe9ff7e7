"""Nonces of a device, derived from a secret so that offered runs need no memory."""

from __future__ import annotations

import hmac
import secrets
from collections.abc import Hashable

_SECRET_BYTES = 32


class Nonces:
    """Nonces for the runs that a device offers in its HELLO_ACKs.

    Until the next call of `renew`, a run of a peer always has the same nonce. Without the secret,
    nonces cannot be predicted.
    """

    def __init__(self) -> None:
        self.renew()

    def renew(self) -> None:
        """Replace the secret, so that no earlier nonce occurs again."""
        self._secret = secrets.token_bytes(_SECRET_BYTES)

    def nonce(self, run_id: int, peer: Hashable) -> int:
        """Return the nonce of a run, 64 bits."""
        mac = hmac.digest(self._secret, f"{run_id} {peer!r}".encode(), "sha256")
        return int.from_bytes(mac[:8], "little")
