"""Model in C with variables in a Python array."""

from __future__ import annotations

import ctypes
import weakref
from collections.abc import Sequence

from addin_sdfusion.robot import InputError, SimulationError
from cardsflow_fmu.cosim.participant import CStep
from cardsflow_fmu.cosim.signals.ports import Port
from cardsflow_fmu.cosim.signals.variables import scalar_variables
from cardsflow_fmu.runtime.port_table import encode_port_table
from cardsflow_fmu.utils.arrays import FloatArray
from cardsflow_fmu.utils.compiled.library import address
from cardsflow_fmu.utils.multiples import StepLengthError
from cardsflow_fmu.version import __version__
from controllers.qp.dual_newton import array_of

from .binding import native_library

_MESSAGE_SIZE = 512  # in bytes
_DISCARDED = 2  # NATIVE_MODEL_DISCARDED in C
_STEP = 1.0  # arbitrary, since only FMU hosts use this entry of the port table


class OpenedModel:
    """Model in C; see `runtime/csrc/loop/opened_model.h`.

    Args:
        file: Contents of its file `native.bin`; see `fields.encode`.
        values: Values of the variables, shape (len(ports),). The model reads and writes them.

    Attributes:
        handle: Handle of the C library.
    """

    def __init__(self, file: bytes, ports: Sequence[Port], values: FloatArray) -> None:
        library = native_library()
        table = encode_port_table(
            scalar_variables(ports), guid="", model_name="", package=__version__, step=_STEP
        )
        message = ctypes.create_string_buffer(_MESSAGE_SIZE)
        handle = library.native_model_open(
            *(file, len(file), table, len(table), values.ctypes.data, message, len(message))
        )
        if not handle:
            raise InputError(message.value.decode("utf-8", "replace"))
        self.handle = ctypes.c_void_p(handle)
        self._values = values  # must outlive the model
        self._library = library
        self._step = library.native_model_step
        weakref.finalize(self, library.native_model_close, self.handle)

    def initialize(self, t: float) -> None:
        """Set the start state."""
        if self._library.native_model_initialize(self.handle, t):
            raise InputError(self.message)

    @property
    def c_step(self) -> CStep:
        """Step of the model as a C function."""
        assert self.handle.value is not None
        return CStep(address(self._step), self.handle.value, self._step_error)

    def step(self, t: float, h: float) -> None:
        """Advance from t to t + h."""
        if code := self._step(self.handle, t, h):
            raise (StepLengthError if code == _DISCARDED else SimulationError)(self.message)

    def _step_error(self, code: int, t: float) -> SimulationError:
        return SimulationError(self.message)

    def get_state(self) -> bytes:
        """Return the state of the model that is not in `values`."""
        data, size = ctypes.c_void_p(), ctypes.c_size_t()
        places = ctypes.byref(data), ctypes.byref(size)
        if self._library.native_model_get_state(self.handle, *places):
            raise SimulationError(self.message)
        return ctypes.string_at(data, size.value)

    def set_state(self, state: bytes) -> None:
        """Restore a state from `get_state`.

        Raises:
            InputError: The bytes are not a state of this model.
        """
        if self._library.native_model_set_state(self.handle, state, len(state)):
            raise InputError(self.message)

    def use(self, law: ctypes.Structure, muscles: ctypes.Structure) -> None:
        """Set the Python callbacks of a controller; they must outlive the controller."""
        failed = self._library.native_model_use(
            self.handle, ctypes.addressof(law), ctypes.addressof(muscles)
        )
        assert not failed

    def array(self, name: str) -> FloatArray:
        """Return a view of an array in the law or the robot model of a controller."""
        return array_of(self._library.native_model_array, self.handle, name)

    @property
    def message(self) -> str:
        """The last error message."""
        text: bytes = self._library.native_model_message(self.handle)
        return text.decode("utf-8", "replace")
