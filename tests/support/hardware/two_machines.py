"""Two machines on one: network namespaces with a cable between, and clocks that differ."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[3]
CLOCK_AHEAD = 100_000
"""By how much the monotonic clock of the device's machine is ahead, in [s]."""


def _run(*words: str) -> bool:
    return subprocess.run(words, capture_output=True, check=False).returncode == 0


@dataclass(frozen=True)
class Machines:
    """Two machines.

    Attributes:
        controller, device: Names of their namespaces.
        controller_address, device_address: Their addresses.
        has_netem: Whether the kernel can shape what goes over the cable.
    """

    controller: str
    device: str
    controller_address: str
    device_address: str
    has_netem: bool

    def command(self, machine: str, words: Sequence[object]) -> list[str]:
        """A command of `cardsflow` on one of them."""
        clock = ["unshare", "--time", "--monotonic", str(CLOCK_AHEAD), "--fork", "--kill-child"]
        python = [sys.executable, "-m", "cardsflow_fmu.cli", *map(str, words)]
        return ["ip", "netns", "exec", machine, *(clock if machine == self.device else []), *python]

    def shape(self, delay: float, jitter: float, loss: float) -> list[object]:
        """Shape both directions; what the kernel cannot do is left to the device's own line.

        Args:
            delay: In [ms].
            jitter: Largest change of it, in [ms].
            loss: From 0 to 1.

        Returns:
            Options of the device.
        """
        if not self.has_netem:
            return ["--delay", delay, "--jitter", jitter, "--loss", loss]
        for machine in (self.controller, self.device):
            shaped = ["delay", f"{delay}ms", f"{jitter}ms", "loss", f"{100 * loss}%"]
            assert _run(
                "tc", "-n", machine, "qdisc", "replace", "dev", "cable", "root", "netem", *shaped
            )
        return []

    def unplug(self) -> None:
        """Take the cable out."""
        assert _run("ip", "-n", self.controller, "link", "set", "cable", "down")


@contextmanager
def two_machines() -> Iterator[Machines | None]:
    """Two machines; None if that is not permitted."""
    names = [f"cf{os.getpid()}{end}" for end in "ab"]
    if sys.platform != "linux" or not (shutil.which("ip") and shutil.which("unshare")):
        yield None
        return
    made = []
    try:
        for name in names:
            if not _run("ip", "netns", "add", name):
                yield None
                return
            made.append(name)
        one, other = names
        cable = ["link", "add", "cable", "netns", one, "type", "veth", "peer", "name", "cable"]
        works = _run("ip", *cable, "netns", other)
        addresses = ["10.213.77.1", "10.213.77.2"]
        for name, address in zip(names, addresses, strict=True):
            works = works and _run("ip", "-n", name, "addr", "add", f"{address}/24", "dev", "cable")
            works = works and _run("ip", "-n", name, "link", "set", "cable", "up")
            works = works and _run("ip", "-n", name, "link", "set", "lo", "up")
        works = works and _run("unshare", "--time", "--monotonic", "1", "--fork", "true")
        tc = shutil.which("tc") is not None
        netem = tc and _run("tc", "-n", one, "qdisc", "replace", "dev", "cable", "root", "netem")
        yield Machines(one, other, *addresses, netem) if works else None
    finally:
        for name in made:
            _run("ip", "netns", "del", name)
