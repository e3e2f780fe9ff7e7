"""The C library for other platforms: that it compiles there, and exports what FMI asks for."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

import pytest

from addin_sdfusion.robot import InputError, UnknownNameError
from cardsflow_fmu import cross
from cardsflow_fmu.runtime.library import library_path, this_platform

sys.path.append(str(Path(__file__).parents[2]))

MAGIC = {
    "x86_64-linux": b"\x7fELF\x02\x01",
    "aarch64-linux": b"\x7fELF\x02\x01",
    "x86_64-windows": b"MZ",
    "x86_64-darwin": b"\xcf\xfa\xed\xfe\x07\x00\x00\x01",
    "aarch64-darwin": b"\xcf\xfa\xed\xfe\x0c\x00\x00\x01",
}

needs_compiler = pytest.mark.skipif(
    importlib.util.find_spec("ziglang") is None, reason="no ziglang: the extra `cross`"
)


@needs_compiler
@pytest.mark.parametrize("platform", MAGIC)
def test_compiles(platform: str, tmp_path: Path) -> None:
    contents = cross.compile_for(platform, tmp_path).read_bytes()
    assert contents.startswith(MAGIC[platform])
    for name in (b"fmi2DoStep", b"fmi2Instantiate", b"cardsflow_worker_run"):
        assert name in contents


@needs_compiler
@pytest.mark.parametrize("platform", ["x86_64-linux", "x86_64-windows", "x86_64-darwin"])
def test_same_input_same_bytes(platform: str, tmp_path: Path) -> None:
    folders = [tmp_path / name for name in ("one", "two")]
    for folder in folders:
        folder.mkdir()
    one, two = (cross.compile_for(platform, folder).read_bytes() for folder in folders)
    assert one == two


def test_own_platform_needs_no_compiler(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    own = this_platform()
    found = cross.libraries_for([own.tuple, own.fmi2 or own.tuple], tmp_path)
    assert found == {own.tuple: library_path()}


def test_without_the_compiler(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    other = "win64" if sys.platform != "win32" else "linux64"
    with pytest.raises(InputError, match=r"pip install 'cardsflow\[cross\]'"):
        cross.libraries_for([other], tmp_path)


def test_bad_platforms(tmp_path: Path) -> None:
    with pytest.raises(UnknownNameError, match="win32"):
        cross.libraries_for(["win32"], tmp_path)
    with pytest.raises(InputError, match="needs a platform"):
        cross.libraries_for([], tmp_path)


def test_flags_are_those_of_the_package() -> None:
    import hatch_build

    plain = [flag for flag in hatch_build.FLAGS if not flag.startswith("-W")]
    (library,) = (one for one in hatch_build.LIBRARIES if one.target.endswith("cardsflow_fmi"))
    assert [*plain, *library.flags] == cross.FLAGS
