"""The tour notebook runs completely and is stored without outputs."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest
from support.robots.robots import EXAMPLES

TOUR = EXAMPLES / "tour.ipynb"


def test_tour_is_stored_without_outputs() -> None:
    cells = json.loads(TOUR.read_text(encoding="utf-8"))["cells"]
    assert all(not cell.get("outputs") and cell.get("execution_count") is None for cell in cells)
    assert TOUR.stat().st_size < 20_000


@pytest.mark.slow
@pytest.mark.filterwarnings("default")  # the notebook kernel has its own warning filters
def test_tour_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    nbclient = pytest.importorskip("nbclient")
    nbformat = pytest.importorskip("nbformat")
    pytest.importorskip("ipykernel")
    for variable in ("IPYTHONDIR", "JUPYTER_RUNTIME_DIR", "JUPYTER_DATA_DIR", "TMPDIR"):
        (tmp_path / variable).mkdir()
        monkeypatch.setenv(variable, str(tmp_path / variable))
    folder = tmp_path / "examples"
    unwanted = shutil.ignore_patterns("results")
    shutil.copytree(EXAMPLES, folder, ignore=unwanted)
    tour = nbformat.read(TOUR, as_version=4)
    client = nbclient.NotebookClient(
        tour, timeout=1200, kernel_name="python3", resources={"metadata": {"path": str(folder)}}
    )
    client.execute()
    outputs = [out for cell in tour.cells for out in cell.get("outputs", [])]
    assert not [out for out in outputs if out["output_type"] == "error"]
    assert "image/png" in json.dumps(outputs)
    assert "infeasible ticks" in json.dumps(outputs)
    assert sorted(path.name for path in folder.iterdir()) == sorted(
        path.name for path in EXAMPLES.iterdir()
    )
