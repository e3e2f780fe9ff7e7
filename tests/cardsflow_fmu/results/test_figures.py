"""Figures of many signals: ten curves are drawn, and the axes keep their width."""

from __future__ import annotations

import re
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from support.command_line import CommandLine

from cardsflow_fmu.results.report.curve_selection import curve_colours, select_curves
from cardsflow_fmu.results.report.figures import figure_of_panels
from cardsflow_fmu.results.report.panels import Curve, Panel, all_panels, panels_of
from cardsflow_fmu.results.run_data import RunData
from cardsflow_fmu.results.saved_run import read_results

MUSCLES = 76
LARGE = [7 * k for k in range(10)]


@pytest.fixture
def many(tmp_path: Path) -> Path:
    """Write results with 76 forces, ten of them large, and 61 joints with references."""
    time = np.linspace(0.0, 1.0, 21)
    columns = {"time": time}
    for k in range(MUSCLES):
        size = 100.0 + k if k in LARGE else 1.0 + 0.01 * k
        columns[f"f.a_rather_long_name_of_the_group_{k // 8}_muscle_{k}"] = size * time
    for k in range(61):
        columns[f"q.joint_{k}"] = 3.0 + (1.0 if k >= 51 else 0.01) * time
    columns |= {name.replace("q.", "q_d."): c for name, c in columns.items() if name[0] == "q"}
    file = tmp_path / "many.csv"
    table = np.column_stack(list(columns.values()))
    np.savetxt(file, table, delimiter=",", header=",".join(columns), comments="")
    return file


@pytest.mark.slow
def test_ten_largest_curves_are_drawn_and_the_others_are_counted(
    many: Path, cardsflow: CommandLine, tmp_path: Path
) -> None:
    assert cardsflow("plot", many, "-o", tmp_path / "f.svg", "--panels", "forces")[0] == 0
    texts = re.findall(r"<text[^>]*>([^<]*)</text>", (tmp_path / "f.svg").read_text())
    assert sorted(int(t.split("_")[-1]) for t in texts if t.startswith("f.")) == LARGE
    assert "66 smaller not shown" in texts


def test_positions_are_selected_by_change_with_their_references(many: Path) -> None:
    (panel,) = panels_of(read_results(many), ["tracking"])
    drawn = select_curves(panel)
    assert [c.name for c in drawn.curves] == [f"q.joint_{k}" for k in range(51, 61)]
    assert [c.name for c in drawn.references] == [f"q_d.joint_{k}" for k in range(51, 61)]
    assert drawn.omitted == 51


@pytest.mark.slow
def test_plot_uses_most_of_the_figure_width(many: Path) -> None:
    figure = figure_of_panels(panels_of(read_results(many)))
    figure.draw_without_rendering()
    for axes in figure.axes:
        box, legend = axes.get_position(), axes.get_legend().get_window_extent()
        assert box.width > 0.55
        assert legend.height <= axes.get_window_extent().height
        assert legend.x1 <= figure.bbox.x1 + 1.0


def test_muscles_named_by_numbers_are_in_the_legend() -> None:
    """Cables of CASPR usually have numbers, so that their signals begin with an underscore."""
    time = np.linspace(0.0, 1.0, 3)
    curves = tuple(Curve(name, time, time) for name in ("_1", "_2"))
    (axes,) = figure_of_panels([Panel("force [N]", curves)]).axes
    legend = axes.get_legend()
    assert legend is not None
    assert [text.get_text() for text in legend.get_texts()] == ["_1", "_2"]


def test_nan_does_not_affect_the_selection_of_curves() -> None:
    time = np.arange(3.0)
    curves = [Curve(f"f.{k}", time, np.full(3, np.nan)) for k in range(10)]
    curves.append(Curve("f.ten", time, np.array([0.0, np.inf, 5.0])))
    assert "f.ten" in [c.name for c in select_curves(Panel("N", curves)).curves]


def test_diverged_run_has_panels() -> None:
    names, far = ("time", "q.a", "q_d.a", "q_hat.a", "sd.a"), 1e308
    rows = np.array([[0.1 * k, far, -far, -far, far] for k in range(3)])
    result = RunData(names, rows, {}, {}, solve_times=np.array([[0.0, far]]))
    assert {"errors", "estimate", "solve_times"} <= all_panels(result).keys()


def test_characters_missing_in_the_font_are_named(
    cardsflow: CommandLine, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Control characters, which SVG does not support, are replaced."""
    (file := tmp_path / "a.csv").write_text("time,q.関節\a\n0.0,1.0\n1.0,2.0\n", encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    code, _, err = cardsflow("plot", file, "-o", "a.png")
    assert code == 0
    assert err.startswith("cardsflow: warning: the font of the figure does not contain '関節")
    assert len(err.splitlines()) == 1
    assert cardsflow("plot", file, "-o", "a.svg")[::2] == (0, "")
    texts = ElementTree.parse(tmp_path / "a.svg").getroot().itertext()
    assert any("q.関節\N{REPLACEMENT CHARACTER}" in text for text in texts)


def test_curves_of_a_group_have_one_hue_and_different_colours() -> None:
    names = ["f.left_motor1", "f.left_motor2", "f.right_motor1", "f.right_motor2"]
    left, light_left, right, light_right = curve_colours(names)
    assert len({left, light_left, right, light_right}) == 4
    for dark, light in ((left, light_left), (right, light_right)):
        away_from_white = [
            np.array([255 - int(c[i : i + 2], 16) for i in (1, 3, 5)]) for c in (dark, light)
        ]
        cosine = np.dot(*away_from_white) / np.prod(np.linalg.norm(away_from_white, axis=1))
        assert cosine > 0.999  # the same hue
    assert len(set(curve_colours([f"f.cable_{k}" for k in range(1, 11)]))) == 10
