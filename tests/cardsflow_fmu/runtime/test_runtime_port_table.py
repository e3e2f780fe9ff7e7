from __future__ import annotations

import random
import struct
import zlib
from pathlib import Path

import pytest
from support.fmu.fmu_host import STEP, Host, cannot_open, load
from toy_model import PORTS

pytestmark = pytest.mark.native


@pytest.fixture
def table(damaged: Path) -> Path:
    return damaged / "resources/ports.bin"


def opens(host: Host, table: Path, content: bytes) -> bool:
    """Return whether the FMU opens with this table; if it does not, it must log a message."""
    table.write_bytes(content)
    host.messages.clear()
    component = host.instantiate(host.slave.guid, table.parent.as_uri())
    host.slave.fmi2FreeInstance(component)
    assert bool(component) == (not host.messages)
    return bool(component)


def test_missing_table_is_rejected(damaged: Path, table: Path) -> None:
    table.unlink()
    assert "ports.bin cannot be read: unpack or build the FMU again" in cannot_open(damaged)


def test_truncated_table_is_rejected(damaged: Path, table: Path) -> None:
    host = load(damaged)
    content = table.read_bytes()
    assert opens(host, table, content)
    for size in range(len(content)):
        assert not opens(host, table, content[:size])
    assert not opens(host, table, content + b"\0")
    host.slave.freeLibrary()


def test_mutated_table_is_rejected(damaged: Path, table: Path) -> None:
    host = load(damaged)
    content = table.read_bytes()
    rng = random.Random(2)
    for _ in range(300):
        assert not opens(host, table, mutated(content, rng))
    host.slave.freeLibrary()


@pytest.mark.slow
def test_mutated_table_with_correct_checksum_is_rejected(damaged: Path, table: Path) -> None:
    host = load(damaged)
    content = table.read_bytes()
    rng = random.Random(3)
    for _ in range(600):
        wrong = mutated(content[20:], rng)[: rng.choice((None, rng.randrange(len(content))))]
        header = struct.pack("<8sIII", b"CARDSFMU", 2, 20 + len(wrong), zlib.crc32(wrong))
        opens(host, table, header + wrong)
    host.slave.freeLibrary()


N = len(PORTS)


@pytest.mark.parametrize(
    ("values", "variables"),
    [(0, N), (N - 1, N), (N + 1, N), (2**32 - 1, N), (N, N - 1), (N, N + 1), (N, 2**32 - 1)],
)
def test_wrong_counts_are_rejected(damaged: Path, table: Path, values: int, variables: int) -> None:
    assert not opens_changed(damaged, table, (N, N), (values, variables))


@pytest.mark.parametrize("step", [0.0, -1e-3, float("nan"), float("inf")])
def test_impossible_preferred_steps_are_rejected(damaged: Path, table: Path, step: float) -> None:
    assert not opens_changed(damaged, table, (N, N), (N, N), step)


def opens_changed(
    damaged: Path,
    table: Path,
    counts: tuple[int, int],
    new: tuple[int, int],
    step: float = STEP,
) -> bool:
    """Return whether the FMU opens with other counts, or another step, in its table."""
    host = load(damaged)
    content = table.read_bytes()
    at = content.index(struct.pack("<dII", STEP, *counts))
    body = content[20:at] + struct.pack("<dII", step, *new) + content[at + 16 :]
    header = struct.pack("<8sIII", b"CARDSFMU", 2, len(content), zlib.crc32(body))
    opened = opens(host, table, header + body)
    host.slave.freeLibrary()
    return opened


def mutated(content: bytes, rng: random.Random) -> bytes:
    """Return the bytes with a few changes, at least one."""
    changed = bytearray(content)
    for _ in range(rng.randint(0, 3)):
        changed[rng.randrange(len(changed))] = rng.randrange(256)
    last = rng.randrange(len(changed))
    changed[last] = (content[last] + rng.randint(1, 255)) % 256
    return bytes(changed)
