"""Python part of an FMU.

Exceptions must not pass through C, so all functions return failures as text.
"""

from __future__ import annotations

import traceback
from collections.abc import Callable
from pathlib import Path

import numpy as np

from addin_sdfusion.robot import CardsflowError, InputError
from cardsflow_fmu.utils.multiples import StepLengthError
from cardsflow_fmu.version import __version__

from .model import FmuModel
from .model_file import load_class, read_model_file
from .port_table import ports_digest

_CLOCK_BYTES = 16


def open_model(resources: str, memory: bytearray | memoryview) -> HostedModel | str:
    """Create the model of an FMU on the memory of its host.

    Args:
        resources: Folder of the FMU's resources.
        memory: Two doubles for time and step length, in [s], then one for each variable.

    Returns:
        The model, or an error message.
    """
    try:
        return HostedModel(_model_factory(Path(resources), memory), memory)
    except BaseException as error:
        return _failure(error)


class HostedModel:
    """Model that is called by C. Methods return None or the text of a failure.

    Args:
        create: Function that creates the model on the host's memory.
        memory: As for `open_model`.
    """

    __slots__ = ("_clock", "_create", "_has_failed", "_model")

    def __init__(self, create: Callable[[], FmuModel], memory: bytearray | memoryview) -> None:
        self._clock = memoryview(memory)[:_CLOCK_BYTES].cast("d")
        self._create = create
        self._model = create()
        self._has_failed = False

    def initialize(self) -> str | None:
        """Go to the start state."""
        try:
            self._model.initialize(self._clock[0])
        except BaseException as error:
            return self._fail(error)
        return None

    def step(self) -> str | None:
        """Advance by the step of the clock. An impossible length is set to 0; see `model.h`."""
        try:
            time, step = self._clock
            self._model.step(time, step)
        except StepLengthError as error:
            self._clock[1] = 0.0
            return _failure(error)
        except BaseException as error:
            return self._fail(error)
        return None

    def reset(self) -> str | None:
        """Restore the start values, with a new model if this one has failed."""
        try:
            self._reset()
        except BaseException as error:
            return self._fail(error)
        return None

    def terminate(self) -> str | None:
        """Release resources outside this process. The variables do not change."""
        try:
            self._model.close()
        except BaseException as error:
            return self._fail(error)
        return None

    def get_state(self) -> bytes | str:
        """Return the state that is not in the variables, or the text of a failure."""
        try:
            return bytes(self._model.get_state())
        except BaseException as error:
            return self._fail(error)

    def set_state(self, state: bytes) -> str | None:
        """Restore a state from `get_state`."""
        try:
            self._model.set_state(state)
        except BaseException as error:
            return self._fail(error)
        return None

    def _reset(self) -> None:
        if not self._has_failed:
            try:
                self._model.reset()
            except Exception:
                self._has_failed = True
        if self._has_failed:
            self._replace()

    def _replace(self) -> None:
        if hasattr(self, "_model"):
            del self._model  # first, because of exclusive resources such as network ports
        self._model = self._create()
        self._has_failed = False

    def _fail(self, error: BaseException) -> str:
        self._has_failed = True
        return _failure(error)


def _model_factory(folder: Path, memory: bytearray | memoryview) -> Callable[[], FmuModel]:
    """Check the versions with which the FMU was built; return its model factory."""
    record = read_model_file(folder)
    if record.package != __version__:
        raise InputError(
            f"this FMU requires cardsflow {record.package}; found {__version__} "
            f"in {Path(__file__).parents[1]}; install that version or build the FMU again"
        )
    model_class = load_class(record.model_class, folder)
    values = np.frombuffer(memory, offset=_CLOCK_BYTES)

    def create() -> FmuModel:
        model = model_class.from_resources(folder, values)
        if ports_digest(model.ports) != record.ports:
            raise InputError(
                f"{record.model_class} has other variables than this FMU; build the FMU again"
            )
        if model.values.ctypes.data != values.ctypes.data:
            raise InputError(f"{record.model_class} does not compute on its host's memory")
        return model

    return create


def _failure(error: BaseException) -> str:
    """Format an exception with its trace; omit the trace for errors of this package."""
    try:
        if isinstance(error, CardsflowError):
            return _plain(str(error))
        summary = "".join(traceback.format_exception_only(error)).strip()
        trace = "".join(traceback.format_exception(error)).strip()
        return _plain(f"{summary}\n{trace}")
    except BaseException:
        return f"{type(error).__name__}, whose message cannot be formatted"


def _plain(text: str) -> str:
    """Return text without characters that C cannot represent."""
    return text.replace("\0", "\\0").encode(errors="backslashreplace").decode()
