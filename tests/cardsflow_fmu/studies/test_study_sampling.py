"""Sampling of studies: grids, lists, samplers, seeds and hashes."""

from __future__ import annotations

import json
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from support.small_studies import small_study

from cardsflow_fmu.studies.definition.sampling import Run, expand, run_count, run_seed, sample
from cardsflow_fmu.studies.definition.study import Study
from cardsflow_fmu.studies.definition.variations import Range

TWO = """
[[vary]]
path = "controller.kp"
{}
[[vary]]
path = "plant.mass_scale"
{}
"""
UNIFORM = TWO.format("uniform = [1000.0, 2000.0]", "uniform = [0.5, 1.5]")


def runs(study: Study) -> list[Run]:
    return list(expand(study, "fingerprint"))


def test_a_grid_combines_all_values(tmp_path: Path) -> None:
    study = small_study(
        tmp_path,
        TWO.format("values = [1.0, 2.0]", "grid = { from = 1.0, to = 2.0, count = 3 }"),
    )
    found = [tuple(run.values.values()) for run in runs(study)]
    assert found == list(product([1.0, 2.0], [1.0, 1.5, 2.0]))
    assert run_count(study) == 6


def test_a_list_combines_values_pairwise(tmp_path: Path) -> None:
    text = TWO.format("values = [1.0, 2.0]", "values = [0.9, 1.1]")
    found = [
        tuple(run.values.values()) for run in runs(small_study(tmp_path, text, "sampler='list'"))
    ]
    assert found == [(1.0, 0.9), (2.0, 1.1)]


def test_a_study_without_variations_has_one_run(tmp_path: Path) -> None:
    for sampler in ("grid", "list"):
        (run,) = runs(small_study(tmp_path, "", f"sampler = '{sampler}'"))
        assert run.settings == {}


@pytest.mark.parametrize("sampler", ["sobol", "latin_hypercube", "monte_carlo"])
def test_samplers_are_reproducible_and_depend_on_the_seed(tmp_path: Path, sampler: str) -> None:
    top = f"sampler = '{sampler}'\ncount = 10\nseed = {{}}"
    first, again = (runs(small_study(tmp_path, UNIFORM, top.format(1))) for _ in range(2))
    other = runs(small_study(tmp_path, UNIFORM, top.format(2)))
    assert first == again
    assert not {run.hash for run in first} & {run.hash for run in other}
    assert len({run.hash for run in first}) == 10


def test_a_latin_hypercube_has_one_point_in_every_stripe() -> None:
    points = np.floor(sample("latin_hypercube", 3, 50, 4) * 50)
    assert (np.sort(points, axis=0) == np.arange(50)[:, np.newaxis]).all()


def test_a_sobol_sequence_has_one_point_in_every_stripe_of_a_power_of_two() -> None:
    points = np.floor(sample("sobol", 3, 64, 4) * 64)
    assert (np.sort(points, axis=0) == np.arange(64)[:, np.newaxis]).all()
    assert (sample("sobol", 3, 40, 4) == sample("sobol", 3, 64, 4)[:40]).all()


def test_distributions_return_their_quantiles() -> None:
    assert Range("uniform", (2.0, 4.0)).at(0.25) == 2.5
    assert Range("loguniform", (1.0, 100.0)).at(0.5) == pytest.approx(10.0)
    assert Range("normal", (3.0, 2.0)).at(0.5) == 3.0
    standard = Range("normal", (0.0, 1.0))
    assert standard.at(0.975) == pytest.approx(1.959963984540054)
    assert np.isfinite([standard.at(u) for u in (0.0, 1.0)]).all()
    listed = Range("values", ("a", "b"))
    assert [listed.at(u) for u in (0.0, 0.49, 0.5, 1.0)] == ["a", "a", "b", "b"]


def test_seeds_of_runs_are_spawned_by_numpy(tmp_path: Path) -> None:
    text = '[[vary]]\npath = "plant.mass_scale"\nseed = true\n'
    study = small_study(tmp_path, text, "sampler = 'monte_carlo'\ncount = 4\nseed = 9")
    root = np.random.SeedSequence(9).spawn(2)[1]
    spawned = [int(child.generate_state(1)[0]) for child in root.spawn(4)]
    assert [run.values["plant.mass_scale"] for run in runs(study)] == spawned
    assert [run_seed(9, k) for k in range(4)] == spawned


def test_a_hash_depends_only_on_the_content(tmp_path: Path) -> None:
    study = small_study(tmp_path)
    one, other = (list(expand(study, text)) for text in ("one", "other"))
    assert not {r.hash for r in one} & {r.hash for r in other}
    assert [r.hash for r in one] == [r.hash for r in expand(study, "one")]
    more = small_study(tmp_path, '[[vary]]\npath = "controller.kp"\nvalues = [7.0, 1000.0]\n')
    assert list(expand(more, "one"))[1].hash == one[0].hash


def test_sensitivity_uses_saltellis_design(tmp_path: Path) -> None:
    study = small_study(tmp_path, UNIFORM, "sampler = 'sensitivity'\ncount = 8")
    values = np.array([list(run.values.values()) for run in runs(study)]).reshape(4, 8, 2)
    A, B, first, second = values
    assert run_count(study) == 32
    assert (first == np.stack([B[:, 0], A[:, 1]], axis=1)).all()
    assert (second == np.stack([A[:, 0], B[:, 1]], axis=1)).all()


def test_settings_are_plain_data(tmp_path: Path) -> None:
    study = small_study(tmp_path, UNIFORM, "count = 3")
    for run in runs(study):
        assert json.loads(json.dumps(run.settings)) == run.settings
