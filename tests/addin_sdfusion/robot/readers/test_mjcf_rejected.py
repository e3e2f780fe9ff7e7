"""Rejected MJCF files, and the isolation of MuJoCo's compiler from untrusted files."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from addin_sdfusion.robot import InputError
from addin_sdfusion.robot.finding import Finding
from addin_sdfusion.robot.formats.mjcf import compiled
from addin_sdfusion.robot.formats.mjcf.document import Document
from addin_sdfusion.robot.formats.read import read
from addin_sdfusion.robot.formats.reading.xml import Notes

BODY = '<body name="b">\n<joint name="j"/><geom size=".1"/></body>'
MESH = '<body name="b"><joint/><geom type="mesh" mesh="m"/></body>'


def written(folder: Path, world: str, more: str = "") -> Path:
    file = folder / "m.xml"
    file.write_text(f"<mujoco>{more}<worldbody>\n{world}</worldbody></mujoco>")
    return file


def errors(file: Path) -> list[Finding]:
    return [finding for finding in read(file).findings if finding.is_error]


@pytest.mark.parametrize(
    ("world", "more", "line", "message"),
    [
        ("<body><jiont/></body>", "", 2, "MuJoCo rejects <jiont>: Schema violation"),
        ('<body name="b"><joint/></body>', "", 2, "rejects <body> 'b': mass and inertia of moving"),
        (BODY + BODY, "", 3, "repeated name 'b'"),
        ('\n<geom size=".1" class="c"/>', "", 3, "unknown default class name 'c'"),
        ('<geom size="1 x"/>', "", 2, "bad format in attribute 'size'"),
        ('<geom size=".1" pos="nan 0 0"/>', "", 2, "pos 'nan 0 0' is not a finite number"),
        ('<body pos="1e999 0 0"/>', "", 2, "number is too large"),
        ("<attach/>", "", 2, "<attach> is not supported"),
        (f'<replicate count="9999">{BODY}</replicate>', "", 2, "creates more than 10000 elements"),
        (f'<replicate count="999"><replicate count="99">{BODY}</replicate></replicate>', "", 2,
         "creates more than 10000 elements"),
        (BODY, '<tendon><spatial><site site="s"/><site site="t"/></spatial></tendon>', 1, "'s'"),
        (BODY, '<tendon><fixed name="t"><joint joint="k" coef="1"/></fixed></tendon>', 1, "'k'"),
        (BODY, '<actuator><motor name="x" joint="k"/></actuator>', 1, "<motor> 'x': unknown"),
        (BODY, '<equality><joint joint1="k"/></equality>', 1, "'k'"),
        (BODY, '<actuator><muscle joint="j" gear="-1" lengthrange="0 1"/></actuator>', 1, "-1"),
        (BODY, '<actuator><muscle joint="j"/></actuator>', 1, "no lengthrange, and none found"),
        (BODY, '<include file="m.xml"/>', 1, "'m.xml' is already included"),
        (BODY, "<robot/>", 1, "rejects <robot>: Schema violation"),
        (MESH, '<asset><mesh name="m" file="gone.stl"/></asset>', 2, "do not exist.*: 'gone.stl'"),
        (MESH, '<asset><mesh name="m" file="m.xml"/></asset>', None, "'m.xml'"),
        (MESH, '<asset><mesh name="m" file="/dev/zero"/></asset>', 2, "do not exist.*/dev/zero"),
        (MESH, "", 2, "mesh 'm' not found"),
        (BODY, '<actuator><motor joint="j" nsample="2000000000"/></actuator>', 1, "samples"),
    ],
)  # fmt: skip
def test_invalid_file_is_rejected_at_its_element(
    world: str, more: str, line: int | None, message: str, tmp_path: Path
) -> None:
    first = errors(written(tmp_path, world, more))[0]
    assert re.search(message, first.message), first.message
    assert first.file == tmp_path / "m.xml"
    assert line is None or first.line == line


def test_error_in_an_included_file_names_that_file(tmp_path: Path) -> None:
    file = written(tmp_path, '<include file="part.xml"/>' + BODY)
    (tmp_path / "part.xml").write_text('<mujocoinclude>\n\n<body>\n<joint axis="0 0"/></body>\n'
                                       "</mujocoinclude>")  # fmt: skip
    (found,) = errors(file)
    assert (found.file, found.line) == (tmp_path / "part.xml", 4)
    assert "'axis' does not have enough data" in found.message


def body(name: str, joint: str = "", words: str = "") -> str:
    return f'<body name="{name}" {words}><joint name="{name}j" {joint}/><geom size=".1"/></body>'


OMITTED_BODIES = {
    body("g", words='gravcomp="1"'): "gravity compensation is ignored on 'g'",
    body("u", words='user="1 2"'): "user data of 1 elements is omitted",
    '<body name="c" mocap="true"/>': "motion capture bodies do not move: 'c'",
    body("s", 'stiffness="1 2"'): "'sj': its stiffness is a polynomial",
    body("y", 'stiffness="1" springyield=".1"'): "'yj': its spring is plastic in MuJoCo",
    body("q", 'type="ball"'): "'qj': a ball joint rotates by",
    '<body name="m"><geom type="mesh" mesh="m"/></body>': "'m': its mass comes from meshes",
    '<flexcomp name="f" type="grid" count="2 2 2"/>': "<flexcomp> is omitted",
}
OMITTED = {
    '<sensor><jointpos joint="j"/></sensor>': "<sensor> omitted: 'jointpos'",
    '<contact><exclude body1="b" body2="world"/></contact>': "<contact> omitted: 'exclude'",
    '<custom><numeric name="n" data="1"/></custom>': "<custom> omitted: 'n'",
    '<keyframe><key name="k" qpos="1"/></keyframe>': "<keyframe> omitted: 'k'",
    '<deformable><skin name="s"/></deformable>': "<deformable> omitted: 's'",
    '<extension><plugin plugin="p"/></extension>': "<extension> omitted: 'plugin'",
    '<actuator><plugin joint="j"/></actuator>': "plugin of <actuator> is omitted",
    '<actuator><velocity joint="j"/></actuator>': "'j': its servo is omitted",
    '<actuator><motor joint="j" delay=".1" nsample="9"/></actuator>': "its delay is omitted",
    '<actuator><adhesion body="b" ctrlrange="0 1"/></actuator>': "drives body",
    '<equality><flex flex="f"/></equality>': "equality <flex> '' is not supported",
    '<equality><tendon tendon1="t"/></equality>': "equality <tendon> '' is not supported",
    '<option density="1.2"/>': "density of the surrounding fluid is omitted",
    '<option><flag limit="disable"/></option>': "disables limit in MuJoCo",
    '<option actuatorgroupdisable="1"/>': "disabled groups of actuators are active",
    '<tendon><fixed name="t" armature="1" stiffness="1"><joint joint="j" coef="1"/></fixed>'
    "</tendon>": "'t': friction and armature of the tendon are omitted",
    '<tendon><fixed name="v"><joint joint="j" coef="1"/></fixed></tendon>':
        "tendon 'v' has no actuator and no spring; omitted",
    '<asset><mesh name="m" file="gone.stl"/></asset>': "1 of 1 mesh files are not found",
}  # fmt: skip
"""Elements that are omitted, with a part of the warning."""


def test_omitted_elements_are_reported(tmp_path: Path) -> None:
    """All of them are in one file, since each compilation takes a process."""
    file = written(tmp_path, "\n".join([BODY, *OMITTED_BODIES]), "\n".join(OMITTED))
    said = [str(finding) for finding in read(file).findings]
    for text in (*OMITTED_BODIES.values(), *OMITTED.values()):
        assert [line for line in said if text in line], text
    assert not errors(file)


NAMES = (
    '<asset><texture name="t" type="2d" file="/secret.png"/><texture name="u" type="cube" '
    'fileright="/secret.png"/><hfield name="h" file="/secret.png" size="1 1 1 1"/>'
    '<skin name="k" file="/secret.skn"/><model name="d" file="/secret.xml"/>'
    '<mesh name="m" file="/secret.stl"/><material name="a" texture="t"/></asset>'
    '<compiler meshdir="/secret" texturedir="/secret" assetdir="/secret"/>'
    '<deformable><skin name="l" file="/secret.skn"/></deformable>'
    '<extension><plugin plugin="/secret"/></extension>'
)


def test_mujoco_gets_no_paths(tmp_path: Path) -> None:
    world = f'{BODY}<flexcomp name="f" file="/secret.msh"/><geom type="mesh" mesh="m"/>'
    file = written(tmp_path, world + '<geom type="hfield" hfield="h" material="a"/>', NAMES)
    assert "secret" not in Document(file, Notes()).text()
    assert not errors(file)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no pipes with names")
def test_pipe_is_rejected_without_waiting(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.stl")
    (found, *_) = errors(written(tmp_path, MESH, '<asset><mesh name="m" file="pipe.stl"/></asset>'))
    assert found.code == "mass-from-mesh"
    with pytest.raises(InputError, match="is not a regular file"):
        read(written(tmp_path, BODY, '<include file="pipe.stl"/>'))


CRASHES = {
    "import os; os.abort()": "MuJoCo crashes on this file",
    "import os, signal; os.kill(os.getpid(), signal.SIGSEGV)": "MuJoCo crashes on this file",
    "raise SystemExit('ERROR: out of stack')": "MuJoCo crashes on this file: ERROR: out of stack",
    "raise MemoryError": "exceeds 1024 MiB of memory",
    "while True: pass": "exceeds 0.5 s",
    "import time; time.sleep(60)": "exceeds 0.5 s",
    "pass": "MuJoCo crashes on this file",
}


@pytest.mark.usefixtures("own_compiler")
@pytest.mark.parametrize("program", CRASHES)
@pytest.mark.skipif(sys.platform == "win32", reason="exit codes are those of signals")
def test_crash_of_the_compiler_is_reported_in_one_line(
    program: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "child.py").write_text(program)
    monkeypatch.setattr(compiled, "_PROGRAM", tmp_path / "child.py")
    if "0.5 s" in CRASHES[program]:
        monkeypatch.setattr(compiled, "MAX_RUN_TIME", 0.5)
    with pytest.raises(InputError, match=CRASHES[program]) as caught:
        read(written(tmp_path, BODY))
    assert "\n" not in str(caught.value)


@pytest.mark.usefixtures("own_compiler")
def test_memory_and_time_of_the_compiler_are_limited(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("resource", reason="this system has no limits of a process")
    monkeypatch.setattr(compiled, "MJCF_SECONDS", 1.0)
    many = "".join(f'<default class="c{k}"/>' for k in range(40_000))
    with pytest.raises(InputError, match="exceeds 1 s of processor time"):
        read(written(tmp_path, BODY, f"<default>{many}</default>"))
    monkeypatch.undo()
    plate = '<asset><mesh name="m" builtin="plate" params="20000 20000"/></asset>'
    with pytest.raises(InputError, match=r"MuJoCo crashes on this file|exceeds 1024 MiB"):
        read(written(tmp_path, MESH, plate))


INTERRUPTED = """
import sys, signal
from pathlib import Path
from addin_sdfusion.robot.formats.mjcf import compiled
compiled._PROGRAM = Path(sys.argv[1])
compiled.run_compiler({}, Path("x"))
"""


@pytest.mark.skipif(sys.platform == "win32", reason="sends a signal to a group")
def test_interrupt_ends_the_compiler_at_once(tmp_path: Path) -> None:
    (tmp_path / "child.py").write_text(
        "import os, signal, sys, time; signal.signal(signal.SIGINT, signal.SIG_IGN)\n"
        f"open({str(tmp_path / 'pid')!r}, 'w').write(str(os.getpid())); time.sleep(60)\n"
    )
    command = [sys.executable, "-c", INTERRUPTED, str(tmp_path / "child.py")]
    started = subprocess.Popen(command, start_new_session=True, stderr=subprocess.PIPE)
    deadline = time.monotonic() + 30.0
    while not (tmp_path / "pid").exists() or not (tmp_path / "pid").read_text():
        assert time.monotonic() < deadline
        time.sleep(0.05)
    os.killpg(started.pid, signal.SIGINT)
    assert b"KeyboardInterrupt" in started.communicate(timeout=10.0)[1]
    with pytest.raises(ProcessLookupError):
        os.kill(int((tmp_path / "pid").read_text()), 0)


def test_missing_mujoco_suggests_the_extra(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compiled, "find_spec", lambda name: None)
    with pytest.raises(InputError, match=r"pip install 'cardsflow\[mujoco\]'"):
        read(written(tmp_path, BODY))


@pytest.mark.usefixtures("own_compiler")
def test_no_files_are_written_next_to_the_model(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By default MuJoCo writes a log file when it starts."""
    monkeypatch.chdir(tmp_path)
    errors(written(tmp_path, '<body pos="inf 0 0"><joint/><geom size=".1"/></body>'))
    assert [file.name for file in tmp_path.iterdir()] == ["m.xml"]
