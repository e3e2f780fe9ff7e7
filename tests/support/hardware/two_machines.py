"""Two emulated machines: network namespaces with a virtual cable and different clocks."""

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
"""Offset of the monotonic clock of the device's machine, in [s]."""


def _run(*words: str) -> bool:
    return subprocess.run(words, capture_output=True, check=False).returncode == 0


@dataclass(frozen=True)
class Machines:
    """Two emulated machines.

    Attributes:
        controller, device: Names of the namespaces.
        controller_address, device_address: Network addresses.
        has_netem: Whether the kernel can emulate faults of the cable.
    """

    controller: str
    device: str
    controller_address: str
    device_address: str
    has_netem: bool

    def command(self, machine: str, words: Sequence[object]) -> list[str]:
        """Return a `cardsflow` command that runs on one of the machines."""
        clock = ["unshare", "--time", "--monotonic", str(CLOCK_AHEAD), "--fork", "--kill-child"]
        python = [sys.executable, "-m", "cardsflow_fmu.cli", *map(str, words)]
        return ["ip", "netns", "exec", machine, *(clock if machine == self.device else []), *python]

    def shape(self, delay: float, jitter: float, loss: float) -> list[object]:
        """Emulate delay and loss in both directions, by the kernel or by options of the device.

        Args:
            delay: Delay, in [ms].
            jitter: Maximum change of the delay, in [ms].
            loss: Fraction of lost packets, from 0 to 1.

        Returns:
            Options for the device; empty if the kernel emulates the faults.
        """
        if not self.has_netem:
            faults = {"delay": 1e-3 * delay, "jitter": 1e-3 * jitter, "loss": loss}
            settings = (f"hardware.emulator.{key}={value}" for key, value in faults.items())
            return [word for setting in settings for word in ("--set", setting)]
        for machine in (self.controller, self.device):
            shaped = ["delay", f"{delay}ms", f"{jitter}ms", "loss", f"{100 * loss}%"]
            assert _run(
                "tc", "-n", machine, "qdisc", "replace", "dev", "cable", "root", "netem", *shaped
            )
        return []

    def unplug(self) -> None:
        """Unplug the cable."""
        assert _run("ip", "-n", self.controller, "link", "set", "cable", "down")


@contextmanager
def two_machines() -> Iterator[Machines | None]:
    """Yield two emulated machines, or None without the required permissions."""
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
