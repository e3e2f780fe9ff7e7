from __future__ import annotations

import random
import struct
import zlib
from pathlib import Path

import pytest
from fmu_host import Host, cannot_open, load
from toy_model import PORTS

pytestmark = pytest.mark.native


@pytest.fixture
def table(damaged: Path) -> Path:
    return damaged / "resources/ports.bin"


def opens(host: Host, table: Path, content: bytes) -> bool:
    """Whether the FMU opens with this table; says why when it does not."""
    table.write_bytes(content)
    host.messages.clear()
    component = host.instantiate(host.slave.guid, table.parent.as_uri())
    host.slave.fmi2FreeInstance(component)
    assert bool(component) == (not host.messages)
    return bool(component)


def test_missing(damaged: Path, table: Path) -> None:
    table.unlink()
    assert "ports.bin cannot be read: unpack or build the FMU again" in cannot_open(damaged)


def test_truncated(damaged: Path, table: Path) -> None:
    host = load(damaged)
    content = table.read_bytes()
    assert opens(host, table, content)
    for size in range(len(content)):
        assert not opens(host, table, content[:size])
    assert not opens(host, table, content + b"\0")
    host.slave.freeLibrary()


def test_mutated(damaged: Path, table: Path) -> None:
    host = load(damaged)
    content = table.read_bytes()
    rng = random.Random(2)
    for _ in range(300):
        assert not opens(host, table, mutated(content, rng))
    host.slave.freeLibrary()


def test_mutated_with_a_true_checksum(damaged: Path, table: Path) -> None:
    host = load(damaged)
    content = table.read_bytes()
    rng = random.Random(3)
    for _ in range(600):
        wrong = mutated(content[20:], rng)[: rng.choice((None, rng.randrange(len(content))))]
        header = struct.pack("<8sIII", b"CARDSFMU", 1, 20 + len(wrong), zlib.crc32(wrong))
        opens(host, table, header + wrong)
    host.slave.freeLibrary()


@pytest.mark.parametrize("count", [0, len(PORTS) - 1, len(PORTS) + 1, 2**31, 2**32 - 1])
def test_other_counts(damaged: Path, table: Path, count: int) -> None:
    host = load(damaged)
    content = table.read_bytes()
    at = content.index(struct.pack("<IBBB", len(PORTS), 0, 0, 0))
    body = content[20:at] + struct.pack("<I", count) + content[at + 4 :]
    header = struct.pack("<8sIII", b"CARDSFMU", 1, len(content), zlib.crc32(body))
    assert not opens(host, table, header + body)
    host.slave.freeLibrary()


def mutated(content: bytes, rng: random.Random) -> bytes:
    """A few bytes changed, one of them for sure."""
    changed = bytearray(content)
    for _ in range(rng.randint(0, 3)):
        changed[rng.randrange(len(changed))] = rng.randrange(256)
    last = rng.randrange(len(changed))
    changed[last] = (content[last] + rng.randint(1, 255)) % 256
    return bytes(changed)
