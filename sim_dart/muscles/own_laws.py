"""Custom muscle laws in Python: the base class, and the laws of a robot."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from pathlib import Path
from typing import Any, ClassVar

from addin_sdfusion.robot import Robot, SimulationError
from addin_sdfusion.robot.custom_code import call_custom, load_class
from sim_dart.core.arrays import FloatArray

_HALVINGS = 60


class MuscleLaw(ABC):
    """A tension custom law, without memory: what it gives follows from its arguments alone.

    Its class lies in a file next to an experiment, which names it. It is made with the parameters
    from there, once for every muscle.

    Attributes:
        command: What drives it: name, unit, least and greatest value. It is read without running
            the file, and so is written out: `command = ("rest_length", "m", 0.0, 2.0)`. None for a
            passive muscle.
    """

    command: ClassVar[tuple[str, str, float, float] | None] = None

    @abstractmethod
    def tension(self, u: float, length: float, rate: float) -> float:
        """Return the tension, in [N]; below 0 it acts as 0.

        A controller inverts it, so that in u it must grow or fall throughout.

        Args:
            u: The command, within its range, in its unit; 0 of a passive muscle.
            length: Of the path, in [m].
            rate: How fast the path becomes longer, in [m/s].
        """


class OwnLaws:
    """The tension custom laws among those of a robot's muscles; their files are run.

    To the C core such a muscle is an ideal cable, and its command the tension from here.

    Args:
        robot: A valid robot.

    Raises:
        InputError: A file cannot be run, a class is none of a law, or cannot be made.
    """

    def __init__(self, robot: Robot) -> None:
        self._laws: list[_OwnMuscle] = []
        classes: dict[tuple[str, str], type[Any]] = {}
        for k, muscle in enumerate(robot.muscles):
            own = muscle.model.custom
            if own is None:
                continue
            key, file = (own.file, own.name), Path(own.file)
            if key not in classes:
                classes[key] = load_class(file, own.name, MuscleLaw)
            made, parameters = classes[key], dict(muscle.model.parameters)
            law = call_custom(file, lambda made=made, given=parameters: made(**given))  # type: ignore[misc]
            _, _, low, high = own.command or ("", "", 0.0, 0.0)
            self._laws.append(_OwnMuscle(k, muscle.name, file, law, low, high))

    def __bool__(self) -> bool:
        """Whether there are any."""
        return bool(self._laws)

    def forces(self, commands: FloatArray, lengths: FloatArray, rates: FloatArray) -> FloatArray:
        """The commands of the C core: those of muscles with custom laws are their tensions.

        Args:
            commands: Shape (m,), each in the unit of its law.
            lengths: Of the paths, shape (m,), in [m].
            rates: Of the paths, shape (m,), in [m/s].
        """
        forces = commands.copy()
        for own in self._laws:
            k = own.index
            if math.isfinite(commands[k]):
                forces[k] = own.tension(float(commands[k]), float(lengths[k]), float(rates[k]))
        return forces

    def reach(
        self, low: FloatArray, high: FloatArray, lengths: FloatArray, rates: FloatArray
    ) -> None:
        """Set the least and the greatest tensions of these muscles; arguments as of `forces`."""
        for own in self._laws:
            k = own.index
            ends = own.ends(float(lengths[k]), float(rates[k]))
            low[k], high[k] = min(ends), max(ends)

    def invert(
        self, commands: FloatArray, forces: FloatArray, lengths: FloatArray, rates: FloatArray
    ) -> None:
        """Set the commands with which these muscles have the forces, or the nearest ones."""
        for own in self._laws:
            k = own.index
            commands[k] = own.command(float(forces[k]), float(lengths[k]), float(rates[k]))


class _OwnMuscle:
    """A muscle with a custom law."""

    def __init__(
        self, index: int, name: str, file: Path, law: MuscleLaw, low: float, high: float
    ) -> None:
        self.index, self._name, self._file = index, name, file
        self._law, self._low, self._high = law, low, high

    def tension(self, u: float, length: float, rate: float) -> float:
        """Never negative; a command beyond its range acts as the nearest one in it."""
        u = min(max(u, self._low), self._high)
        given = call_custom(self._file, lambda: float(self._law.tension(u, length, rate)))
        if not math.isfinite(given):
            what = f"tension({u!r}, {length!r}, {rate!r}) of muscle {self._name!r} is {given}"
            raise SimulationError(f"{self._file}: {type(self._law).__name__}.{what}")
        return max(given, 0.0)

    def ends(self, length: float, rate: float) -> tuple[float, float]:
        """Tensions at the least and the greatest command."""
        return self.tension(self._low, length, rate), self.tension(self._high, length, rate)

    def command(self, force: float, length: float, rate: float) -> float:
        """Return the command with which it has a force, or the nearest one: by halving."""
        least, most = self.ends(length, rate)
        weak, strong = (self._low, self._high) if least <= most else (self._high, self._low)
        if force >= max(least, most):
            return strong
        for _ in range(_HALVINGS):
            middle = 0.5 * (weak + strong)
            if self.tension(middle, length, rate) >= force:
                strong = middle
            else:
                weak = middle
        return strong
