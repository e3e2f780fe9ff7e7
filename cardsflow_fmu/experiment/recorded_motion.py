"""Reader of recorded motions: CSV, NumPy and OpenSim files, ROS 2 recordings, or rows."""

from __future__ import annotations

import io
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from addin_sdfusion.robot import InputError, UnknownNameError, limits
from addin_sdfusion.robot.files import read_file, write_files
from addin_sdfusion.robot.model.trajectory import Space, Trajectory
from cardsflow_fmu.experiment.config.names import Names
from cardsflow_fmu.utils.archive import open_archive, read_entry
from cardsflow_fmu.utils.arrays import FloatArray
from cardsflow_fmu.utils.csv_table import csv_text, read_csv, require_table
from cardsflow_fmu.utils.opensim_table import FILE_TYPES as OPENSIM
from cardsflow_fmu.utils.opensim_table import joint_columns, read_opensim_table

from .joint_states import RECORDINGS, is_recording, read_joint_states

FILE_TYPES = (".csv", ".npy", ".npz", *OPENSIM, *RECORDINGS)

_UNITS = {"s": 1.0, "ms": 1e-3, "rad": 1.0, "deg": math.pi / 180.0, "m": 1.0, "mm": 1e-3}
_LETTERS: Mapping[Space, str] = {"joint": "q", "operational": "y"}
_ENDINGS = ("", "d", "dd")
_TOO_MANY_NUMBERS = f"has more than {limits.MOTION_VALUES} numbers"

Columns = Mapping[str, FloatArray]


def is_motion(file: Path) -> bool:
    """Return whether a file or folder has the type of a recorded motion."""
    return file.suffix.lower() in FILE_TYPES or is_recording(file)


def read_motion(
    file: Path,
    spaces: Mapping[Space, Names],
    noise: float | None,
    lengths: Sequence[str] = (),
) -> Trajectory:
    """Read the motion in a .csv, .npy, .npz, .mot or .sto file, or in a ROS 2 recording.

    Columns are `time` and, for every name, `q.<name>` or the plain name, and optionally
    `qd.<name>` and `qdd.<name>`; for task coordinates y, yd and ydd. A name may have a unit in
    brackets: `elbow [deg]`. The columns of a .npy without names are time, all positions, and
    optionally all velocities and all accelerations. A .npz has one array per column, or `time`,
    `q`, `qd`, `qdd`. OpenSim files are in degrees if their header specifies it. Other columns are
    ignored.

    Args:
        spaces: Names of joint and task coordinates; the first set with all columns is used.
        noise: Noise of the positions, see `recorded_trajectory`.
        lengths: Names of coordinates that are lengths.

    Raises:
        InputError: The file has no motion of the robot.
    """
    return read_recorded(file, spaces, noise, lengths)[1]


def read_recorded(
    file: Path,
    spaces: Mapping[Space, Names],
    noise: float | None,
    lengths: Sequence[str] = (),
) -> tuple[FloatArray, Trajectory]:
    """Return the times of the rows of a file, in [s], and its motion from 0; see `read_motion`."""
    try:
        columns = _file_columns(file, spaces, lengths)
        return _parse_columns(columns, spaces, noise, file.name)
    except InputError as error:
        error.problem = f"{file.name}: {error.problem}"
        raise


def recorded_names(file: Path, names: Sequence[str], lengths: Sequence[str] = ()) -> list[str]:
    """Return the names of joint coordinates whose positions a file contains; see `read_motion`."""
    spaces: Mapping[Space, Names] = {"joint": Names("coordinate", list(names))}
    columns = _in_si(_file_columns(file, spaces, lengths))
    return [name for name in names if name in columns or f"q.{name}" in columns]


def _file_columns(file: Path, spaces: Mapping[Space, Names], lengths: Sequence[str]) -> Columns:
    """Return the columns of a file by name."""
    if is_recording(file):
        joints = spaces["joint"].names if "joint" in spaces else ()
        return read_joint_states(file, joints).columns()
    if file.suffix.lower() == ".csv":
        names, rows = read_csv(file, kind="table of numbers", most=limits.MOTION_VALUES)
        return dict(zip(names, rows.T, strict=True))
    if file.suffix.lower() in OPENSIM:
        return joint_columns(read_opensim_table(file), lengths)
    return _numpy_columns(file, spaces)


def write_motion(recording: Path, file: Path, *, overwrite: bool = False) -> Path:
    """Write the joint states of a ROS 2 recording as a table of times, positions and velocities.

    Args:
        recording: A .mcap or .db3 file, or a rosbag2 folder.
        overwrite: Whether to replace an existing file.

    Raises:
        InputError: There are no joint states, or the file exists or cannot be written.
    """
    if not is_recording(recording):
        raise InputError(
            f"is not a ROS 2 recording ({', '.join(RECORDINGS)}, or a folder)", file=recording
        )
    if file.exists() and not overwrite:
        raise InputError("already exists; choose another name or use --overwrite", file=file)
    columns = read_joint_states(recording).columns()
    rows = np.stack(list(columns.values()), axis=1)
    return write_files(file.parent, {file.name: csv_text(list(columns), rows)})[0]


def motion_of_rows(rows: Any, spaces: Mapping[Space, Names], noise: float | None) -> Trajectory:
    """Return the motion in rows of times and positions, as in a .npy file.

    Args:
        rows: Shape (m, 1 + n), or more columns with velocities and accelerations; or a structured
            array.
        spaces: Names of joint or task coordinates; the first set is used.
        noise: Noise of the positions, see `recorded_trajectory`.

    Raises:
        InputError: The rows are not a motion of the robot.
    """
    try:
        array = np.asarray(rows)
    except ValueError:
        raise InputError("must be rows of equal length") from None
    return _parse_columns(_columns_of_array(array, spaces), spaces, noise, "samples")[1]


def _numpy_columns(file: Path, spaces: Mapping[Space, Names]) -> Columns:
    if file.suffix.lower() == ".npy":
        array = _array(read_file(file, limits.ARRAYS))
        if _count(array) > limits.MOTION_VALUES:
            raise InputError(_TOO_MANY_NUMBERS)
        return _columns_of_array(array, spaces)
    with open_archive(file, "NumPy file") as archive:
        entries = archive.infolist()
        if sum(entry.file_size for entry in entries) > limits.ARRAYS:
            raise InputError(f"unpacked it {limits.too_large(limits.ARRAYS)}")
        arrays = {
            entry.filename.removesuffix(".npy"): _array(read_entry(archive, entry, limits.ARRAYS))
            for entry in entries
        }
    if sum(map(_count, arrays.values())) > limits.MOTION_VALUES:
        raise InputError(_TOO_MANY_NUMBERS)
    columns: dict[str, FloatArray] = {}
    for name, array in arrays.items():
        numbers = _numbers(array, name)
        if numbers.ndim == 1:
            columns[name] = numbers
        elif numbers.ndim == 2:
            space: Space = "operational" if name.startswith("y") else "joint"
            coords = spaces[space].names if space in spaces else ()
            if numbers.shape[1] != len(coords):
                problem = f"must have one column per coordinate ({', '.join(coords)}), "
                problem += f"not {numbers.shape[1]}"
                raise InputError(problem, key=name)
            columns |= {f"{name}.{one}": numbers[:, k] for k, one in enumerate(coords)}
        else:
            raise InputError(f"must have 1 or 2 dimensions, not {numbers.ndim}", key=name)
    return columns


def _count(array: np.ndarray[Any, Any]) -> int:
    """Return an upper bound of the number of values in an array, including all fields."""
    kind = array.dtype
    fields = [kind[name].shape for name in kind.names or ()]
    return array.size * sum(map(math.prod, fields or [()]))


def _array(data: bytes) -> np.ndarray[Any, Any]:
    try:
        version = np.lib.format.read_magic(stream := io.BytesIO(data))
        read_header = np.lib.format.read_array_header_1_0
        if version != (1, 0):
            read_header = np.lib.format.read_array_header_2_0
        shape, in_columns, kind = read_header(stream)
        if kind.hasobject:
            raise ValueError("it contains Python objects")
        count = math.prod(shape)
        if kind.itemsize * count != len(data) - stream.tell() or not kind.itemsize:
            raise ValueError("its size does not match its shape")
        array = np.frombuffer(data, kind, count, stream.tell())
        return array.reshape(shape, order="F" if in_columns else "C")
    except Exception as error:  # damaged files raise errors of any type
        problem = " ".join(str(error).split())
        raise InputError(f"is not a valid NumPy file: {problem}"[:300]) from None


def _columns_of_array(array: np.ndarray[Any, Any], spaces: Mapping[Space, Names]) -> Columns:
    """Return the columns of an array, by field name or by order."""
    if array.dtype.names is not None:
        return {name: _numbers(array[name], name) for name in array.dtype.names}
    space, coords = next(iter(spaces.items()))
    rows, n = _numbers(array, "rows"), len(coords.names)
    widths = [1 + n * orders for orders in (1, 2, 3)]
    if rows.ndim != 2 or rows.shape[1] not in widths:
        problem = f"must have 1 + {n} columns, time and {', '.join(coords.names)}, or 1 + {n} more"
        raise InputError(f"{problem} for velocities, and accelerations; its shape is {rows.shape}")
    letters = [_LETTERS[space] + ending for ending in _ENDINGS]
    names = ["time", *(f"{letter}.{name}" for letter in letters for name in coords.names)]
    return dict(zip(names, rows.T, strict=False))


def _numbers(array: np.ndarray[Any, Any], name: str) -> FloatArray:
    if array.dtype.kind not in "fiu":
        raise InputError(f"must contain numbers, not {array.dtype}", key=name)
    return np.asarray(array, dtype=np.float64)


def _parse_columns(
    columns: Columns, spaces: Mapping[Space, Names], noise: float | None, name: str
) -> tuple[FloatArray, Trajectory]:
    """Return the times of the rows, and the motion from 0."""
    from controllers.references.recorded import recorded_trajectory

    columns = _in_si(columns)
    if "time" not in columns:
        raise UnknownNameError("column", "time", columns)
    if len({column.shape for column in columns.values()}) != 1:
        raise InputError("has columns of different lengths")
    rows = np.stack(list(columns.values()), axis=1)
    require_table(list(columns), rows, None, kind="table of numbers")
    space = _space(columns, spaces)
    letter, names = _LETTERS[space], spaces[space].names
    q, qd, qdd = (_rows(columns, letter + end, names, bare=not end) for end in _ENDINGS)
    if qd is None and qdd is not None:
        raise InputError(f"has accelerations without velocities {letter}d.{names[0]}, ...")
    assert q is not None
    if len(q) > limits.MOTION_ROWS or q.size > limits.MOTION_POSITIONS:
        most = f"{limits.MOTION_ROWS} rows or {limits.MOTION_POSITIONS} positions"
        raise InputError(
            f"has more than {most}; use fewer rows per second, or a part of the motion"
        )
    times = columns["time"]
    moved = times - times[:1]
    return times, recorded_trajectory(moved, q, qd, qdd, noise=noise, name=name, space=space)


def _in_si(columns: Columns) -> dict[str, FloatArray]:
    """Return the columns in SI units, by name without unit."""
    si_columns: dict[str, FloatArray] = {}
    for name, column in columns.items():
        bare_name, factor = name.strip(), 1.0
        if bare_name.endswith("]") and "[" in bare_name:
            bare_name, _, unit = bare_name[:-1].rpartition("[")
            bare_name, unit = bare_name.rstrip(), unit.partition("/")[0].strip()
            if unit not in _UNITS:
                raise UnknownNameError("unit", unit, _UNITS, key=name)
            factor = _UNITS[unit]
        if bare_name in si_columns:
            raise InputError(f"has two columns {bare_name!r}", key=name)
        with np.errstate(invalid="ignore"):  # for signalling NaNs
            si_columns[bare_name] = column * factor
    return si_columns


def _space(columns: Columns, spaces: Mapping[Space, Names]) -> Space:
    """Return the first set of coordinates with all position columns."""
    missing: dict[Space, list[str]] = {}
    for space, axes in spaces.items():
        letter = _LETTERS[space]
        missing[space] = [
            name for name in axes.names if name not in columns and f"{letter}.{name}" not in columns
        ]
        if axes.names and not missing[space]:
            return space
    space = next(iter(spaces))
    first = missing[space][0]
    expected = [f"{_LETTERS[each]}.{name}" for each, axes in spaces.items() for name in axes.names]
    problem = f"has no column {_LETTERS[space]}.{first} or {first}"
    has = _shorten(list(columns))
    raise InputError(f"{problem}; it has {has}; the robot has {_shorten(expected)}")


def _shorten(names: Sequence[str], most: int = 12) -> str:
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return ", ".join(names[:most]) + more


def _rows(columns: Columns, letter: str, names: Sequence[str], *, bare: bool) -> FloatArray | None:
    """Return the columns of all names, shape (m, n); None if no column exists."""
    selected = [columns.get(f"{letter}.{n}", columns.get(n) if bare else None) for n in names]
    if all(column is None for column in selected):
        return None
    for column, name in zip(selected, names, strict=True):
        if column is None:
            raise InputError(f"has no column {letter}.{name}, but columns of other coordinates")
    rows = np.stack([column for column in selected if column is not None], axis=1)
    if not np.isfinite(rows).all():
        k, j = (int(i) for i in np.argwhere(~np.isfinite(rows))[0])
        raise InputError(f"row {k + 1} of {letter}.{names[j]} is {rows[k, j]}")
    return rows
