from __future__ import annotations

import json
from pathlib import Path
from unittest.mock import Mock

import pytest

from addin_sdfusion.robot import InputError
from cardsflow_fmu.results import folder as results_folder
from cardsflow_fmu.results.folder import OutputFolder


def test_created_folder_is_removed_if_no_results_are_written(tmp_path: Path) -> None:
    path = tmp_path / "a/b/c"
    with pytest.raises(RuntimeError), OutputFolder(path):
        raise RuntimeError
    assert list(tmp_path.iterdir()) == []
    with OutputFolder(path) as folder:
        folder.write({"results.csv": "time\n"})
    assert [p.name for p in path.iterdir()] == ["results.csv"]


def test_results_are_replaced_together_and_other_files_are_kept(tmp_path: Path) -> None:
    """New results contain no files of an earlier run."""
    (tmp_path / "notes.txt").write_text("mine")
    summary = json.dumps({"versions": {"cardsflow": "1"}})
    with OutputFolder(tmp_path) as folder:
        folder.write({"summary.json": summary, "plant.fmu": b"old", "path.svg": b"old"})
    with OutputFolder(tmp_path) as folder:
        folder.write({"summary.json": summary, "results.csv": "new"})
    names = sorted(p.name for p in tmp_path.iterdir())
    assert names == ["notes.txt", "results.csv", "summary.json"]


def test_fmu_that_no_run_has_written_is_not_replaced(tmp_path: Path) -> None:
    (tmp_path / "plant.fmu").write_text("mine")
    with pytest.raises(InputError, match=r"has a file plant\.fmu that no run has written"):
        OutputFolder(tmp_path).__enter__()


@pytest.mark.parametrize("summary", [None, "{}", "no json", '{"versions": 3}'])
def test_results_that_no_run_has_written_are_not_replaced(
    tmp_path: Path, summary: str | None
) -> None:
    (tmp_path / "results.csv").write_text("mine")
    if summary is not None:
        (tmp_path / "summary.json").write_text(summary)
    with pytest.raises(InputError, match=r"has a file results\.csv that no run has written"):
        OutputFolder(tmp_path).__enter__()
    assert (tmp_path / "results.csv").read_text() == "mine"


def test_unreadable_summary_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("results.csv", "summary.json"):
        (tmp_path / name).write_text("{}")
    denied = InputError("cannot be read: Permission denied", file=tmp_path / "summary.json")
    monkeypatch.setattr(results_folder, "read_file", Mock(side_effect=denied))
    with pytest.raises(InputError, match=r"summary\.json: cannot be read"):
        OutputFolder(tmp_path).__enter__()


def test_folder_that_cannot_be_written_is_an_input_error(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    for path in (tmp_path / "file", tmp_path / "file/below", Path("/proc/none/results")):
        with pytest.raises(InputError, match="cannot be written"):
            OutputFolder(path).__enter__()
    assert [p.name for p in tmp_path.iterdir()] == ["file"]
