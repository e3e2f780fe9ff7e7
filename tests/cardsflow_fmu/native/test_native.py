"""Native FMUs contain no Python; restored states repeat; damaged files are rejected."""

from __future__ import annotations

import os
import struct
import zipfile
import zlib
from pathlib import Path

import fmpy
import numpy as np
import pytest
from support.fmu.fmu_host import load
from support.fmu.native_states import check_states_repeat
from support.robots.robots import EXAMPLES

from addin_sdfusion.robot import InputError
from cardsflow_fmu import Experiment
from cardsflow_fmu.models.native.fields import NATIVE_MODELS
from cardsflow_fmu.runtime.model_file import NATIVE_FILE
from cardsflow_fmu.simulation.build import build

ESTIMATED = {"run.duration": 0.3, "estimator.exact_transition": True}


@pytest.mark.slow
def test_native_fmu_contains_no_python(tmp_path: Path) -> None:
    experiment = Experiment.load(EXAMPLES / "planar_2r")
    for file in build(experiment, tmp_path, compute="c").values():
        names = zipfile.ZipFile(file).namelist()
        resources = {name for name in names if name.startswith("resources/")}
        assert resources >= {f"resources/{NATIVE_FILE}", "resources/ports.bin"}
        assert not [name for name in names if name.endswith((".py", "model.json", "python.txt"))]
        description = fmpy.read_model_description(str(file))
        assert not description.coSimulation.needsExecutionTool
        assert description.coSimulation.canGetAndSetFMUstate
        if "CARDSFLOW_LIBRARY_DIR" not in os.environ:  # sanitizers increase the size
            entries = zipfile.ZipFile(file).infolist()
            libraries = [entry for entry in entries if "binaries/" in entry.filename]
            assert libraries
            for entry in libraries:  # code for Windows is larger
                is_windows = entry.filename.endswith(".dll")
                assert (entry.compress_size if is_windows else entry.file_size) < 590_000


@pytest.mark.cases(2)
@pytest.mark.slow
@pytest.mark.parametrize("model", NATIVE_MODELS)
@pytest.mark.native
def test_restored_states_are_bit_identical(model: str, tmp_path: Path) -> None:
    """Continue after restoring a state; also in another instance, from serialised bytes."""
    experiment = Experiment.load(EXAMPLES / "roboy_left_arm", ESTIMATED)
    file = build(experiment, tmp_path, compute="c")[model]
    check_states_repeat(file, tmp_path / "unpacked", step=1e-2)


@pytest.mark.parametrize(
    ("example", "settings", "message"),
    [
        ("planar_2r", {"controller.solver": "daqp"}, "the QP solver 'daqp'"),
        ("pick_up", {}, "worlds with contacts.*without --compute c"),
    ],
)
def test_unsupported_features_are_rejected_by_name(
    example: str, settings: dict[str, object], message: str, tmp_path: Path
) -> None:
    experiment = Experiment.load(EXAMPLES / example, settings)
    with pytest.raises(InputError, match=message):
        build(experiment, tmp_path / "out", compute="c")
    assert not (tmp_path / "out").exists()


@pytest.mark.cases(2)
@pytest.mark.slow
@pytest.mark.parametrize("model", NATIVE_MODELS)
@pytest.mark.native
def test_damaged_file_is_rejected(model: str, tmp_path: Path) -> None:
    """Also with a correct checksum: all numbers are checked."""
    experiment = Experiment.load(EXAMPLES / "roboy_left_arm", ESTIMATED)
    file = build(experiment, tmp_path, compute="c")[model]
    folder = tmp_path / "unpacked"
    fmpy.extract(str(file), str(folder))
    target = folder / "resources" / NATIVE_FILE
    sound = target.read_bytes()
    host = load(folder)
    rng, rejected = np.random.default_rng(0), 0
    for _ in range(300):
        damaged = bytearray(sound)
        for _ in range(rng.integers(1, 4)):
            at = rng.integers(20, len(damaged)) if rng.random() < 0.5 else rng.integers(20, 120)
            damaged[at] = rng.integers(256)
        damaged[16:20] = struct.pack("<I", zlib.crc32(bytes(damaged[20:])))
        target.write_bytes(bytes(damaged))
        rejected += not host.instantiate(host.slave.guid, (folder / "resources").as_uri())
    assert rejected > 50
    for cut in range(0, len(sound), 97):
        target.write_bytes(sound[:cut])
        assert not host.instantiate(host.slave.guid, (folder / "resources").as_uri())
        assert "native.bin" in host.last
