"""Kinds of files that users name: a good one of each, and the commands that read it."""

from __future__ import annotations

import contextlib
import io
import json
import random
import shutil
import struct
import zipfile
import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from addin_sdfusion.robot import (
    CardsflowError,
    InputError,
    Trajectory,
    TrajectoryPoint,
    read_robot,
    write_caspr,
    write_sdf,
)
from addin_sdfusion.robot.writers.urdf import write_urdf
from cardsflow_fmu.cli.main import main
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.hardware.protocol.recording import Recorder
from cardsflow_fmu.hardware.protocol.recording_header import RecordingHeader
from cardsflow_fmu.simulation.build import build
from cardsflow_fmu.simulation.run import run
from cardsflow_fmu.studies.execution import run_store
from cardsflow_fmu.studies.execution.run_store import RunStore

from ..models_of_others import INCLUDED, MJCF, OPTIONS, OSIM
from ..recorded import waving
from ..robots.robots import EXAMPLES, PLANAR_2R, planar_2r
from .mutations import damage_file, damaged_words

SECONDS = 10.0
"""Processor time that a file may take."""
SHORT = {"run.duration": 0.03, "run.step": 0.01, "controller.period": 0.01}


@dataclass(frozen=True)
class Kind:
    """A kind of files.

    Attributes:
        make: Writes a folder of them.
        files: Which of them are damaged, as a pattern.
        commands: What reads them: words after `cardsflow`, in that folder; one of them a mutation.
        damage: Gives a file its defects.
    """

    make: Callable[[Path], None]
    files: str
    commands: Sequence[Sequence[str] | Callable[[Path], None]]
    damage: Callable[[random.Random, Path], None] = damage_file


def experiment(folder: Path, more: str = "", name: str = "planar_2r") -> None:
    """An example in a folder, with tables more."""
    shutil.copytree(EXAMPLES / name, folder, dirs_exist_ok=True)
    for page in (*folder.glob("*.png"), *folder.glob("*.md")):
        page.unlink()
    if more:
        with (folder / "experiment.toml").open("a") as stream:
            stream.write(more)


def _fmu(folder: Path) -> None:
    experiment(folder)
    (folder / "with.toml").write_text(
        (folder / "experiment.toml").read_text() + '\n[fmus.plant]\npath = "plant.fmu"\n'
    )
    build(Experiment.load(PLANAR_2R), folder / "built")
    _without_code(folder / "built/plant.fmu", folder / "plant.fmu")
    shutil.rmtree(folder / "built")


def _without_code(source: Path, target: Path) -> None:
    """An archive without libraries and their sources, in small FMUs within it too."""
    with zipfile.ZipFile(source) as old, zipfile.ZipFile(target, "w") as new:
        for entry in old.infolist():
            content = old.read(entry)
            if entry.filename.endswith(".fmu"):
                (inner := target.with_suffix(".inner")).write_bytes(content)
                _without_code(inner, inner.with_suffix(".small"))
                content = inner.with_suffix(".small").read_bytes()
                inner.unlink(), inner.with_suffix(".small").unlink()
            if not entry.filename.startswith(("binaries/", "sources/", "terminalsAndIcons/")):
                new.writestr(entry.filename, content)


def _ssp(folder: Path) -> None:
    build(Experiment.load(PLANAR_2R), folder / "built")
    _without_code(folder / "built/system.ssp", folder / "system.ssp")
    shutil.rmtree(folder / "built")


def _motion(kind: str) -> Callable[[Path], None]:
    def make(folder: Path) -> None:
        experiment(folder)
        text = (EXAMPLES / "recorded_motion/experiment.toml").read_text()
        text = text.replace("../planar_2r/", "").replace("motion.csv", f"motion.{kind}")
        (folder / "experiment.toml").write_text(text)
        time = np.linspace(0.0, 1.0, 51)
        q = np.stack([0.3 * np.sin(time), 0.2 * np.cos(time)], axis=1)
        names = [coordinate.name for coordinate in read_robot(folder / "robot").coordinates]
        columns = {"time": time} | {f"q.{name}": q[:, k] for k, name in enumerate(names)}
        if kind == "npy":
            np.save(folder / "motion.npy", np.column_stack([time, q]))
        elif kind == "npz":
            np.savez(folder / "motion.npz", **columns)
        elif kind == "sto":
            table, head = np.stack(list(columns.values()), axis=1), "\t".join(["time", *names])
            head = f"motion\nversion=1\nnRows=51\nnColumns=3\ninDegrees=no\nendheader\n{head}"
            np.savetxt(folder / "motion.sto", table, delimiter="\t", header=head, comments="")
        else:
            table, head = np.stack(list(columns.values()), axis=1), ",".join(columns)
            np.savetxt(folder / "motion.csv", table, delimiter=",", header=head, comments="")

    return make


def _parquet(folder: Path) -> None:
    import pyarrow as pa
    from pyarrow import parquet

    table = pa.table({"time": np.arange(50) * 0.01, "q.a": np.zeros(50), "f.b": np.ones(50)})
    parquet.write_table(
        table.replace_schema_metadata({"units": '{"time": "s"}'}), folder / "a.parquet"
    )


def _experiments(folder: Path) -> None:
    """The experiment whose tables are most, beside others' robots."""
    experiment(folder)
    extra = "\n[[world.objects]]\nname = 'box'\nshape = 'box'\nsize = [0.1, 0.1, 0.1]\nmass = 0.2\n"
    with (folder / "experiment.toml").open("a") as stream:
        stream.write(extra + "\n[hardware]\nlink = 'udp://127.0.0.1:5005'\n")


def _study(folder: Path) -> None:
    experiment(folder / "arm")
    text = (EXAMPLES / "design_study/flower/study.toml").read_text()
    text = text.replace("../../roboy_left_arm", "arm").replace("count = 1000 ", "count = 8 ")
    (folder / "study.toml").write_text(text)


def _results(folder: Path, **settings: Any) -> None:
    run(Experiment.load(PLANAR_2R, SHORT | settings), output=folder)
    for name in ("plant.fmu", "controller.fmu", "reference.fmu", "tracking.png", "tracking.svg"):
        (folder / name).unlink(missing_ok=True)


def _calibration(folder: Path) -> None:
    _results(folder, **{"run.duration": 0.5})
    shutil.copytree(PLANAR_2R / "robot", folder / "robot")


def _recording(folder: Path) -> None:
    header = RecordingHeader(("f.a", "f.b"), ("N", "N"), ("q.a",), ("rad",), 1, 1e-3)
    came = SimpleNamespace(seq=1, age=1e-4, round_trip=1e-4, device_flags=0, state=np.ones(1))
    with Recorder(folder / "hardware.rec", header) as recorder:
        for k in range(20):
            recorder.write(1e-3 * k, np.ones(2), came)


def _damage_recording(rng: random.Random, file: Path) -> None:
    """Damage, of a header whose sum is right in half of the cases."""
    if rng.random() < 0.5:
        damage_file(rng, file)
        return
    data = file.read_bytes()
    size = struct.unpack_from("<I", data, 12)[0]
    header = damaged_words(rng, data[20 : 20 + size])
    head = data[:12] + struct.pack("<II", len(header), zlib.crc32(header))
    file.write_bytes(head + header + data[20 + size :])


def _mesh(suffix: str) -> Callable[[Path], None]:
    def make(folder: Path) -> None:
        import trimesh

        robot = (EXAMPLES / "pick_up/robot/model.sdf").read_text()
        (folder / "meshes").mkdir()
        (folder / "model.sdf").write_text(robot.replace("pad.stl", f"pad{suffix}"))
        if suffix == ".stl":
            data: Any = trimesh.creation.box((0.1, 0.1, 0.1)).export(file_type="stl_ascii")
        elif suffix == ".dae":
            data = _COLLADA
        else:
            data = trimesh.creation.box((0.1, 0.1, 0.1)).export(file_type=suffix[1:])
        (folder / "meshes" / f"pad{suffix}").write_bytes(
            data if isinstance(data, bytes) else data.encode()
        )

    return make


_COLLADA = """<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit meter="0.001" name="millimeter"/><up_axis>Z_UP</up_axis></asset>
<library_geometries><geometry id="g" name="g"><mesh>
<source id="p"><float_array id="pa" count="12">0 0 0 1 0 0 0 1 0 0 0 1</float_array>
<technique_common><accessor source="#pa" count="4" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="4"><input semantic="VERTEX" source="#v" offset="0"/>
<p>0 2 1 0 1 3 1 2 3 2 0 3</p></triangles></mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node id="n"><matrix>1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1
</matrix><instance_geometry url="#g"/></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>
"""


def _hull(folder: Path) -> None:
    """The meshes of a world, as the engine reads them."""
    from sim_dart.dart.meshes import convex_hull

    for file in sorted((folder / "meshes").iterdir()):
        with contextlib.suppress(CardsflowError):
            convex_hull(file)


def _search(folder: Path) -> None:
    experiment(folder / "planar_2r")
    text = (EXAMPLES / "design_study/attachments.toml").read_text()
    (folder / "study.toml").write_text(text.replace("../planar_2r", "planar_2r"))


def _read_search(folder: Path) -> None:
    from cardsflow_fmu.studies.definition.study import Study

    with contextlib.suppress(InputError):
        Study.load(folder / "study.toml")


def _killed(folder: Path) -> None:
    """What a run leaves that was killed."""
    from cardsflow_fmu.results.journal import STARTED

    _results(folder)
    summary = json.loads((folder / "summary.json").read_text())
    summary |= {"status": "incomplete", "error": str(STARTED)}
    (folder / "summary.json").write_text(json.dumps(summary))
    table = (folder / "results.csv").read_bytes()
    (folder / "results.csv").write_bytes(table[: 2 * len(table) // 3])


def _gltf(folder: Path) -> None:
    """Two files: positions and indices are beside the scene."""
    import trimesh

    _mesh(".glb")(folder)
    (folder / "meshes/pad.glb").unlink()
    robot = folder / "model.sdf"
    robot.write_text(robot.read_text().replace("pad.glb", "pad.gltf"))
    scene = trimesh.Scene(trimesh.creation.box((0.1, 0.1, 0.1)))
    files = trimesh.exchange.gltf.export_gltf(scene)
    for name, content in files.items():
        (folder / "meshes" / name.replace("model.gltf", "pad.gltf")).write_bytes(content)


def _study_folder(folder: Path) -> None:
    from ..small_studies import KP, run_here, small_study, write_study

    top = 'engine = "direct"\nmetrics = ["tracking.rms"]'
    write_study(folder, KP.replace("count = 6", "count = 2"), top)
    study = small_study(folder, KP.replace("count = 6", "count = 2"), top)
    run_here(study, folder / "out")
    for page in folder.rglob("*.html"):
        page.unlink()


def _damage_run(rng: random.Random, file: Path) -> None:
    """Damage, of contents whose sum is right in half of the cases."""
    if file.parent.name != "runs" or rng.random() < 0.5:
        damage_file(rng, file)
        return
    content = json.loads(file.read_bytes())
    content.pop("check")
    text = damaged_words(rng, json.dumps(content, indent=1).encode())
    with contextlib.suppress(ValueError, TypeError, AttributeError, RecursionError):
        content = json.loads(text)
        text = json.dumps(content | {"check": run_store._check(content)}).encode()
    file.write_bytes(text)


def _read_runs(folder: Path) -> None:
    """The files of the runs, without doing those again that are damaged."""
    store = RunStore(folder / "out")
    for settings in store.settings(""):
        assert isinstance(settings, dict)
    for file in (folder / "out/runs").glob("*.json"):
        outcome = store.read(SimpleNamespace(hash=file.stem))  # type: ignore[arg-type]
        if outcome is not None:
            assert isinstance(outcome.metrics, dict)
            assert outcome.error is None or isinstance(outcome.error, str)
            assert all(isinstance(v, float | int | None) for v in outcome.metrics.values())
            assert isinstance(outcome.wall_time, float | int | None)


def _sdf(folder: Path) -> None:
    write_sdf(read_robot(PLANAR_2R / "robot"), folder)


def _robot(name: str) -> Callable[[Path], None]:
    def make(folder: Path) -> None:
        shutil.copytree(EXAMPLES / name / "robot", folder, dirs_exist_ok=True)

    return make


def _urdf(folder: Path) -> None:
    write_urdf(read_robot(PLANAR_2R / "robot"), folder)


def _osim(folder: Path) -> None:
    (folder / "leg.osim").write_text(OSIM)


def _mjcf(folder: Path) -> None:
    """A model of three files."""
    for name, text in (("model", MJCF), ("arm", INCLUDED), ("options", OPTIONS)):
        (folder / f"{name}.xml").write_text(text)


def _motion_of_joints(folder: Path, name: str) -> None:
    """An experiment that follows joint states recorded, of the names' order."""
    experiment(folder)
    text = (EXAMPLES / "recorded_motion/experiment.toml").read_text()
    text = text.replace("../planar_2r/", "").replace("motion.csv", name)
    (folder / "experiment.toml").write_text(text)


def _mcap(folder: Path) -> None:
    from cardsflow_fmu.ros.recording import write_recording

    _motion_of_joints(folder, "run.mcap")
    write_recording(waving(planar_2r(), 0.3), folder / "run.mcap")


def _bag(folder: Path) -> None:
    """SQLite's and its metadata."""
    from ..recorded import bag

    _motion_of_joints(folder, "bag")
    bag(folder / "bag", ("/joint_states", ("joint_1", "joint_2")), mcap=False)


def _trajectories(folder: Path) -> None:
    """CASPR's of all kinds, and one of them followed."""
    experiment(folder)
    rest = (0.0, 0.0)
    samples = tuple(TrajectoryPoint(0.1 * k, (0.1, 0.02 * k), rest, rest) for k in range(9))
    blend = (TrajectoryPoint(0.0, rest), TrajectoryPoint(2.0, (0.1, 0.2), blend_time=0.5))
    ends = (TrajectoryPoint(0.0, rest, rest, rest), TrajectoryPoint(2.0, (0.1, 0.2), rest, rest))
    kinds = [("samples", samples), ("parabolic_blend", blend), ("quintic", ends)]
    trajectories = [Trajectory(kind, kind, points, 0.1) for kind, points in kinds]
    write_caspr(planar_2r(), folder / "robot", trajectories=trajectories)
    for name in ("samples", "parabolic_blend"):
        text = f'[robot]\npath = "robot"\n[reference]\ntrajectory = "{name}"\n[controller]\n'
        (folder / f"{name}.toml").write_text(text + 'type = "joint_space"\nkp = 100.0\nkd = 10.0\n')


def _world(folder: Path) -> None:
    experiment(folder, '\n[world]\nsdf = "world.sdf"\n')
    (folder / "world.sdf").write_text(_SDF_WORLD)


_SDF_WORLD = """<sdf version="1.9"><world name="w"><gravity>0 0 -9.8</gravity>
<model name="ground"><static>true</static><link name="l"><collision name="c"><geometry>
<plane><normal>0 0 1</normal><size>9 9</size></plane></geometry><surface><friction><ode><mu>0.7</mu>
</ode></friction></surface></collision></link></model>
<model name="box"><static>1</static><pose relative_to="p">5 2 3 0.1 0.2 0.3</pose><frame name="f"/>
<link name="l"><pose>1 0 0 0 0 0</pose><collision name="c"><pose relative_to="l">0 0 1 0 0 0</pose>
<geometry><box><size>0.1 0.2 0.3</size></box></geometry></collision><collision name="d"><geometry>
<cylinder><radius>0.1</radius><length>1</length></cylinder></geometry></collision></link></model>
<frame name="p"><pose>1 2 3 0 0 1</pose></frame>
<model name="ball"><link name="l"><collision name="c"><geometry><sphere><radius>0.1</radius>
</sphere></geometry></collision></link></model></world></sdf>
"""


def _step(folder: Path) -> None:
    from ..designs.step_hands import JOINTS, MATERIALS, MUSCLES, WRAPS, write_hands

    write_hands(folder / "hands.step")
    tables = {"joints": JOINTS, "muscles": MUSCLES, "materials": MATERIALS, "wraps": WRAPS}
    for name, text in tables.items():
        (folder / f"{name}.csv").write_text(text, encoding="utf-8")


def _snapshot(folder: Path) -> None:
    shutil.copy(EXAMPLES / "from_cad/two_link_arm.json", folder / "design.json")


_TO_RUN = ("convert", ".", "--to", "run.mcap")
_TO_MOTION = ("--to", "motion_of.csv")
_IMPORT = (
    *("import-cad", "hands.step", "x", "--joints", "joints.csv", "--muscles", "muscles.csv"),
    *("--materials", "materials.csv", "--wraps", "wraps.csv"),
)
_CALIBRATE = ("calibrate", ".", "--robot", "robot", "--free", "muscles.*.offset", "-o", "x")
_CHECK = ("check", "experiment.toml")
_ROBOT = [
    ("check", "."),
    ("info", "."),
    ("check", ".", "--for", "osim"),
    ("check", ".", "--for", "mjcf"),
    ("init", ".", "-o", "x.toml"),
]
_MESH = [("view", ".", "--html", "a.html"), _hull]
_EXPORT = ("addin", "export-snapshot", "design.json", "-o", "x")
_PLAY = ("--listen", "udp://127.0.0.1:0", "--duration", "0.001")

KINDS: dict[str, Kind] = {
    "fmu": Kind(_fmu, "plant.fmu", [("info", "plant.fmu"), ("check", "with.toml")]),
    "ssp": Kind(_ssp, "system.ssp", [("info", "system.ssp"), ("run", "system.ssp", "-o", "out")]),
    "npz": Kind(_motion("npz"), "motion.npz", [_CHECK]),
    "npy": Kind(_motion("npy"), "motion.npy", [_CHECK]),
    "csv": Kind(_motion("csv"), "motion.csv", [_CHECK, ("compare", "motion.csv", "motion.csv")]),
    "sto": Kind(
        _motion("sto"),
        "motion.sto",
        [_CHECK, ("activations", "robot", "--motion", "motion.sto", "-o", "x")],
    ),
    "calibration": Kind(_calibration, "*.*", [_CALIBRATE]),
    "parquet": Kind(_parquet, "a.parquet", [("compare", "a.parquet", "a.parquet")]),
    "experiment": Kind(_experiments, "experiment.toml", [_CHECK]),
    "device": Kind(_experiments, "experiment.toml", [("device", "experiment.toml", *_PLAY)]),
    "study": Kind(_study, "study.toml", [("study", "study.toml", "--only", "0")]),
    "recording": Kind(
        _recording,
        "hardware.rec",
        [("replay-hardware", "hardware.rec", *_PLAY), ("convert", "hardware.rec", *_TO_RUN[2:])],
        _damage_recording,
    ),
    "stl": Kind(_mesh(".stl"), "meshes/*", _MESH),
    "obj": Kind(_mesh(".obj"), "meshes/*", _MESH),
    "dae": Kind(_mesh(".dae"), "meshes/*", _MESH),
    "ply": Kind(_mesh(".ply"), "meshes/*", _MESH),
    "glb": Kind(_mesh(".glb"), "meshes/*", _MESH),
    "off": Kind(_mesh(".off"), "meshes/*", _MESH),
    "results": Kind(_results, "*.json", [("compare", ".", "."), ("view", ".", "--html", "a.html")]),
    "run": Kind(_results, "*.*", [("compare", ".", "."), ("view", ".", "--html", "a.html")]),
    "study folder": Kind(_study_folder, "out/*/*.json", [_read_runs], _damage_run),
    "sdf": Kind(_sdf, "model.sdf", _ROBOT),
    "urdf": Kind(_urdf, "*.urdf", _ROBOT),
    "cardsflow": Kind(_robot("hill_arm"), "*.*", _ROBOT),
    "caspr": Kind(_robot("planar_2r"), "*.*", _ROBOT),
    "osim": Kind(_osim, "leg.osim", [*_ROBOT, ("convert", ".", "--to", "sdf", "-o", "x")]),
    "mjcf": Kind(_mjcf, "*.xml", [*_ROBOT, ("convert", "model.xml", "--to", "sdf", "-o", "x")]),
    "trajectories": Kind(
        _trajectories,
        "robot/*traj*",
        [("check", "samples.toml"), ("check", "parabolic_blend.toml")],
    ),
    "world": Kind(_world, "world.sdf", [_CHECK]),
    "mcap": Kind(_mcap, "run.mcap", [_CHECK, ("convert", "run.mcap", *_TO_MOTION)]),
    "bag": Kind(_bag, "bag/*", [_CHECK, ("convert", "bag", *_TO_MOTION)]),
    "gltf": Kind(_gltf, "meshes/*", _MESH),
    "search": Kind(_search, "study.toml", [_read_search]),
    "killed run": Kind(_killed, "*.*", [("compare", ".", "."), _TO_RUN]),
    "figures": Kind(_results, "*.*", [("plot", "."), ("report", ".")]),
    "step": Kind(_step, "*.step", [_IMPORT]),
    "step tables": Kind(_step, "*.csv", [_IMPORT]),
    "snapshot": Kind(_snapshot, "design.json", [_EXPORT]),
}


def command(folder: Path, words: Sequence[str]) -> tuple[int, str]:
    """Exit code and messages of a command; the folder is the current one."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            code = main(words)
        except SystemExit as end:
            code = int(end.code or 0)
    return code, err.getvalue()
