"""Valid files of experiments, runs and studies in a folder, and their specific defects."""

from __future__ import annotations

import contextlib
import json
import random
import shutil
import struct
import zipfile
import zlib
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from addin_sdfusion.robot import (
    InputError,
    Trajectory,
    TrajectoryPoint,
    read_robot,
    write_caspr,
)
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.hardware.protocol.recording import Recorder
from cardsflow_fmu.hardware.protocol.recording_header import RecordingHeader
from cardsflow_fmu.simulation.build import build
from cardsflow_fmu.simulation.run import run, simulate
from cardsflow_fmu.studies.execution import run_store
from cardsflow_fmu.studies.execution.run_store import RunStore

from ..recorded import sinusoidal_result
from ..robots.recorded_arm import MARKERS, marker_positions, write_markers
from ..robots.robots import EXAMPLES, PLANAR_2R, planar_2r
from .mutations import damage_file, damaged_words

SHORT = {"run.duration": 0.03, "run.step": 0.01, "controller.period": 0.01}


def experiment(folder: Path, more: str = "", name: str = "planar_2r") -> None:
    """Copy an example to a folder, with additional tables."""
    shutil.copytree(EXAMPLES / name, folder, dirs_exist_ok=True)
    for page in (*folder.glob("*.png"), *folder.glob("*.md")):
        page.unlink()
    if more:
        with (folder / "experiment.toml").open("a") as stream:
            stream.write(more)


def fmu(folder: Path) -> None:
    experiment(folder)
    (folder / "with.toml").write_text(
        (folder / "experiment.toml").read_text() + '\n[fmus.plant]\npath = "plant.fmu"\n'
    )
    build(Experiment.load(PLANAR_2R), folder / "built")
    _without_code(folder / "built/plant.fmu", folder / "plant.fmu")
    shutil.rmtree(folder / "built")


def _without_code(source: Path, target: Path) -> None:
    """Remove libraries and sources from an archive and from small FMUs in it."""
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


def ssp(folder: Path) -> None:
    build(Experiment.load(PLANAR_2R), folder / "built")
    _without_code(folder / "built/system.ssp", folder / "system.ssp")
    shutil.rmtree(folder / "built")


def motion(kind: str) -> Callable[[Path], None]:
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


def experiments(folder: Path) -> None:
    """Write an experiment with an object and a hardware link."""
    experiment(folder)
    extra = "\n[[world.objects]]\nname = 'box'\nshape = 'box'\nsize = [0.1, 0.1, 0.1]\nmass = 0.2\n"
    with (folder / "experiment.toml").open("a") as stream:
        stream.write(extra + "\n[hardware]\nlink = 'udp://127.0.0.1:5005'\n")


def study(folder: Path) -> None:
    experiment(folder / "arm")
    text = (EXAMPLES / "design_study/flower/study.toml").read_text()
    text = text.replace("../../roboy_left_arm", "arm").replace("count = 1000 ", "count = 8 ")
    (folder / "study.toml").write_text(text)


def results(folder: Path, **settings: Any) -> None:
    run(Experiment.load(PLANAR_2R, SHORT | settings), output=folder)
    for name in ("plant.fmu", "controller.fmu", "reference.fmu", "tracking.png", "tracking.svg"):
        (folder / name).unlink(missing_ok=True)


def calibration(folder: Path) -> None:
    results(folder, **{"run.duration": 0.5})
    shutil.copytree(PLANAR_2R / "robot", folder / "robot")


def recording(folder: Path) -> None:
    header = RecordingHeader(("f.a", "f.b"), ("N", "N"), ("q.a",), ("rad",), 1, 1e-3)
    came = SimpleNamespace(seq=1, age=1e-4, round_trip=1e-4, device_flags=0, state=np.ones(1))
    with Recorder(folder / "hardware.rec", header) as recorder:
        for k in range(20):
            recorder.write(1e-3 * k, np.ones(2), came)


def damage_recording(rng: random.Random, file: Path) -> None:
    """Damage a recording; in half of the cases, correct the checksum of the header."""
    if rng.random() < 0.5:
        damage_file(rng, file)
        return
    data = file.read_bytes()
    size = struct.unpack_from("<I", data, 12)[0]
    header = damaged_words(rng, data[20 : 20 + size])
    head = data[:12] + struct.pack("<II", len(header), zlib.crc32(header))
    file.write_bytes(head + header + data[20 + size :])


def search(folder: Path) -> None:
    experiment(folder / "planar_2r")
    text = (EXAMPLES / "design_study/attachments.toml").read_text()
    (folder / "study.toml").write_text(text.replace("../planar_2r", "planar_2r"))


def read_search(folder: Path) -> None:
    from cardsflow_fmu.studies.definition.study import Study

    with contextlib.suppress(InputError):
        Study.load(folder / "study.toml")


def killed_run(folder: Path) -> None:
    """Write the files of a run that was killed."""
    from cardsflow_fmu.results.journal import STARTED

    results(folder)
    summary = json.loads((folder / "summary.json").read_text())
    summary |= {"status": "incomplete", "error": str(STARTED)}
    (folder / "summary.json").write_text(json.dumps(summary))
    table = (folder / "results.csv").read_bytes()
    (folder / "results.csv").write_bytes(table[: 2 * len(table) // 3])


def study_folder(folder: Path) -> None:
    from ..small_studies import KP, run_here, small_study, write_study

    top = 'metrics = ["tracking.rms"]'
    write_study(folder, KP.replace("count = 6", "count = 2"), top)
    study = small_study(folder, KP.replace("count = 6", "count = 2"), top)
    run_here(study, folder / "out")
    for page in folder.rglob("*.html"):
        page.unlink()


def damage_run(rng: random.Random, file: Path) -> None:
    """Damage a file; in half of the cases, correct its checksum."""
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


def read_runs(folder: Path) -> None:
    """Read the files of the runs; do not repeat damaged runs."""
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


def _motion_of_joints(folder: Path, name: str) -> None:
    """Write an experiment whose reference is a recording of joint states."""
    experiment(folder)
    text = (EXAMPLES / "recorded_motion/experiment.toml").read_text()
    text = text.replace("../planar_2r/", "").replace("motion.csv", name)
    (folder / "experiment.toml").write_text(text)


def mcap(folder: Path) -> None:
    from cardsflow_fmu.ros.recording import write_recording

    _motion_of_joints(folder, "run.mcap")
    write_recording(sinusoidal_result(planar_2r(), 0.3), folder / "run.mcap")


def bag_folder(folder: Path) -> None:
    """Write an SQLite bag with its metadata."""
    from ..recorded import write_bag

    _motion_of_joints(folder, "bag")
    write_bag(folder / "bag", ("/joint_states", ("joint_1", "joint_2")), mcap=False)


def trajectories(folder: Path) -> None:
    """Write all kinds of CASPR trajectories; the experiment follows one of them."""
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


def world(folder: Path) -> None:
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


def captured(folder: Path) -> None:
    """Write a run without encoders, and recorded positions of motion-capture markers."""
    result = simulate(Experiment.load(PLANAR_2R, {"run.duration": 1.0}), coupling="direct")
    q = result.columns(["q.joint_1", "q.joint_2"])[::10]
    tables = {
        "run.csv": ["time", *(f"{x}.cable_{k}" for x in "lf" for k in range(1, 5))],
        "seen.csv": ["time", *(f"{marker.name}.{axis}" for marker in MARKERS for axis in "xyz")],
    }
    seen = np.column_stack([result["time"][::10], marker_positions(q)])
    for name, rows in (("run.csv", result.columns(tables["run.csv"])[::10]), ("seen.csv", seen)):
        head = ",".join(tables[name])
        np.savetxt(folder / name, rows, delimiter=",", header=head, comments="")
    write_markers(folder / "markers.toml")
    shutil.copytree(PLANAR_2R / "robot", folder / "robot")
