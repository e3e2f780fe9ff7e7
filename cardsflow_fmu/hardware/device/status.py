"""Events of a device: state changes and rejected runs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from cardsflow_fmu.hardware.protocol.handshake import REJECTION_REASONS, ErrorCode

from .device import Device


@dataclass(frozen=True, slots=True)
class Event:
    """State change of a device, or a rejected run.

    Attributes:
        state: New state of the device, or "rejected" for a rejected run.
        reason: Text of the reason; may be empty.
    """

    state: str
    run: int
    reason: str

    def __str__(self) -> str:
        """Return the event as one line."""
        reason = f": {self.reason}" if self.reason else ""
        return f"run {self.run:08x} {self.state}{reason}"


class StatusReporter:
    """Reporter of the state changes of a device.

    A reason to reject runs is reported once per run.

    Args:
        lateness: Function that returns the maximum lateness of the device in the run, in [s].
    """

    def __init__(
        self,
        device: Device,
        report: Callable[[Event], object],
        lateness: Callable[[], float] = float,
    ) -> None:
        self._device, self._report, self._lateness = device, report, lateness
        self._before = (device.run_id, device.state, device.failure)
        self._counted = dict(device.counters)
        self._rejected: set[ErrorCode] = set()

    def update(self) -> None:
        """Report all changes since the last update."""
        device = self._device
        now = (device.run_id, device.state, device.failure)
        if now != self._before:
            if now[0] != self._before[0]:
                self._rejected.clear()
            self._before = now
            if device.run_id:
                self._report(Event(device.state, device.run_id, self._reason()))
        for code in ErrorCode:
            if self._is_new(code.name.lower()) and code not in self._rejected:
                self._rejected.add(code)
                self._report(Event("rejected", device.run_id, REJECTION_REASONS[code]))

    def _reason(self) -> str:
        device, agreed = self._device, self._device.agreed
        expired, stopped = self._is_new("watchdog"), self._is_new("stops")
        if device.failure and device.state == "safe":
            return device.failure
        if agreed is None:
            return ""
        if device.state == "safe":
            late = 1e3 * self._lateness()
            timeout = f"no command for {agreed.watchdog:g} s"
            timeout += f" (this device was late by up to {late:.3g} ms)"
            return timeout if expired else "stopped on request" if stopped else ""
        if device.state == "ready":
            mode = "in lockstep" if agreed.lockstep else "in real time"
            return f"{mode}, one command per {agreed.step:g} s, watchdog {agreed.watchdog:g} s"
        return ""

    def _is_new(self, counter: str) -> bool:
        """Return whether a counter has increased since the last call for this counter."""
        count = self._device.counters[counter]
        has_increased = count > self._counted.get(counter, 0)
        self._counted[counter] = count
        return has_increased
