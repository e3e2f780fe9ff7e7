"""Pages of robots, experiments and results in notebooks and scripts: `show()`."""

from __future__ import annotations

import sys
import tempfile
import webbrowser
from dataclasses import replace
from html import escape
from pathlib import Path

from addin_sdfusion.robot import InputError, Robot
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.results.run_data import ExperimentRunData

from .html.page import replay_page
from .html.play_page import play_page
from .view import act_of, experiment_act, page_of, still_act, write_html


class ShownPage:
    """Page that a notebook displays in its output.

    The output contains the whole page, so that it also works over HTTP, in VS Code and in exported
    notebooks.

    Attributes:
        html: The self-contained page.
    """

    def __init__(self, html: str) -> None:
        self.html = html

    def _repr_html_(self) -> str:
        """Return the page in a frame that is isolated from the notebook."""
        style = "width: 100%; height: 560px; border: 1px solid #8888; border-radius: 8px"
        # Scripts must keep their hash, whatever the character set of the notebook's page.
        inner = escape(self.html).encode("ascii", "xmlcharrefreplace").decode()
        return (
            f'<iframe title="CARDSFlow" sandbox="allow-scripts" style="{style}" '
            f'srcdoc="{inner}"></iframe>'
        )

    def __repr__(self) -> str:
        return f"<page of {len(self.html) // 1024} KiB; .save('page.html') writes it>"

    def save(self, file: str | Path, *, overwrite: bool = False) -> Path:
        """Write the page."""
        return write_html(self.html, file, overwrite=overwrite)


def show(
    content: Robot | Experiment | ExperimentRunData, folder: str | Path | None = None
) -> ShownPage:
    """Return the page of a robot, experiment or result; outside of notebooks, open the browser.

    Args:
        folder: Folder of the robot with its meshes (default: none, links are capsules).

    Raises:
        InputError: The result has no rows, or lacks joint positions.
    """
    return shown(_page(content, folder))


def shown(html: str) -> ShownPage:
    """Return a page for the output of a notebook; outside of notebooks, open the browser."""
    page = ShownPage(html)
    if not _in_notebook():
        with tempfile.NamedTemporaryFile(
            "w", suffix=".html", delete=False, encoding="utf-8"
        ) as file:
            file.write(page.html)
        webbrowser.open(Path(file.name).as_uri())
    return page


def _page(content: Robot | Experiment | ExperimentRunData, folder: str | Path | None) -> str:
    if isinstance(content, Robot):
        return page_of([still_act(content, None if folder is None else Path(folder))])
    if not isinstance(content, Experiment):
        return page_of([act_of(content)])
    try:
        return play_page(content)
    except InputError as error:
        act = experiment_act(content)
        note = f"warning: {error.problem}"
        return replay_page([replace(act, notes=(note, *act.notes))])


def _in_notebook() -> bool:
    """Return whether the process is the kernel of a notebook."""
    kernel = sys.modules.get("ipykernel.kernelapp")
    return kernel is not None and bool(kernel.IPKernelApp.initialized())
