"""`cardsflow view`, and the live view of `cardsflow run --view`."""

from __future__ import annotations

import argparse
import contextlib
import sys
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from addin_sdfusion.robot import Finding, InputError
from cardsflow_fmu.utils.interrupts import collect_interrupts

from .common import (
    GOOD,
    ROBOT_FILE,
    add_cable_set,
    add_json,
    add_overwrite,
    add_settings,
    parse_settings,
    print_files,
    print_findings,
)
from .parser import Commands

if TYPE_CHECKING:
    from cardsflow_fmu.cosim.recording import Watch
    from cardsflow_fmu.experiment.experiment import Experiment
    from cardsflow_fmu.simulation.result import Result
    from cardsflow_fmu.utils.arrays import FloatArray


def add_view(commands: Commands) -> None:
    """Add `view`."""
    parser = commands.add(
        "view",
        _view,
        "Show a run or a robot in 3-D in the browser.",
        "cardsflow view results --html arm.html",
        "With --html it writes a self-contained HTML page instead.",
    )
    parser.add_argument("path", type=Path, help=f"the folder of a run; or {ROBOT_FILE}")
    text = "the folder of another run to show next to it (default: none)"
    parser.add_argument("other", type=Path, nargs="?", help=text)
    add_cable_set(parser)
    text = "scale the colours of muscles to f_max (default: to the largest tension of the run)"
    parser.add_argument("--full-scale", action="store_true", help=text)
    _add_page_options(parser)


def add_play(commands: Commands) -> None:
    """Add `play`."""
    parser = commands.add(
        "play",
        _play,
        "Drive, pull and change a simulated robot in the browser.",
        "cardsflow play examples/roboy_left_arm",
        "The page contains plant and controller; with --html it works without CARDSFlow.",
    )
    text = f"an experiment.toml or the folder that contains it; or {ROBOT_FILE}"
    parser.add_argument("path", type=Path, help=text)
    add_settings(parser)
    _add_page_options(parser)


def add_edit(commands: Commands) -> None:
    """Add `edit`."""
    parser = commands.add(
        "edit",
        _edit,
        "Add muscles to a robot and change them in the browser.",
        "cardsflow edit arm.urdf",
        "It writes them to muscles.csv next to the robot file, which stays unchanged.",
    )
    parser.add_argument("robot", type=Path, help=ROBOT_FILE)
    _add_page_options(parser)


def _add_page_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of commands that serve or write a page."""
    text = "write a self-contained HTML page; open no browser (default: none)"
    parser.add_argument("--html", type=Path, metavar="FILE", help=text)
    add_overwrite(parser)
    add_live_options(parser)
    add_json(parser, "the file name of --html")


def _edit(options: argparse.Namespace) -> int:
    from cardsflow_fmu.results.viewer.html.edit_page import edit_page
    from cardsflow_fmu.results.viewer.live.page_server import new_token
    from cardsflow_fmu.results.viewer.view import PAGES, serve
    from cardsflow_fmu.simulation.edit import EditSession
    from cardsflow_fmu.utils.overwrite import output_file, write_output

    html = options.html and output_file(options.html, PAGES, overwrite=options.overwrite)
    if options.json and not html:
        raise InputError("needs --html", key="--json")
    session = EditSession(options.robot, _print_line)
    _note(session.findings)
    if html:
        page = edit_page(session.robot, session.file.parent, session.data(None))
        print_files([write_output(html, page)], options.json)
        return GOOD
    token = new_token()

    def current_page() -> str:
        session.reload()
        return edit_page(session.robot, session.file.parent, session.data(token))

    _print_line(session.summary)
    serve(
        current_page,
        port=options.port,
        browser=not options.no_browser,
        report=_print_line,
        actions={"/evaluate": session.evaluate, "/save": session.save},
        token=token,
    )
    return GOOD


def _play(options: argparse.Namespace) -> int:
    from cardsflow_fmu.results.viewer.html.play_page import play_page
    from cardsflow_fmu.results.viewer.view import PAGES, serve
    from cardsflow_fmu.simulation.play import is_robot, playable
    from cardsflow_fmu.utils.overwrite import output_file, write_output

    html = options.html and output_file(options.html, PAGES, overwrite=options.overwrite)
    with playable(options.path, parse_settings(options.set), _print_line) as experiment:
        robot_file = options.path.as_posix() if is_robot(options.path) else ""
        page = play_page(experiment, robot_file, options.set)
    if html:
        print_files([write_output(html, page)], options.json)
    elif options.json:
        raise InputError("needs --html", key="--json")
    else:
        serve(page, port=options.port, browser=not options.no_browser, report=_print_line)
    return GOOD


def add_live_options(parser: argparse.ArgumentParser) -> None:
    """Add port and browser of a page."""
    text = "port of the page (default: the first free one from 8080)"
    parser.add_argument("--port", type=_port, metavar="N", help=text)
    text = "only print the address of the page (default: open a browser)"
    parser.add_argument("--no-browser", action="store_true", help=text)


def _port(text: str) -> int:
    port = int(text)
    if not 0 < port < 65536:
        raise ValueError
    return port


def _view(options: argparse.Namespace) -> int:
    from cardsflow_fmu.results.viewer.view import acts_of, page_of, serve, write_page

    if options.json and not options.html:
        raise InputError("needs --html", key="--json")
    paths = [options.path] + ([options.other] if options.other else [])
    acts = acts_of(paths, cable_set=options.cable_set, full_scale=options.full_scale, note=_note)
    if options.html:
        file = write_page(acts, options.html, overwrite=options.overwrite)
        print_files([file], options.json)
    else:
        browser = not options.no_browser
        serve(page_of(acts), port=options.port, browser=browser, report=_print_line)
    return GOOD


def _note(findings: Sequence[Finding]) -> None:
    print_findings(findings, rest="cardsflow check")


@contextlib.contextmanager
def live_watch(
    experiment: Experiment, options: argparse.Namespace
) -> Iterator[tuple[Watch | None, Callable[[Result], None]]]:
    """Provide functions that show and publish a run, and that replay it until Ctrl-C."""
    watches: list[Watch] = []

    def watch(names: tuple[str, ...], rows: FloatArray) -> None:
        for one in watches:
            one(names, rows)

    with contextlib.ExitStack() as stack:
        if options.publish is not None:
            watches.append(stack.enter_context(_publish(experiment, options.publish)))
        replay: Callable[[Result], None] = lambda result: None  # noqa: E731
        if options.view:
            follow, replay = stack.enter_context(_live_view(experiment, options))
            watches.append(follow)
        yield watch if watches else None, replay


@contextlib.contextmanager
def _publish(experiment: Experiment, uri: str) -> Iterator[Watch]:
    from cardsflow_fmu.ros.publisher import published
    from cardsflow_fmu.ros_interface.address import node_address

    with published(experiment, node_address(uri), _print_line) as watch:
        yield watch


@contextlib.contextmanager
def _live_view(
    experiment: Experiment, options: argparse.Namespace
) -> Iterator[tuple[Watch, Callable[[Result], None]]]:
    from cardsflow_fmu.results.viewer import view
    from cardsflow_fmu.results.viewer.html.page import replay_page
    from cardsflow_fmu.results.viewer.live.page_server import page_server
    from cardsflow_fmu.results.viewer.live.run_stream import stream_frames

    act = view.experiment_act(experiment)
    with page_server(replay_page([act], follows=True), options.port) as server:
        view.announce(server.address, browser=not options.no_browser, report=_print_line)

        def replay(result: Result) -> None:
            with collect_interrupts() as received:
                server.replace(replay_page([view.act_of(result)]))
                view.wait_for_interrupt(received)

        stage = act.stage
        yield stream_frames(server, stage.robot, stage.meshes, experiment.scene), replay


def _print_line(line: str) -> None:
    print(line, file=sys.stderr, flush=True)


def reject_view(options: argparse.Namespace, problem: str) -> None:
    """Reject `--view` and `--publish` if nothing can be shown.

    Raises:
        InputError: One of the options is given.
    """
    if options.view or options.publish is not None:
        raise InputError(problem, key="--view" if options.view else "--publish")
