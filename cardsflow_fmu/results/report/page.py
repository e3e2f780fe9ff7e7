"""Report of a run as a self-contained HTML page: `cardsflow report`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from html import escape
from pathlib import Path

from matplotlib.figure import Figure

from addin_sdfusion.robot import Coordinate
from addin_sdfusion.robot.formats.read import read
from addin_sdfusion.robot.json_text import json_text
from cardsflow_fmu.experiment.writer import experiment_data
from cardsflow_fmu.results.analysis.info import robot_info, robot_tables, robot_title
from cardsflow_fmu.results.estimation import describe_event
from cardsflow_fmu.results.run_data import ExperimentRunData
from cardsflow_fmu.results.saved_run import opened_run
from cardsflow_fmu.results.verdict import failure_text
from cardsflow_fmu.results.viewer.html.page import replay_page, replay_script
from cardsflow_fmu.results.viewer.scene.act import Act
from cardsflow_fmu.results.viewer.view import PAGES, act_of
from cardsflow_fmu.utils.overwrite import output_file, write_output

from .figures import figure_of_panels, inline_svg
from .html import collapsible_section, page, section, table
from .panels import all_panels
from .summary_html import short_outcome, summary_tables

_BINS = 500


def report(path: str | Path, file: str | Path, *, overwrite: bool = False) -> Path:
    """Write the report of a run."""
    target = output_file(file, PAGES, overwrite=overwrite)
    with opened_run(path) as result:
        text = report_page(result)
    return write_output(target, text)


def report_page(result: ExperimentRunData) -> str:
    """Return the report of a run as an HTML page without external addresses."""
    name = str(result.summary.get("experiment", result.experiment.robot.name))
    act, versions = act_of(result), result.summary.get("versions") or {}
    return page(
        f"{name}: report",
        f"<h1>{escape(name)}</h1>",
        *_verdict(result),
        section("Replay", replay(act)),
        section("Figures", *_figures(result)),
        collapsible_section("Summary", *summary_tables(result.summary)),
        collapsible_section("Robot", *_robot(result)),
        collapsible_section("Experiment", f"<pre>{escape(_experiment(result))}</pre>"),
        collapsible_section("Versions", table(("package", "version"), versions.items())),
        scripts=(replay_script(),),
    )


def _verdict(result: ExperimentRunData) -> list[str]:
    """Return warnings and the outcome of the run."""
    lines = []
    if not result.complete:
        error = result.summary.get("error") or "the run ended early"
        lines.append(f"Incomplete run: {error}")
    if (failed := failure_text(result.summary)) is not None:
        lines.append(failed)
    lines += [f"Fault: {describe_event(event)}" for event in result.summary.get("faults") or ()]
    lines += [f"Warning: {warning}" for warning in result.summary.get("warnings") or ()]
    notices = [f'<p class="notice">{escape(line)}</p>' for line in lines]
    kind = "verdict" if lines else "verdict good"
    outcome = "; ".join(short_outcome(result.summary))
    return [*notices, f'<p class="{kind}">{escape(outcome)}</p>']


def replay(act: Act) -> str:
    """Return the replay in a sandboxed frame, isolated from the report."""
    inner = escape(replay_page([act]))
    return f'<iframe title="replay" sandbox="allow-scripts" srcdoc="{inner}"></iframe>'


def _figures(result: ExperimentRunData) -> Iterator[str]:
    for kind, panels in all_panels(result).items():
        figure = figure_of_panels(panels, bins=_BINS)
        for axes in figure.axes:
            for event in result.summary.get("faults") or ():
                axes.axvline(event["time"], color="black", linestyle="--", linewidth=0.8)
        yield captioned(figure, kind.replace("_", " "))


def captioned(figure: Figure, caption: str) -> str:
    """Return a figure with a caption."""
    svg = inline_svg(figure, salt=caption.replace(" ", "_"))
    return f"<figure>{svg}<figcaption>{escape(caption)}</figcaption></figure>"


def _robot(result: ExperimentRunData) -> Iterator[str]:
    """Yield tables of links, joints, muscles, and the findings of `check`."""
    experiment = result.experiment
    bounds = {m.name: (m.f_min, m.f_max) for m in experiment.robot.muscles}
    for part in experiment.parts:
        named = {m.name: bounds[f"{part.name}_{m.name}"] for m in part.robot.muscles}
        yield f"<h3>{escape(part.name)}</h3>"
        yield from _robot_tables(part.files[0], part.robot.cable_set, named, part.robot.motors)
    if not experiment.parts:
        robot = experiment.robot
        yield from _robot_tables(experiment.robot_path, robot.cable_set, bounds, robot.motors)


def _robot_tables(
    path: Path,
    cable_set: str,
    bounds: Mapping[str, tuple[float, float]],
    motors: Sequence[Coordinate],
) -> Iterator[str]:
    info = robot_info(path, cable_set or None)
    for muscle in info["muscles"]:
        muscle["f_min"], muscle["f_max"] = bounds[muscle["name"]]
    torques = {motor.name: (motor.tau_min, motor.tau_max) for motor in motors}
    for c in info["coordinates"]:
        c["actuated"] = c["name"] in torques
        c["tau_min"], c["tau_max"] = torques.get(c["name"], (None, None))
    yield f"<p>{escape(robot_title(info))}</p>"
    yield table(("link", "mass [kg]"), ([x["name"], x["mass"]] for x in info["links"]))
    yield from (table(heads, rows) for heads, rows in robot_tables(info))
    findings = read(path, cable_set or None).findings
    rows = [["error" if f.is_error else "warning", f.message] for f in findings]
    yield table(("check", "finding"), rows) if rows else "<p>check: no findings</p>"


def _experiment(result: ExperimentRunData) -> str:
    """Return all settings with defaults; file paths are relative to the experiment."""
    text = json_text(experiment_data(result.experiment), indent=2, ensure_ascii=False)
    folder = json_text(f"{result.experiment.file.parent}/", ensure_ascii=False)[1:-1]
    return text.replace(folder, "")
