"""A host in C, in an environment without Python."""

from __future__ import annotations

import csv
import os
import subprocess
from pathlib import Path

import fmpy
import numpy as np
import pytest
from support.fmu.fmu_host import OUTPUTS, STEP, plain_run, run
from support.native.targets import PROGRAMS
from support.policies import random_policy
from support.robots.robots import EXAMPLES, PLANAR_2R
from toy_model import REFERENCES

from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.models.plant import PlantModel
from cardsflow_fmu.simulation.build import build
from cardsflow_fmu.simulation.run import simulate

STEPS = 1000
KEPT = ("LD_PRELOAD", "ASAN_OPTIONS")  # sanitized builds need these


@pytest.fixture(scope="session")
def c_host(compiler: str, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the compiled host."""
    program = tmp_path_factory.mktemp("c_host") / "c_host"
    headers = Path(fmpy.__file__).parent / "c-code"
    source = PROGRAMS / "fmu_trajectory.c"
    flags = ["-Wall", "-Werror", "-ffp-contract=off", f"-I{headers}"]
    run([compiler, *flags, str(source), "-o", str(program), "-ldl"])
    return program


def swing(k: int) -> float:
    """Return the value that the host adds to the start value of an input in step k."""
    return 0.1 * ((k % 23) / 23.0)


def outputs_of(c_host: Path, folder: Path, number: int, references: list[int]) -> np.ndarray:
    """Return the output of the host for an unpacked FMU with an oscillating input."""
    description = fmpy.read_model_description(str(folder))
    name = description.coSimulation.modelIdentifier
    done = subprocess.run(
        [
            str(c_host),
            str(folder / f"binaries/linux64/{name}.so"),
            description.guid,
            (folder / "resources").as_uri(),
            *map(str, (STEPS, round(1e3 * STEP), 1, number, *references)),
        ],
        capture_output=True,
        text=True,
        check=False,
        env={name: os.environ[name] for name in KEPT if name in os.environ},
        cwd="/",
    )
    assert done.returncode == 0, done.stderr
    bits = [[int(word, 16) for word in line.split()] for line in done.stdout.splitlines()]
    return np.array(bits, np.uint64).view(float)


@pytest.mark.slow
@pytest.mark.native
def test_c_host_steps_the_toy(c_host: Path, toy_fmu: Path) -> None:
    found = outputs_of(c_host, toy_fmu, REFERENCES["u"], OUTPUTS)
    assert (found == plain_run(STEPS, u=swing)).all()


def test_c_host_steps_the_plant(c_host: Path, tmp_path: Path) -> None:
    experiment = Experiment.load(PLANAR_2R)
    archive = build(experiment, tmp_path / "fmus", compute="python")["plant"]
    fmpy.extract(str(archive), str(tmp_path / "plant"))
    model = PlantModel(experiment)
    references = {port.name: i for i, port in enumerate(model.ports)}
    outputs = [i for i, port in enumerate(model.ports) if port.causality == "output"]
    number = references["f.cable_1"]
    found = outputs_of(c_host, tmp_path / "plant", number, outputs)
    model.initialize()
    start = model.values[number]
    for k in range(STEPS):
        model.values[number] = start + swing(k)
        model.step(k * STEP, STEP)
        assert (found[k] == model.values[outputs]).all()


@pytest.mark.slow
@pytest.mark.parametrize("is_policy", [False, True], ids=["own law", "policy"])
def test_closed_loop_of_the_example_equals_run(
    compiler: str, is_policy: bool, tmp_path: Path
) -> None:
    """examples/exchange/closed_loop.c: all real variables at every step, bit for bit."""
    law = random_policy(tmp_path) if is_policy else {"controller.period": 0.002}
    experiment = Experiment.load(PLANAR_2R, {"run.duration": 0.5, **law})
    for name, archive in build(experiment, tmp_path / "fmus").items():
        fmpy.extract(str(archive), str(tmp_path / name))
    source, program = EXAMPLES / "exchange/closed_loop.c", tmp_path / "closed_loop"
    flags = ["-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror"]
    run([compiler, *flags, str(source), "-o", str(program), "-ldl"])
    done = subprocess.run(
        [program, tmp_path],
        capture_output=True,
        text=True,
        check=True,
        env={name: os.environ[name] for name in KEPT if name in os.environ},
        cwd="/",
    )
    rows = list(csv.DictReader(done.stdout.splitlines()))
    result = simulate(experiment)
    assert len(rows) == len(result.rows)
    common = set(rows[0]) & set(result.names)
    assert {name.partition(".")[0] for name in common} >= {"time", "q", "qd", "f", "l", "q_d"}
    for name in common:
        np.testing.assert_array_equal([float(row[name]) for row in rows], result[name], name)
    require_no_leak(compiler, source, tmp_path)
    nothing = subprocess.run(
        [program, tmp_path / "no"], capture_output=True, text=True, check=False
    )
    assert (nothing.returncode, nothing.stdout) == (1, "")
    assert nothing.stderr.endswith("modelDescription.xml: cannot be read\n")


def require_no_leak(compiler: str, source: Path, folder: Path) -> None:
    """Run the host with the leak detection of the compiler, if it supports it."""
    program = folder / "checked_loop"
    flags = ["-std=c99", "-g", "-fsanitize=address"]
    built = subprocess.run(
        [compiler, *flags, str(source), "-o", str(program), "-ldl"],
        capture_output=True,
        check=False,
    )
    if built.returncode:
        return
    done = subprocess.run(
        [program, folder],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        check=False,
        env={"ASAN_OPTIONS": "detect_leaks=1"},
    )
    assert done.returncode == 0, done.stderr
