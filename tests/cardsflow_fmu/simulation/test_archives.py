"""Archives that lie about their contents: bounded memory, one line."""

from __future__ import annotations

import io
import tracemalloc
import zipfile
from pathlib import Path

import pytest

from addin_sdfusion.robot import InputError
from cardsflow_fmu.cosim.fmu_description import read_description
from cardsflow_fmu.experiment.recorded_motion import _numpy_columns

SIZE, STATED = 200_000_000, 1_000


def lying_archive(file: Path, name: str) -> None:
    """Write an archive with a member of `SIZE` bytes that is stated to have `STATED` bytes."""
    memory = io.BytesIO()
    with zipfile.ZipFile(memory, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(name, bytes(SIZE))
    size = SIZE.to_bytes(4, "little")
    assert memory.getvalue().count(size) == 2
    file.write_bytes(memory.getvalue().replace(size, STATED.to_bytes(4, "little")))


@pytest.mark.parametrize("name", ["q.npy", "modelDescription.xml"])
def test_member_larger_than_stated_is_not_unpacked(name: str, tmp_path: Path) -> None:
    file = tmp_path / ("motion.npz" if name.endswith("npy") else "plant.fmu")
    lying_archive(file, name)
    tracemalloc.start()
    try:
        with pytest.raises(InputError, match="is not a valid"):
            _numpy_columns(file, {}) if name.endswith("npy") else read_description(file)
        assert tracemalloc.get_traced_memory()[1] < 20_000_000
    finally:
        tracemalloc.stop()


def test_archive_with_a_name_twice_is_rejected(tmp_path: Path) -> None:
    file = tmp_path / "plant.fmu"
    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr("modelDescription.xml", "<one/>")
        with pytest.warns(UserWarning, match="Duplicate name"):
            archive.writestr("modelDescription.xml", "<two/>")
    with pytest.raises(InputError, match=r"two files with the name 'modelDescription\.xml'"):
        read_description(file)
