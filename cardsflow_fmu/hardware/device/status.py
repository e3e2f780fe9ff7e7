"""Events of a device: changes of its state, and rejected runs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from cardsflow_fmu.hardware.protocol.handshake import REFUSALS, ErrorCode

from .device import Device


@dataclass(frozen=True, slots=True)
class Event:
    """A change of a device.

    Attributes:
        state: The device's state, or "rejected" for a run that it has rejected.
        run: Number of its run.
        reason: The reason, as text; may be empty.
    """

    state: str
    run: int
    reason: str

    def __str__(self) -> str:
        """One line."""
        reason = f": {self.reason}" if self.reason else ""
        return f"run {self.run:08x} {self.state}{reason}"


class StatusReporter:
    """Reports the changes of a device, each once a run."""

    def __init__(self, device: Device, report: Callable[[Event], object]) -> None:
        self._device, self._report = device, report
        self._before = (device.run_id, device.state, device.failure)
        self._counted = dict(device.counters)
        self._refused: set[ErrorCode] = set()

    def update(self) -> None:
        """Report what has changed since the last update."""
        device = self._device
        now = (device.run_id, device.state, device.failure)
        if now != self._before:
            if now[0] != self._before[0]:
                self._refused.clear()
            self._before = now
            if device.run_id:
                self._report(Event(device.state, device.run_id, self._reason()))
        for code in ErrorCode:
            if self._is_new(code.name.lower()) and code not in self._refused:
                self._refused.add(code)
                self._report(Event("refused", device.run_id, REFUSALS[code]))

    def _reason(self) -> str:
        device, agreed = self._device, self._device.agreed
        expired, stopped = self._is_new("watchdog"), self._is_new("stops")
        if device.failure and device.state == "safe":
            return device.failure
        if agreed is None:
            return ""
        if device.state == "safe":
            silence = f"no command for {agreed.watchdog:g} s"
            return silence if expired else "stopped as asked" if stopped else ""
        if device.state == "ready":
            mode = "in lock step" if agreed.lockstep else "in real time"
            return f"{mode}, a command every {agreed.step:g} s, watchdog {agreed.watchdog:g} s"
        return ""

    def _is_new(self, counter: str) -> bool:
        """Return whether a counter has grown since the last call for it."""
        count = self._device.counters[counter]
        grown = count > self._counted.get(counter, 0)
        self._counted[counter] = count
        return grown
