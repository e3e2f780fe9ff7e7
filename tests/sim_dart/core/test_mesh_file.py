"""Mesh files with extreme coordinates."""

from __future__ import annotations

import warnings
from pathlib import Path

import pytest

from addin_sdfusion.robot import InputError
from sim_dart.core.mesh_file import read_mesh


@pytest.mark.parametrize("x", ["1e308", "1e17", "-1e9"])
def test_distant_corners_are_rejected(tmp_path: Path, x: str) -> None:
    file = tmp_path / "a.obj"
    file.write_text(f"v {x} 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 2 3 4\n")
    with warnings.catch_warnings(), pytest.raises(InputError):
        warnings.simplefilter("error")
        read_mesh(file)


def test_a_mesh_in_small_units_is_read(tmp_path: Path) -> None:
    file = tmp_path / "a.obj"
    file.write_text("v 9e8 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    corners, faces = read_mesh(file)
    assert (corners.max(), len(faces)) == (9e8, 1)
