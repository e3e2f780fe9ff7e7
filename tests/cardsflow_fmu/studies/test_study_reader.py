"""Reader for study.toml: valid and invalid studies."""

from __future__ import annotations

from pathlib import Path

import pytest
from support.small_studies import KP, ROOT, SHORT, small_study, write_study

from addin_sdfusion.robot import InputError, UnknownNameError
from cardsflow_fmu.studies import Study
from cardsflow_fmu.studies.definition.variations import Range


def vary(path: str, values: str = "values = [1.0]") -> str:
    return f"[[vary]]\npath = '{path}'\n{values}\n"


@pytest.mark.slow
@pytest.mark.parametrize("name", ["attachments.toml", "flower"])
def test_the_examples_are_valid_studies(name: str) -> None:
    study = Study.load(ROOT / "examples" / "design_study" / name)
    assert study.variations
    assert study.name == Path(name).stem
    assert "results" in study.output.parts


def test_a_star_matches_every_name(tmp_path: Path) -> None:
    study = small_study(tmp_path, vary("plant.mass_scale.*", "uniform = [0.8, 1.2]"), "count = 2")
    assert [v.paths for v in study.variations] == [
        ("plant.mass_scale.link_1",),
        ("plant.mass_scale.link_2",),
    ]


def test_a_star_together_is_one_variation(tmp_path: Path) -> None:
    text = "together = true\nuniform = [0.0, 5.0]"
    (one,) = small_study(tmp_path, vary("muscles.*.f_min", text), "count = 2").variations
    assert one.name == "muscles.*.f_min"
    assert one.paths == tuple(f"muscles.cable_{k}.f_min" for k in (1, 2, 3, 4))


def test_a_box_is_one_variation_per_axis(tmp_path: Path) -> None:
    text = "name = 'end'\nbox = { from = [0.0, 0.5, 0.2], to = [0.1, 0.5, 0.4] }"
    path = "robot.muscles.cable_1.points[1].position"
    study = small_study(tmp_path, vary(path, text), "count = 2")
    assert [v.name for v in study.variations] == ["end[0]", "end[1]", "end[2]"]
    assert [v.range for v in study.variations] == [
        Range("uniform", (0.0, 0.1)),
        Range("values", (0.5,)),
        Range("uniform", (0.2, 0.4)),
    ]


def test_settings_are_full_keys_or_tables(tmp_path: Path) -> None:
    short = '[settings]\n"run.step" = 0.01\nrun.duration = 0.2\ncontroller = { period = 0.01 }'
    study = small_study(tmp_path, short=short)
    given = {"run.step": 0.01, "run.duration": 0.2, "controller.period": 0.01}
    assert study.settings == given | {"run.compute": "c", "run.coupling": "direct"}


@pytest.mark.parametrize(
    ("path", "nearest"),
    [
        ("controller.kpp", "'kp'"),
        ("contoller.kp", "'controller'"),
        ("controller.kp.joint_3", "'joint_"),
        ("muscles.cabel_1.f_max", "'cable_1'"),
        ("plant.mass_scal.*", "'mass_scale'"),
        ("robot.muscles.cable_1.point[0].position", "'points'"),
        ("robot.links.link_1.inertia.masss", "'mass'"),
        ("robot.links.*.inertia.masss", "'mass'"),
    ],
)
def test_an_unknown_path_is_rejected_with_a_suggestion(
    tmp_path: Path, path: str, nearest: str
) -> None:
    with pytest.raises(InputError, match=f"did you mean {nearest}") as caught:
        small_study(tmp_path, vary(path))
    assert caught.value.key == "vary[0].path"
    assert caught.value.file == tmp_path / "study.toml"


@pytest.mark.parametrize(
    ("text", "top", "message"),
    [
        (vary("controller.kp", "values = []"), "", "at least one value"),
        (
            vary("controller.kp", "grid = { from = 1, to = 2, count = 0 }"),
            "",
            "must be from 1 to 1000000, not 0",
        ),
        (vary("controller.kp", ""), "", "requires exactly one of"),
        (vary("controller.kp", "values = [1.0]\nuniform = [1.0, 2.0]"), "", "found 2"),
        (vary("controller.kp", "values = [1979-05-27]"), "", "date"),
        (vary("controller.kp", "values = [inf]"), "", "finite"),
        (vary("controller.kp", "uniform = [2.0, 1.0]"), "count = 2", "two increasing numbers"),
        (vary("controller.kp", "loguniform = [0.0, 1.0]"), "count = 2", "must be positive"),
        (vary("controller.kp", "normal = [1.0, 0.0]"), "count = 2", "standard deviation"),
        (vary("controller.kp", "uniform = [1.0, 2.0]"), "", "must be 1 to"),
        (vary("controller.kp", "uniform = [1.0, 2.0]"), "count = 0", "must be 1 to"),
        (vary("controller.kp", "uniform = [1.0, 2.0]"), "sampler = 'grid'", "requires `values`"),
        (vary("controller.kp", "uniform = [1, 2]"), "sampler = 'sobl'", "did you mean 'sobol'"),
        (
            vary("controller.kp", "uniform = [1.0, 2.0]"),
            "sampler = 'sensitivity'\ncount = 6",
            "power of 2",
        ),
        (KP + KP, "", "duplicate name"),
        (KP + vary("controller.kd", "values = [1.0]"), "sampler = 'list'", "same number of values"),
        (KP, "count = 3", "whose values define the number of runs"),
        (KP, "compute = 'pyton'", "did you mean 'python'"),
        (KP, "metrics = ['tracking.rsm']", "did you mean 'tracking.rms'"),
        (KP, "metrics = ['force.peak.cable_9']", "no muscle 'cable_9'"),
        (KP, "metrics = []", "at least one name"),
        (KP, "seed = -1", "negative"),
        (KP.replace("grid", "seed = 'a'\ngrid"), "", "seed: must be true, not 'a'"),
        (KP, "sede = 1", "did you mean 'seed'"),
        ("", "vary = 3", "vary: must be a list of tables"),
        (vary("controller..kp"), "", "names with dots"),
        (vary("run.duration.x.y"), "", "not a table"),
        (KP + "[optimise]\nobjective = 'force.peek'\n", "", "did you mean 'force.peak'"),
        (KP + "[optimise]\nobjective = 'force.peak'\npopulation = 2\n", "", "at least 5"),
        (KP + "[optimise]\nobjective = 'force.peak.*'\n", "", "without `\\*`"),
        (
            KP + "[optimise]\nobjective = 'force.peak'\npopulation = 1000000000\n",
            "",
            "the maximum is 1000000",
        ),
        (KP + "[workspace]\npoints = -1\n", "", "too few or too many"),
        (vary("controller.kp", "name = 'run'\nvalues = [1.0]"), "", "another column 'run'"),
        (vary("controller.kp", "name = 'energy'\nvalues = [1.0]"), "", "another column 'energy'"),
        (
            KP + "[optimise]\nobjective = 'force.peak'\nconstraints = [{metric = 'energy'}]\n",
            "",
            "at_least or at_most",
        ),
    ],
)
def test_invalid_studies_are_rejected(tmp_path: Path, text: str, top: str, message: str) -> None:
    with pytest.raises(InputError, match=message) as caught:
        small_study(tmp_path, text, top)
    assert caught.value.file == tmp_path / "study.toml"


def test_a_study_can_be_given_by_its_folder(tmp_path: Path) -> None:
    write_study(tmp_path)
    study = Study.load(tmp_path)
    assert study.name == tmp_path.name
    assert study.output == tmp_path / "results"
    with pytest.raises(InputError, match=r"study\.toml: cannot be read"):
        Study.load(tmp_path.parent)


def test_a_missing_experiment_is_rejected(tmp_path: Path) -> None:
    file = write_study(tmp_path)
    file.write_text('experiment = "nowhere"\n' + SHORT + KP)
    with pytest.raises(InputError, match="nowhere"):
        Study.load(file)


@pytest.mark.parametrize("content", [b"\xff\xfe", b"a = ", b"[" * 5000])
def test_invalid_toml_is_rejected(tmp_path: Path, content: bytes) -> None:
    file = tmp_path / "study.toml"
    file.write_bytes(content)
    with pytest.raises(InputError, match=r"study\.toml"):
        Study.load(file)


def test_an_unknown_name_as_a_value_fails_only_the_run(tmp_path: Path) -> None:
    study = small_study(tmp_path, vary("controller.solver", "values = ['daqp', 'nope']"))
    assert len(study.variations) == 1


def test_an_unknown_engine_lists_the_known_ones(tmp_path: Path) -> None:
    with pytest.raises(UnknownNameError) as caught:
        Study.load(write_study(tmp_path, top="compute = 'nothing'"))
    assert caught.value.known == ("c", "python")
