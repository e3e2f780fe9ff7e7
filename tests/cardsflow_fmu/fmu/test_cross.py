"""C library for other platforms: it compiles and exports the functions of FMI."""

from __future__ import annotations

import importlib.util
import sys
import zipfile
from pathlib import Path

import pytest
from support.cases import sample_cases
from support.robots.robots import EXAMPLES

from addin_sdfusion.robot import InputError, UnknownNameError
from cardsflow_fmu import Experiment, build
from cardsflow_fmu.fmu import platforms as cross
from cardsflow_fmu.models.native.binding import native_library
from cardsflow_fmu.runtime import library, sources
from cardsflow_fmu.runtime.library import library_path, this_platform

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


@pytest.mark.cases(1)
@pytest.mark.cross
@needs_compiler
@pytest.mark.parametrize("platform", sample_cases(MAGIC))
def test_the_library_compiles_for_all_platforms(platform: str, tmp_path: Path) -> None:
    library = cross.compile_for(platform, tmp_path).read_bytes()
    assert library.startswith(MAGIC[platform])
    for name in (b"fmi2DoStep", b"fmi2Instantiate", b"cardsflow_worker_run"):
        assert name in library


@pytest.mark.cross
@needs_compiler
def test_equal_sources_compile_to_equal_bytes(tmp_path: Path) -> None:
    folders = [tmp_path / name for name in ("one", "two")]
    for folder in folders:
        folder.mkdir()
    one, two = (cross.compile_for("x86_64-linux", folder).read_bytes() for folder in folders)
    assert one == two


def test_the_current_platform_needs_no_compiler(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    own = this_platform()
    found = cross.libraries_for([own.tuple, own.fmi2 or own.tuple], tmp_path)
    assert found == {own.tuple: library_path()}


def test_a_missing_compiler_is_an_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    other = "win64" if sys.platform != "win32" else "linux64"
    with pytest.raises(InputError, match="uv sync --extra cross"):
        cross.libraries_for([other], tmp_path)


def test_unknown_platforms_are_rejected(tmp_path: Path) -> None:
    with pytest.raises(UnknownNameError, match="win32"):
        cross.libraries_for(["win32"], tmp_path)
    with pytest.raises(InputError, match="requires at least one platform"):
        cross.libraries_for([], tmp_path)


@pytest.mark.slow
def test_the_package_contains_native_libraries(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Native FMUs contain them by default. If they are missing, the error names a remedy."""
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    native_library()  # path for this machine, before it is replaced
    monkeypatch.setattr(library, "_root", lambda: tmp_path)
    own, other = this_platform(), "x86_64-windows"
    assert other != own.tuple
    target = tmp_path / f"{sources.NATIVE.target}{own.suffix}"
    target.parent.mkdir(parents=True)
    target.write_bytes(b"own")
    message = "this installation contains no prebuilt library for it.*uv sync --extra cross"
    with pytest.raises(InputError, match=message):
        cross.libraries_for([other], tmp_path, native=True)
    experiment = Experiment.load(EXAMPLES / "planar_2r")
    alone = build(experiment, tmp_path / "alone", compute="c")["plant"]
    assert binaries(alone) == {f"binaries/{own.fmi2}/plant{own.suffix}": b"own"}
    prebuilt = tmp_path / sources.PREBUILT / f"{other}.dll"
    prebuilt.parent.mkdir()
    prebuilt.write_bytes(b"other")
    mark = prebuilt.with_suffix(".sha256")
    mark.write_text("of other sources\n")
    assert library.prebuilt_libraries() == {}
    mark.write_text(f"{sources.NATIVE.fingerprint()}\n")
    assert cross.libraries_for(["win64"], tmp_path, native=True) == {other: prebuilt}
    both = build(experiment, tmp_path / "both", compute="c")["plant"]
    assert binaries(both) == binaries(alone) | {"binaries/win64/plant.dll": b"other"}


def binaries(fmu: Path) -> dict[str, bytes]:
    archive = zipfile.ZipFile(fmu)
    return {name: archive.read(name) for name in archive.namelist() if name.startswith("binaries/")}


def test_native_libraries_contain_no_python_host() -> None:
    native, all_of_it = sources.NATIVE.sources(), sources.FMI.sources()
    assert not {name for name in native if name.startswith(f"{sources.RUNTIME}/python/")}
    assert set(native) - set(all_of_it) == {f"{sources.RUNTIME}/native/backend_native.c"}


def test_no_two_c_files_have_the_same_name() -> None:
    """Compilers that put every object file into one folder would overwrite one of them."""
    names = [Path(name).name for name in sources.FMI.sources()]
    assert len(set(names)) == len(names)


def test_the_build_of_the_package_knows_the_platforms() -> None:
    import hatch_build

    assert hatch_build.parse_platforms("") == []
    assert hatch_build.parse_platforms("all") == [*sources.PREBUILT_PLATFORMS, "wasm32"]
    assert hatch_build.parse_platforms("x86_64-windows") == ["x86_64-windows"]
    with pytest.raises(SystemExit, match="no platform win32; platforms: x86_64-linux"):
        hatch_build.parse_platforms("win32")
