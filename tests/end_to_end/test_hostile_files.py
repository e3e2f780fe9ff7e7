"""Files that are designed to cause a crash, an endless loop or excessive memory are rejected."""

from __future__ import annotations

import json
import shutil
import struct
import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from support.robots.robots import PLANAR_2R

from cardsflow_fmu.cli.main import main
from cardsflow_fmu.hardware.protocol.recording_header import RecordingHeader, header_data
from cardsflow_fmu.utils.archive import write_archive

HEADER = RecordingHeader(("f.a",), ("N",), ("q.a",), ("rad",), 1, 1e-3)
MAGIC = b"\x89MCAP0\r\n"


def sdf(body: str) -> str:
    return f'<sdf version="1.9"><model name="a">{body}</model></sdf>'


def frames_in_a_circle(folder: Path) -> str:
    frames = (f'<frame name="f{k}" attached_to="f{(k + 1) % 2000}"/>' for k in range(2000))
    (folder / "a.sdf").write_text(
        sdf('<link name="b"><pose relative_to="f0"/></link>' + "".join(frames))
    )
    return "info a.sdf"


def model_that_includes_itself(folder: Path) -> str:
    (folder / "a.sdf").write_text(sdf("<include><uri>a.sdf</uri></include>"))
    return "info a.sdf"


def replicas_of_replicas(folder: Path) -> str:
    inner = '<replicate count="1000" offset="1 0 0">' * 9 + "<body/>" + "</replicate>" * 9
    (folder / "a.xml").write_text(f"<mujoco><worldbody>{inner}</worldbody></mujoco>")
    return "info a.xml"


def nested_settings(folder: Path) -> str:
    (folder / "experiment.toml").write_text("a = " + "[" * 100_000)
    return "check experiment.toml"


def nested_header(folder: Path) -> str:
    shutil.copytree(PLANAR_2R, folder, dirs_exist_ok=True)
    header = b"{'descr': " + b"(" * 5000 + b")" * 5000 + b"}"
    (folder / "a.npy").write_bytes(b"\x93NUMPY\1\0" + struct.pack("<H", len(header)) + header)
    return "run . --coupling direct --set reference={file='a.npy'}"


def endless_record(folder: Path) -> str:
    (folder / "a.mcap").write_bytes(MAGIC + struct.pack("<BQ", 6, 2**63))
    return "convert a.mcap --to a.csv"


def negative_array(folder: Path) -> str:
    """The number of elements is positive: it is the product of two negative lengths."""
    array = '<Float64 name="v" valueReference="0">' + '<Dimension start="-5"/>' * 2 + "</Float64>"
    text = (
        '<fmiModelDescription fmiVersion="3.0" modelName="a" instantiationToken="a">'
        f'<CoSimulation modelIdentifier="a"/><ModelVariables>{array}</ModelVariables>'
        "<ModelStructure/></fmiModelDescription>"
    )
    write_archive(folder / "a.fmu", {"modelDescription.xml": text.encode()})
    return "info a.fmu"


def recording(folder: Path, time: float = 0.0, **header: float) -> str:
    head = json.dumps({**header_data(HEADER), **header}).encode()
    body = struct.pack("<dddIIddI", time, 0.0, 0.0, 0, 0, 1.0, 1.0, 0)
    record = body + struct.pack("<I", zlib.crc32(body))
    start = struct.pack("<8sIII", b"CFHWREC\0", 1, len(head), zlib.crc32(head))
    (folder / "a.rec").write_bytes(start + head + record)
    return "replay-hardware a.rec --listen udp://127.0.0.1:0 --duration 0.01"


def tiny_step(folder: Path) -> str:
    return recording(folder, step=1e-308)


def infinite_time(folder: Path) -> str:
    return recording(folder, time=np.inf)


def huge_integer(folder: Path) -> str:
    (folder / "results.csv").write_text("time,a\n0,1\n")
    (folder / "results.units.json").write_text("{}")
    summary = {"status": "complete", "duration": 10**400}
    (folder / "summary.json").write_text(json.dumps(summary))
    return "plot ."


CASES: dict[Callable[[Path], str], str] = {
    frames_in_a_circle: "its pose is relative to itself",
    model_that_includes_itself: "includes exceed 20 levels",
    replicas_of_replicas: "<replicate> creates more than 10000 elements",
    nested_settings: "is nested too deeply",
    nested_header: "is not a valid NumPy file",
    endless_record: "a record exceeds the maximum file size",
    negative_array: "the length of an array must not be negative",
    tiny_step: "step must be at least 1e-06 s",
    infinite_time: "the time of row 1 is inf",
    huge_integer: "duration: must be within 64 bits",
}


@pytest.mark.parametrize("make", CASES, ids=lambda make: make.__name__)
def test_hostile_file_is_rejected(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    make: Callable[[Path], str],
) -> None:
    monkeypatch.chdir(tmp_path)
    code = main(make(tmp_path).split())
    assert CASES[make] in capsys.readouterr().err
    assert code == 2
