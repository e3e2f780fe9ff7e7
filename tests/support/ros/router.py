"""A router as rmw_zenoh's, from the package eclipse-zenoh."""

from __future__ import annotations

import json
import socket
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any


def peer(mode: str, **endpoints: list[str]) -> Any:
    """A session of zenoh that finds others by addresses alone."""
    import zenoh

    config = zenoh.Config()
    config.insert_json5("mode", json.dumps(mode))
    config.insert_json5("scouting/multicast/enabled", "false")
    for name in ("connect", "listen"):
        config.insert_json5(f"{name}/endpoints", json.dumps(endpoints.get(name, [])))
    return zenoh.open(config)


@contextmanager
def router_on_loopback() -> Iterator[tuple[Any, int]]:
    """A router, and its port."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    session = peer("router", listen=[f"tcp/127.0.0.1:{port}"])
    yield session, port
    session.close()
