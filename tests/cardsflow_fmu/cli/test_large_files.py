"""Oversized files and pipes are rejected within 1 GB of memory and 10 s."""

from __future__ import annotations

import io
import json
import os
import shutil
import struct
import subprocess
import zipfile
import zlib
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from support.command_server import command_server
from support.robots.robots import PLANAR_2R

pytestmark = pytest.mark.slow

MIB = 2**20
MAX_MEMORY = 1000 * MIB
SECONDS = 10.0  # of processor time
MAX_WAIT = 600.0  # in [s]; ends a test that waits for a pipe


MEASURED = """
import sys, time
from cardsflow_fmu.cli.main import main
begin = time.process_time()
try:
    code = main(sys.argv[1:])
finally:
    status = open("/proc/self/status").read()
    peak = status.partition("VmHWM:")[2].split()[0]
    open("peak", "w").write(f"{peak} {time.process_time() - begin}")
sys.exit(code)
"""

Peak = Callable[..., tuple[int, str, int]]


@pytest.fixture(scope="module")
def peak(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Peak]:
    """Return a function that runs a command in a folder in a separate process.

    It returns exit code, messages, and maximum memory in bytes.
    """
    script = tmp_path_factory.mktemp("server") / "measured.py"
    script.write_text(MEASURED)
    alone = os.environ | {"OPENBLAS_NUM_THREADS": "1"}
    with command_server(script.parent, alone) as client:

        def run(folder: Path, *words: object) -> tuple[int, str, int]:
            done = subprocess.run(
                [*client, str(script), *map(str, words)],
                stdout=subprocess.DEVNULL,
                stderr=subprocess.PIPE,
                cwd=folder,
                env=alone,
                timeout=MAX_WAIT,
                check=False,
            )
            memory, seconds = (folder / "peak").read_text().split()
            assert float(seconds) < SECONDS
            return done.returncode, done.stderr.decode(), 1024 * int(memory)

        yield run


def archive(file: Path, **entries: bytes) -> Path:
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as out:
        for name, data in entries.items():
            out.writestr(name.replace("__", "."), data)
    return file


def description(variables: str, version: str = "2.0", more: str = "") -> bytes:
    return (
        f'<?xml version="1.0"?>{more}<fmiModelDescription fmiVersion="{version}" modelName="a" '
        f'guid="a" instantiationToken="a"><CoSimulation modelIdentifier="a"/>'
        f"<ModelVariables>{variables}</ModelVariables><ModelStructure/></fmiModelDescription>"
    ).encode()


def many_variables(folder: Path) -> Path:
    one = '<ScalarVariable name="v" valueReference="0"><Real/></ScalarVariable>'
    return archive(folder / "a.fmu", modelDescription__xml=description(one * 2_000_000))


def huge_array(folder: Path) -> Path:
    one = '<Float64 name="v" valueReference="0"><Dimension start="2000000000"/></Float64>'
    return archive(folder / "a.fmu", modelDescription__xml=description(one, "3.0"))


def many_laughs(folder: Path) -> Path:
    entities = "".join(f'<!ENTITY a{k} "{f"&a{k - 1};" * 10}">' for k in range(1, 10))
    doctype = f'<!DOCTYPE a [<!ENTITY a0 "ha">{entities}]>'
    data = description('<ScalarVariable name="&a9;"/>', more=doctype)
    return archive(folder / "a.fmu", modelDescription__xml=data)


def many_files(folder: Path) -> Path:
    """Write an archive with a directory of two million files, but without the files."""
    entry = struct.pack("<4s6H3L5H2L", b"PK\x01\x02", *([0] * 16))
    directory = entry * 2_000_000
    end = struct.pack("<4s4H2LH", b"PK\x05\x06", 0, 0, 0xFFFF, 0xFFFF, len(directory), 0, 0)
    (folder / "a.fmu").write_bytes(directory + end)
    return folder / "a.fmu"


def pipe(folder: Path, name: str = "a.fmu") -> Path:
    os.mkfifo(folder / name)
    return folder / name


def sparse(folder: Path, name: str = "a.fmu") -> Path:
    with (folder / name).open("wb") as stream:
        stream.truncate(6_000 * MIB)
    return folder / name


FMUS: dict[str, Callable[[Path], Path]] = {
    "two million variables": many_variables,
    "an array of two thousand million": huge_array,
    "entities of entities": many_laughs,
    "a directory of two million files": many_files,
    "a pipe": pipe,
    "a sparse file": sparse,
}


def rejection_message(result: tuple[int, str, int]) -> str:
    code, err, memory = result
    assert memory < MAX_MEMORY, f"{memory / MIB:.0f} MiB"
    assert code == 2, err
    assert err.startswith("cardsflow: "), err
    assert "internal" not in err
    return err


@pytest.mark.cases(2)
@pytest.mark.parametrize("make", FMUS.values(), ids=FMUS)
def test_oversized_fmu_is_rejected(
    peak: Peak, tmp_path: Path, make: Callable[[Path], Path]
) -> None:
    rejection_message(peak(tmp_path, "info", make(tmp_path)))


def experiment(folder: Path, text: str = "") -> Path:
    shutil.copytree(PLANAR_2R, folder / "example")
    with (folder / "example" / "experiment.toml").open("a") as stream:
        stream.write(text)
    return folder / "example"


@pytest.mark.cases(2)
@pytest.mark.parametrize("name", ["a.ssp", "experiment.toml", "model.sdf", "a_bodies.xml"])
@pytest.mark.parametrize("make", [pipe, sparse], ids=["pipe", "sparse"])
def test_pipe_or_oversized_file_is_rejected(
    peak: Peak, tmp_path: Path, name: str, make: Callable[[Path, str], Path]
) -> None:
    command = "info" if name.endswith((".ssp", ".sdf", ".xml")) else "run"
    rejection_message(peak(tmp_path, command, make(tmp_path, name)))


@pytest.mark.cases(2)
@pytest.mark.parametrize("name", ["results.csv", "summary.json"])
@pytest.mark.parametrize("make", [pipe, sparse], ids=["pipe", "sparse"])
def test_pipe_or_oversized_results_are_rejected(
    peak: Peak, tmp_path: Path, name: str, make: Callable[[Path, str], Path]
) -> None:
    if name == "summary.json":
        (tmp_path / "results.csv").write_text("time,a\n0,1\n")
        (tmp_path / "results.units.json").write_text("{}")
    file = make(tmp_path, name)
    rejection_message(peak(tmp_path, "compare", tmp_path if name == "summary.json" else file, file))


def commas(folder: Path) -> Path:
    (folder / "a.csv").write_bytes(b"time\n" + b"0,0\n" * 35 * MIB)
    return folder / "a.csv"


def numbers(folder: Path) -> Path:
    """Write a table of which two would exceed the memory limit."""
    (folder / "a.csv").write_bytes(b"time,a,b,c\n" + b"0,0,0,0\n" * 9 * MIB)
    return folder / "a.csv"


def one_line(folder: Path) -> Path:
    (folder / "a.csv").write_bytes(b"time\n" + b"0" * 500 * MIB)
    return folder / "a.csv"


def many_columns(folder: Path) -> Path:
    (folder / "a.csv").write_bytes(b",".join(b"a%d" % k for k in range(3_000_000)) + b"\n")
    return folder / "a.csv"


@pytest.mark.cases(2)
@pytest.mark.parametrize("make", [commas, numbers, one_line, many_columns])
def test_oversized_table_is_rejected(
    peak: Peak, tmp_path: Path, make: Callable[[Path], Path]
) -> None:
    file = make(tmp_path)
    rejection_message(peak(tmp_path, "compare", file, file))


def test_table_with_the_maximum_number_of_columns_is_compared(peak: Peak, tmp_path: Path) -> None:
    """The time is proportional to the number of columns, not to its square."""
    names = b",".join([b"time", *(b"a%d" % k for k in range(99_999))])
    row = b",".join([b"0"] * 100_000)
    (tmp_path / "a.csv").write_bytes(names + b"\n" + row + b"\n")
    code, err, memory = peak(tmp_path, "compare", "a.csv", "a.csv")
    assert (code, memory < MAX_MEMORY) == (0, True), err


def solid(name: str, begin: bytes, part: bytes = b"", count: int = 0) -> Callable[[Path], Path]:
    def make(folder: Path) -> Path:
        (folder / name).write_bytes(begin + part * count)
        return folder / name

    return make


def zipped_mesh(folder: Path) -> Path:
    return archive(folder / "a.zip", a__stl=bytes(200 * MIB))


def scene_of_scenes(folder: Path) -> Path:
    """Write a glTF with nested nodes, each included twice."""
    nodes = [{"children": [k + 1, k + 1]} for k in range(30)] + [{"mesh": 0}]
    part = {"attributes": {"POSITION": 0}}
    scene = {
        "asset": {"version": "2.0"},
        "nodes": nodes,
        "meshes": [{"primitives": [part]}],
        "accessors": [{"componentType": 5126, "type": "VEC3", "count": 3, "bufferView": 0}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "buffers": [{"uri": "data:,", "byteLength": 36}],
    }
    (folder / "a.gltf").write_text(json.dumps(scene))
    return folder / "a.gltf"


MESHES: dict[str, Callable[[Path], Path]] = {
    "an archive": zipped_mesh,
    "sparse": lambda folder: sparse(folder, "a.stl"),
    "a pipe": lambda folder: pipe(folder, "a.stl"),
    "a polygon of millions of corners": solid(
        "a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf ", b"1 2 3 ", 1_500_000
    ),
    "a header that promises": solid(
        "a.ply",
        b"ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\nproperty float x\n"
        b"element face 4000000000\nproperty list uchar int vertex_indices\nend_header\n",
    ),
    "long lines": solid("a.obj", b"", b"v 0 0 0 " + b" " * 4080 + b"\n", 3000),
    "many numbers": solid("a.off", b"OFF ", b"1 ", 6_000_000),
    "nodes of nodes": scene_of_scenes,
}


@pytest.mark.cases(3)
@pytest.mark.parametrize("make", MESHES.values(), ids=MESHES)
def test_oversized_mesh_is_rejected(
    peak: Peak, tmp_path: Path, make: Callable[[Path], Path]
) -> None:
    folder = experiment(tmp_path)
    mesh = f'shape = "mesh"\nfile = "{make(folder).name}"\nmass = 1.0\n'
    with (folder / "experiment.toml").open("a") as stream:
        stream.write('\n[[world.objects]]\nname = "thing"\n' + mesh)
    words = ["--coupling", "direct", "--set", "run.duration=0.01"]
    assert "outside" not in rejection_message(peak(tmp_path, "run", folder, *words))


@pytest.mark.parametrize("make", [pipe, sparse], ids=["pipe", "sparse"])
def test_pipe_or_oversized_custom_code_is_rejected(
    peak: Peak, tmp_path: Path, make: Callable[[Path, str], Path]
) -> None:
    """`check` reads the classes of a custom controller."""
    make(experiment(tmp_path), "own.py")
    rejection_message(peak(tmp_path, "run", "example", "--set", "controller.type=own.py:Own"))


def test_oversized_custom_code_is_rejected(peak: Peak, tmp_path: Path) -> None:
    (experiment(tmp_path) / "own.py").write_bytes(b"class Own: pass\na = [" + b"[]," * 340_000)
    rejection_message(peak(tmp_path, "run", "example", "--set", "controller.type=own.py:Own"))


@pytest.mark.cases(1)
@pytest.mark.parametrize("make", [pipe, sparse], ids=["pipe", "sparse"])
def test_oversized_fmu_of_a_study_is_rejected(
    peak: Peak, tmp_path: Path, make: Callable[[Path, str], Path]
) -> None:
    """A study reads all files of its runs to compute their hashes."""
    make(experiment(tmp_path, '\n[fmus.plant]\npath = "a.fmu"\n'), "a.fmu")
    vary = '[[vary]]\npath = "controller.kp"\nvalues = [1.0, 2.0]\n'
    (tmp_path / "study.toml").write_text(f'experiment = "example"\n{vary}')
    rejection_message(peak(tmp_path, "study", "study.toml", "--only", "0"))


@pytest.mark.parametrize("make", [pipe, sparse], ids=["pipe", "sparse"])
def test_pipe_or_oversized_design_is_rejected(
    peak: Peak, tmp_path: Path, make: Callable[[Path, str], Path]
) -> None:
    rejection_message(peak(tmp_path, "import-cad", make(tmp_path, "a.json"), "-o", "arm"))


@pytest.mark.parametrize(
    ("begin", "part", "count", "end"), [(b"", b"[],", 60, b""), (b'["', b"a", 150, b'"]')]
)
def test_oversized_design_is_rejected(
    peak: Peak, tmp_path: Path, begin: bytes, part: bytes, count: int, end: bytes
) -> None:
    (tmp_path / "a.json").write_bytes(begin + part * count * MIB + end)
    rejection_message(peak(tmp_path, "import-cad", "a.json", "-o", "arm"))


@pytest.mark.cases(2)
@pytest.mark.parametrize("part", [b"<!--", b"<?", b"<!D[", b"<!D[>", b"<!D>", b"<!D[]>", b"<"])
def test_robot_file_without_an_element_is_rejected(peak: Peak, tmp_path: Path, part: bytes) -> None:
    """The file only contains declarations or comments, or they have no end."""
    (tmp_path / "a.xml").write_bytes(part * (4 * MIB))
    rejection_message(peak(tmp_path, "info", "a.xml"))


def test_table_with_a_long_column_name_is_rejected(peak: Peak, tmp_path: Path) -> None:
    folder = experiment(tmp_path)
    (folder / "a.csv").write_bytes(b"time,a" + b" " * 3 * MIB + b"b\n" + b"0,0\n" * 9)
    rejection_message(peak(tmp_path, "run", folder, "--set", "reference.file=a.csv"))


def test_oversized_settings_are_rejected(peak: Peak, tmp_path: Path) -> None:
    rejection_message(peak(tmp_path, "run", experiment(tmp_path, "a = [" + "[]," * 2 * MIB + "]")))


def test_archive_with_too_much_content_is_rejected(peak: Peak, tmp_path: Path) -> None:
    """The archive contains 1.1 GiB of zeros; less than 1 % is written to disk."""
    packer, block = zlib.compressobj(1, zlib.DEFLATED, -15), bytes(MIB)
    data = b"".join(packer.compress(block) for _ in range(1100)) + packer.flush()
    head = struct.pack("<HHHHHLLLHH", 20, 0, 8, 0, 0, 0, len(data), 1100 * MIB, 1, 0)
    local = b"PK\x03\x04" + head + b"a" + data
    entry = b"PK\x01\x02\x14\0" + head + struct.pack("<HHHLL", 0, 0, 0, 0, 0) + b"a"
    end = struct.pack("<4s4H2LH", b"PK\x05\x06", 0, 0, 1, 1, len(entry), len(local), 0)
    (tmp_path / "a.ssp").write_bytes(local + entry + end)
    assert zipfile.ZipFile(io.BytesIO(local + entry + end)).infolist()[0].file_size == 1100 * MIB
    assert "is too large for a system" in rejection_message(
        peak(tmp_path, "info", tmp_path / "a.ssp")
    )


def numbers_of_a_byte(file: Path) -> None:
    rows = np.zeros((40_000_000, 3), np.int8)
    np.savez_compressed(file, rows=rows)


def many_rows(file: Path) -> None:
    """Write increasing times and zeros."""
    time = np.arange(5_500_000) * 1e-3
    np.save(file, np.stack([time, 0.0 * time, 0.0 * time], axis=1))


def rows_as_text(file: Path) -> None:
    file.write_bytes(b"time,q.joint_1,q.joint_2\n" + b"0,0,0\n" * 10_000_000)


def rows_of_opensim(file: Path) -> None:
    file.write_bytes(b"endheader\ntime\tjoint_1\n" + b"0\t0\n" * 10_000_000)


def messages_in_a_chunk(file: Path) -> None:
    """Write four million messages, compressed to some kilobytes."""
    zstandard = pytest.importorskip("zstandard")

    def text(content: str) -> bytes:
        return struct.pack("<I", len(content)) + content.encode()

    def record(kind: int, content: bytes) -> bytes:
        return struct.pack("<BQ", kind, len(content)) + content

    state = b"\0\1\0\0" + bytes(8) + struct.pack("<I4xIIII", 1, 0, 0, 0, 0)
    schema = struct.pack("<H", 1) + text("sensor_msgs/msg/JointState") + text("ros2msg") + text("")
    channel = struct.pack("<HH", 1, 1) + text("/joint_states") + text("cdr") + text("")
    data = record(3, schema) + record(4, channel)
    data += record(5, struct.pack("<HIQQ", 1, 0, 0, 0) + state) * 4_000_000
    packed = zstandard.compress(data)
    chunk = struct.pack("<QQQI", 0, 0, len(data), 0) + text("zstd")
    file.write_bytes(b"\x89MCAP0\r\n" + record(6, chunk + struct.pack("<Q", len(packed)) + packed))


MOTIONS: dict[str, Callable[[Path], None]] = {
    "a.npz": numbers_of_a_byte,
    "a.npy": many_rows,
    "a.csv": rows_as_text,
    "a.sto": rows_of_opensim,
    "a.mcap": messages_in_a_chunk,
}


@pytest.mark.cases(2)
@pytest.mark.parametrize("name", MOTIONS)
def test_oversized_motion_is_rejected(peak: Peak, tmp_path: Path, name: str) -> None:
    folder = experiment(tmp_path)
    MOTIONS[name](folder / name)
    rejection_message(peak(tmp_path, "run", folder, "--set", f"reference={{file='{name}'}}"))
