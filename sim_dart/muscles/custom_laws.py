"""Custom muscle laws in Python: the base class and the laws of a robot."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from functools import partial
from pathlib import Path
from typing import Any, ClassVar

from addin_sdfusion.robot import Robot, SimulationError
from addin_sdfusion.robot.custom_code import call_custom, load_class
from sim_dart.core.arrays import FloatArray

_HALVINGS = 60


class MuscleLaw(ABC):
    """Base class of custom muscle laws. The tension depends only on the arguments of `tension`.

    Define a subclass in a file next to the experiment, and specify the file in the experiment. One
    instance is created for every muscle, with the parameters of the experiment.

    Attributes:
        command: Name, unit, minimum and maximum of the command, or None for a passive muscle. It is
            read without running the file, so it must be a literal:
            `command = ("rest_length", "m", 0.0, 2.0)`.
    """

    command: ClassVar[tuple[str, str, float, float] | None] = None

    @abstractmethod
    def tension(self, u: float, length: float, rate: float) -> float:
        """Return the tension, in [N]. A negative tension is replaced by 0.

        Controllers invert this function. It must be monotonic in u.

        Args:
            u: The command, within its range, in its unit; 0 for a passive muscle.
            length: Length of the path, in [m].
            rate: Lengthening velocity of the path, in [m/s].
        """


class CustomLaws:
    """Custom muscle laws of a robot. Creating this object runs their files.

    The C core treats such a muscle as an ideal cable whose command is the tension of its custom
    law.

    Args:
        robot: A valid robot.

    Raises:
        InputError: A file cannot be run, a class is not a muscle law, or it cannot be created.
    """

    def __init__(self, robot: Robot) -> None:
        self._laws: list[_CustomMuscle] = []
        classes: dict[tuple[str, str], type[Any]] = {}
        for k, muscle in enumerate(robot.muscles):
            custom = muscle.model.custom
            if custom is None:
                continue
            key, file = (custom.file, custom.name), Path(custom.file)
            if key not in classes:
                classes[key] = load_class(file, custom.name, MuscleLaw)
            law_class, parameters = classes[key], dict(muscle.model.parameters)
            law = call_custom(file, partial(law_class, **parameters))  # type: ignore[misc]
            _, _, low, high = custom.command or ("", "", 0.0, 0.0)
            self._laws.append(_CustomMuscle(k, muscle.name, file, law, low, high))

    def __bool__(self) -> bool:
        """Whether any muscle has a custom law."""
        return bool(self._laws)

    def forces(self, commands: FloatArray, lengths: FloatArray, rates: FloatArray) -> FloatArray:
        """Return the commands for the C core. For muscles with custom laws these are tensions.

        Args:
            commands: Muscle commands, shape (m,), each in the unit of its law.
            lengths: Path lengths, shape (m,), in [m].
            rates: Path velocities, shape (m,), in [m/s].
        """
        forces = commands.copy()
        for law in self._laws:
            k = law.index
            if math.isfinite(commands[k]):
                forces[k] = law.tension(float(commands[k]), float(lengths[k]), float(rates[k]))
        return forces

    def reach(
        self, low: FloatArray, high: FloatArray, lengths: FloatArray, rates: FloatArray
    ) -> None:
        """Set the smallest and largest tensions of muscles with custom laws in `low` and `high`."""
        for law in self._laws:
            k = law.index
            ends = law.ends(float(lengths[k]), float(rates[k]))
            low[k], high[k] = min(ends), max(ends)

    def invert(
        self, commands: FloatArray, forces: FloatArray, lengths: FloatArray, rates: FloatArray
    ) -> None:
        """Write the commands of muscles with custom laws that lead to the given forces."""
        for law in self._laws:
            k = law.index
            commands[k] = law.command(float(forces[k]), float(lengths[k]), float(rates[k]))


class _CustomMuscle:
    """Muscle with a custom law."""

    def __init__(
        self, index: int, name: str, file: Path, law: MuscleLaw, low: float, high: float
    ) -> None:
        self.index, self._name, self._file = index, name, file
        self._law, self._low, self._high = law, low, high

    def tension(self, u: float, length: float, rate: float) -> float:
        """Return the tension with the command clipped to its range; never negative."""
        u = min(max(u, self._low), self._high)
        tension = call_custom(self._file, lambda: float(self._law.tension(u, length, rate)))
        if not math.isfinite(tension):
            problem = f"tension({u!r}, {length!r}, {rate!r}) of muscle {self._name!r} is {tension}"
            raise SimulationError(f"{self._file}: {type(self._law).__name__}.{problem}")
        return max(tension, 0.0)

    def ends(self, length: float, rate: float) -> tuple[float, float]:
        """Return the tensions at the smallest and the largest command."""
        return self.tension(self._low, length, rate), self.tension(self._high, length, rate)

    def command(self, force: float, length: float, rate: float) -> float:
        """Return the command that leads to a force, or to the nearest one, by bisection."""
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
