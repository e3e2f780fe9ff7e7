"""Headers that the build generates from the table of muscle laws, and rejected tables."""

from __future__ import annotations

from pathlib import Path

import pytest

from addin_sdfusion.robot import CardsflowError
from addin_sdfusion.robot.model.laws import LAW_NAMES, MUSCLE_LAWS
from addin_sdfusion.robot.model.laws.law import MuscleLawDefinition, Rule, positive
from sim_dart.core import library
from sim_dart.muscles.law_headers import CSRC, LawTableError, headers


def _write(folder: Path, law: MuscleLawDefinition, c_file: str) -> str:
    """Write a source tree with one law and return its list of laws."""
    laws = folder / CSRC / "laws"
    laws.mkdir(parents=True)
    (laws / "one.c").write_text(c_file)
    return "\n".join(headers({law.kind: law}, "law one k\n", folder).values())


def _law(**more: object) -> MuscleLawDefinition:
    return MuscleLawDefinition("one", "a law", "f = k", (positive("k", "N", None, "k"),), **more)  # type: ignore[arg-type]


SOUND = "TENSION_LAW(one) = {0};\n"


def test_conditions_are_translated_from_the_table(tmp_path: Path) -> None:
    made = _write(tmp_path, _law(rules=(Rule("2 * k < 3 or k == 5"),)), SOUND)
    assert '{0, INFINITY, 1, "above 0"}' in made
    assert "(value_of((2.0 * p->k)) < 3.0) || (value_of(p->k) == 5.0)" in made
    assert '#include "../csrc/laws/one.c"' in made


@pytest.mark.parametrize(
    ("law", "c_file", "what"),
    [
        (_law(), "", "no C file defines TENSION_LAW(one)"),
        (_law(), SOUND + "TENSION_LAW(two) = {0};\n", "no module defines the law 'two'"),
        (_law(rules=(Rule("c > 0"),)), SOUND, "one: 'c > 0' is not a formula: c is neither"),
        (_law(rules=(Rule("k >"),)), SOUND, "one: 'k >' is not a formula"),
        (_law(rules=(Rule("k ** 2 > 1"),)), SOUND, "one: 'k ** 2 > 1' is not a formula"),
        (_law(rules=(Rule("open(k)"),)), SOUND, "one: 'open(k)' is not a formula"),
    ],
)
def test_mismatch_of_table_and_c_files_is_rejected(
    law: MuscleLawDefinition, c_file: str, what: str, tmp_path: Path
) -> None:
    with pytest.raises(LawTableError) as refused:
        _write(tmp_path, law, c_file)
    assert what in str(refused.value)


def test_core_with_another_table_is_rejected(monkeypatch: pytest.MonkeyPatch) -> None:
    assert [line.split()[1] for line in LAW_NAMES.splitlines()] == list(MUSCLE_LAWS)
    monkeypatch.setattr(library, "LAW_NAMES", LAW_NAMES + "law other\n")
    with pytest.raises(CardsflowError, match="compiled with other muscle laws"):
        library.library.__wrapped__()
