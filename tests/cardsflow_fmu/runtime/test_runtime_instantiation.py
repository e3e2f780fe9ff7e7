from __future__ import annotations

import ctypes
import json
import shutil
from pathlib import Path

import pytest
from fmpy import fmi2
from support.fmu.fmu_host import cannot_open, load, opened, plain_run
from toy_model import ToyModel

from cardsflow_fmu.version import __version__

pytestmark = pytest.mark.native


def test_wrong_guid_is_rejected(toy_fmu: Path) -> None:
    host = load(toy_fmu)
    resources = (toy_fmu / "resources").as_uri()
    assert host.instantiate("{other}", resources) is None
    assert "GUID {other} is not this FMU's" in host.last
    host.slave.freeLibrary()


def test_model_exchange_is_rejected(toy_fmu: Path) -> None:
    host = load(toy_fmu)
    resources = (toy_fmu / "resources").as_uri()
    assert host.instantiate(host.slave.guid, resources, fmi2.fmi2ModelExchange) is None
    assert "for co-simulation" in host.last
    host.slave.freeLibrary()


def test_wrong_package_version_is_rejected(toy_fmu: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CARDSFLOW_FMU_HOST", "in-process")
    monkeypatch.setattr("cardsflow_fmu.runtime.in_process.__version__", "99.0")
    message = cannot_open(toy_fmu)
    assert f"requires cardsflow {__version__}; found 99.0" in message
    assert "\n" not in message


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (None, "No such file"),
        (b"", "Expecting value"),
        (b"\xff\xfe", "decode"),
        (b"[]", "is not a model file of format 1"),
        (b'{"format": 2}', "is not a model file of format 1"),
        (b'{"format": 1, "package": 1}', "requires the strings"),
    ],
)
def test_damaged_model_file_is_rejected(damaged: Path, content: bytes | None, message: str) -> None:
    path = damaged / "resources/model.json"
    path.unlink() if content is None else path.write_bytes(content)
    text = cannot_open(damaged)
    assert message in text
    assert "model.json" in text
    assert "\n" not in text


@pytest.mark.parametrize(
    ("entry", "value", "message"),
    [
        ("class", "no_such_module:ToyModel", "No module named"),
        ("class", "toy_model:NoSuchModel", "NoSuchModel"),
        ("class", "toy_model", "cannot be imported"),
        ("class", "", "cannot be imported"),
        ("class", "toy_model:Port", "is not an FmuModel"),
        ("ports", "0", "has other variables than this FMU"),
    ],
)
def test_wrong_entries_of_the_model_file_are_rejected(
    damaged: Path, entry: str, value: str, message: str
) -> None:
    path = damaged / "resources/model.json"
    entries = json.loads(path.read_text())
    path.write_text(json.dumps({**entries, entry: value}))
    assert message in cannot_open(damaged)


def test_model_with_separate_memory_is_rejected(
    toy_fmu: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(
        ToyModel, "from_resources", classmethod(lambda cls, folder, values: cls(0.0))
    )
    assert "does not compute on its host's memory" in cannot_open(toy_fmu)


@pytest.mark.parametrize("name", ["with space", "grüße", "100%", "a#b", "x+y&z", "日本"])
def test_folder_names(toy_fmu: Path, tmp_path: Path, name: str) -> None:
    copy = Path(shutil.copytree(toy_fmu, tmp_path / name))
    with opened(copy) as (host,):
        host.start()
        assert (host.drive(0, 5) == plain_run(5)).all()


def test_locations(toy_fmu: Path) -> None:
    path = (toy_fmu / "resources").as_posix()
    good = [f"file://{path}", f"file:{path}", f"file://{path}/", f"FILE://localhost{path}//"]
    bad = [path, "", "http://x/y", f"file://elsewhere{path}", f"file://{path}%", "file:///%00"]
    bad += [f"file://{path}%2", f"file://{path}%zz", f"file://{path}x"]
    host = load(toy_fmu)
    for location in good:
        assert host.instantiate(host.slave.guid, location)
        host.slave.fmi2FreeInstance(host.slave.component)
    assert host.messages == []
    for count, location in enumerate(bad, 1):
        assert host.instantiate(host.slave.guid, location) is None
        assert len(host.messages) == count
    host.slave.freeLibrary()


def test_texts_that_are_not_utf8_are_accepted(toy_fmu: Path) -> None:
    host = load(toy_fmu)
    name = host.slave.instanceName.encode()
    callbacks = ctypes.byref(host.callbacks)
    location = (toy_fmu / "resources").as_uri().encode()
    stray = bytes(range(0x80, 0x100)) * 50 + b"\xc3\xbc\xe2\x82"
    for guid in (stray, b"\x80" * 5000, b"\xed\xa0\x80\xf4\x90\x80\x80\xe0\x80\x80"):
        args = (name, 1, guid, location, callbacks, False, False)
        assert host.slave.fmi2Instantiate(*args) is None
    shown = "".join(message.text for message in host.messages)
    assert shown.count("?") == 50 * 128 + 2 + 5000 + 10
    assert "ü" in shown
    host.slave.freeLibrary()


def test_null_strings(toy_fmu: Path) -> None:
    host = load(toy_fmu)
    instantiate = host.slave.fmi2Instantiate
    callbacks = ctypes.byref(host.callbacks)
    host.slave.instanceName = ""
    assert instantiate(None, 1, None, None, callbacks, False, False) is None
    location = (toy_fmu / "resources").as_uri().encode()
    assert instantiate(None, 1, None, location, callbacks, False, False) is None
    assert len(host.messages) == 2
    host.slave.freeLibrary()
