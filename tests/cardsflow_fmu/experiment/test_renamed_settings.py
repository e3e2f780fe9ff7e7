"""Old keys of settings: experiments reject them with the new name; archives are still read."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import pytest
from support.experiments import write_resources
from support.robots.robots import EXAMPLES, PLANAR_2R

from addin_sdfusion.robot import InputError
from cardsflow_fmu.experiment.experiment import EXPERIMENT_FILE, Experiment
from cardsflow_fmu.experiment.renamed_settings import RENAMED_SETTINGS

BALL = {"name": "ball", "shape": "sphere", "radius": 0.1, "mass": 1.0, "position": [9, 9, 9]}

SETTINGS: dict[str, Any] = {
    "estimator.exact": False,
    "estimator.feeds": False,
    "estimator.largest_innovation": 3.0,
    "estimator.largest_sd.joint_1": 0.1,
    "estimator.search": False,
    "estimator.slack": 1.0,
    "estimator.starts": 3,
    "estimator.units[0].link": "link_2",
    "hardware.emulator.differences": True,
    "hardware.tension_max": 200.0,
    "world.objects": [{**BALL, "spin": [0.0, 0.0, 1.0]}],
}


@pytest.mark.parametrize("key", SETTINGS)
def test_old_key_is_rejected_with_its_new_name(key: str) -> None:
    with pytest.raises(InputError, match="was renamed to") as error:
        Experiment.load(PLANAR_2R, {key: SETTINGS[key]})
    old = str(error.value.key)
    assert key.startswith(old) or (key, old) == ("world.objects", "world.objects.spin")
    assert error.value.what == f"was renamed to {RENAMED_SETTINGS[old]}"


def test_every_old_key_in_a_file_is_reported(tmp_path: Path) -> None:
    shutil.copytree(PLANAR_2R, tmp_path / "arm")
    file = tmp_path / "arm" / "experiment.toml"
    file.write_text(file.read_text() + "\n[estimator]\nsearch = true\nstarts = 3\n")
    with pytest.raises(InputError) as error:
        Experiment.load(file)
    lines = [f"{one.key}: {one.what}" for one in (error.value, *error.value.more)]
    assert lines == [
        "estimator.search: was renamed to estimator.find_start",
        "estimator.starts: was renamed to estimator.start_candidates",
    ]


def test_archive_with_old_keys_is_read(tmp_path: Path) -> None:
    settings = {
        "estimator": {"find_start": True, "imus": [{"link": "link_2"}], "max_sd": 0.2},
        "world": {"objects": [{**BALL, "angular_velocity": [0.0, 0.0, 1.0]}]},
    }
    experiment = Experiment.load(EXAMPLES / "planar_2r", settings)
    folder = write_resources(experiment, tmp_path)
    file = folder / EXPERIMENT_FILE
    data = json.loads(file.read_text())
    for old, new in RENAMED_SETTINGS.items():
        (*path, last), name = old.split("."), new.rpartition(".")[2]
        table = data.get(path[0], {})
        rows = table.get("objects", []) if path[-1] == "objects" else [table]
        for row in rows:
            if name in row:
                row[last] = row.pop(name)
    data["run"]["coupling"] = data["run"].pop("scheme")
    assert "units" in data["estimator"]
    assert "spin" in data["world"]["objects"][0]
    file.write_text(json.dumps(data))
    again = Experiment.from_resources(folder)
    assert again.estimator == experiment.estimator
    assert again.world == experiment.world
