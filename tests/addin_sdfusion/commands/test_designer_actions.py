"""Property test: a designer's daily edits never lose or silently move a point."""

from __future__ import annotations

import os
import random
from collections.abc import Callable
from typing import Any

import fake_fusion
import numpy as np
from fake_fusion import Builder, designs
from fake_fusion.maths import apply, translation
from fake_fusion.model.data import transform
from support.designs.exported import read_design, running

from addin_sdfusion.building.build_robot import link_of
from addin_sdfusion.muscles.design_table import read_table

DEFINE = "cardsflowDefineMuscles"
SEQUENCES = int(os.environ.get("CARDSFLOW_DESIGNER_SEQUENCES", "5"))
ACTIONS = 10


def twin_arms(*, referenced: bool = False, nested: bool = False, groups: bool = False) -> Any:
    """A torso and a component `arm` with two occurrences, possibly in a holder."""
    build = Builder("robot")
    torso = build.place("torso", translation((1.0, 2.0, 3.0)), grounded=True)
    build.box(torso, (2.0, 2.0, 2.0))
    order = random.Random(7)
    above = build.place("holder", designs.random_motion(order)) if nested else ()
    component = build.component("arm v3" if referenced else "arm", referenced=referenced)
    paths = [build.place(component, designs.random_motion(order), above=above) for _ in range(2)]
    build.box(paths[0], (1.0, 1.0, 6.0))
    for k, path in enumerate(paths):
        build.joint(f"joint{k}", "revolute", path, torso, axis=(0.0, 1.0, 0.0))
    if groups:
        for name, path in (("torso", torso), ("left", paths[0]), ("right", paths[1])):
            build.rigid_group(f"EXPORT_{name}", [path])
    return build.done()


def three_parts(**more: Any) -> Any:
    """Three different components, joined in a chain."""
    build = Builder("chain", **more)
    designs.chain(build, groups=False)
    return build.done()


DESIGNS: dict[str, Callable[[], Any]] = {
    "twins": twin_arms,
    "external twins": lambda: twin_arms(referenced=True),
    "nested twins": lambda: twin_arms(nested=True),
    "nested external twins": lambda: twin_arms(nested=True, referenced=True),
    "grouped twins": lambda: twin_arms(groups=True),
    "grouped external twins": lambda: twin_arms(groups=True, referenced=True),
    "grouped nested twins": lambda: twin_arms(groups=True, nested=True),
    "chain": three_parts,
    "direct chain": lambda: three_parts(parametric=False),
    "assembly": lambda: three_parts(intent="assembly"),
}


class Designer:
    """A user who defines a muscle, edits the design at random, and checks the points.

    Attributes:
        truth: Occurrence (data) and position in its frame, in [cm], of each via point.
        warned: The same of points that a warning says may be on another occurrence.
    """

    def __init__(self, fusion: Any, order: random.Random) -> None:
        self.fusion, self.order = fusion, order
        self.data = fusion.world.active
        self.truth: dict[int, tuple[Any, np.ndarray]] = {}
        self.warned: dict[int, tuple[Any, np.ndarray]] = {}
        self.log: list[str] = []
        self._undo: list[int] = []

    @property
    def user(self) -> Any:
        return self.fusion.designer

    def define(self) -> None:
        """Pick one vertex on each of the first occurrences with bodies."""
        command = self.fusion.run_command(DEFINE)
        root = self.fusion.design.rootComponent
        for number, occurrence in enumerate(_with_bodies(root)[:4]):
            vertex = occurrence.bRepBodies[0].vertices[number]
            place = np.array(vertex.nativeObject.geometry.asArray())
            self.truth[number] = (occurrence._data, place)
            command.pick("pick", vertex)
        command.ok()
        assert command.failed == ""

    def act(self) -> None:
        """Do one random action; an impossible one does nothing."""
        paths = list(self.user.all_paths())
        visible = [p for p in paths if p in self.user.paths()]
        if not visible:
            self.user.suppress(self.order.choice(paths), False)
            return
        path = self.order.choice(visible)
        component = self.user.paths()[path][-1].component
        T = designs.random_motion(self.order)
        actions: dict[str, Callable[[], Any]] = {
            "rename": lambda: self.user.rename(path, f"part{self.order.randrange(1000)}"),
            "get latest": lambda: self.user.get_latest(
                path, self.order.choice((None, 4, 5)) if component.referenced else 1
            ),
            "paste": lambda: self.user.paste(path, T),
            "paste new": lambda: self.user.paste_new(path, T),
            "suppress": lambda: self.user.suppress(path),
            "unsuppress": lambda: self.user.suppress(self.order.choice(paths), False),
            "configure": lambda: self.user.configure(*self.order.sample(paths, len(paths) // 3)),
            "switch": lambda: self._switch(path),
            "move": lambda: self._move(path, visible),
            "turn": lambda: self.user.turn(path, T),
            "lose": lambda: self.user.resolve(path, False) if component.referenced else None,
            "find": lambda: self.user.resolve(path),
            "undo": self._undo_last,
            "ok": self._press_ok,
        }
        name = self.order.choice(list(actions))
        self.log.append(f"{name} {path}")
        before = len(self.fusion.world.undo_steps)
        actions[name]()
        if name != "undo" and len(self.fusion.world.undo_steps) > before:
            self._undo.append(len(self.fusion.world.undo_steps) - before)

    def _undo_last(self) -> None:
        for _ in range(self._undo.pop() if self._undo else 0):
            self.fusion.undo()

    def _move(self, path: str, visible: list[str]) -> None:
        held = self.user.paths()[path][-1]
        goals = [g for g in visible if "+" not in g and not g.startswith(path)]
        goals = [g for g in goals if self.user.paths()[g][-1].component is not held.component]
        goals = [g for g in goals if not self.user.paths()[g][-1].component.referenced]
        same = [o for o in self.user.paths().values() if o[-1].component is held.parent]
        if goals and "+" not in path and len(same) <= 1 and not held.unresolved:
            goal = self.order.choice(goals)
            instances = [
                p
                for p in self.user.all_paths().values()
                if p[-1].component is self.user.paths()[goal][-1].component
            ]
            if len(instances) == 1:
                self.user.move(path, goal)

    def _switch(self, path: str) -> None:
        held = self.user.paths()[path][-1]
        if held.component.referenced and not held.unresolved:
            self.user.switch_configuration(path, self.order.choice(("short", "long")))

    def _press_ok(self) -> None:
        command = self.fusion.run_command(DEFINE)
        if command.is_valid():
            command.ok()
            self.truth |= self.warned  # the user has confirmed the warnings
        else:
            command.cancel()

    def check(self) -> None:
        """Every point is on its occurrence, or a row explains why it is not found."""
        snapshot = read_design(self.fusion.design, meshes=False, masses=None)
        table, findings = read_table(snapshot, link_of(snapshot))
        rows = {row.number: row for row in table.points}
        problem = "\n".join([*self.log, *(f.message for f in findings)])
        assert len(rows) == len(table.points) == len(self.truth), problem
        errors = {f.subject.name for f in findings if f.is_error}
        warned = [f.subject.name for f in snapshot.findings if f.code == "moved-point"]
        self.warned.clear()
        for number, (occurrence, place) in self.truth.items():
            row = rows[number]
            if row.lost:
                assert errors, problem
                continue
            path = self.user.paths()[row.occurrence]
            if any(name.endswith((f"_{number}", f" {number}")) for name in warned):
                self.warned[number] = occurrence, place = path[-1], place
            assert path[-1] is occurrence, f"{row.occurrence}\n{problem}"
            expected = 0.01 * apply(transform(path), place)
            assert np.linalg.norm(expected - row.position) < 1e-6, problem


def _with_bodies(root: Any) -> list[Any]:
    found = []
    waiting = list(root.occurrences)
    while waiting:
        occurrence = waiting.pop(0)
        if occurrence.bRepBodies.count:
            found.append(occurrence)
        waiting += list(occurrence.childOccurrences)
    return found


def test_random_actions_never_lose_or_move_a_point() -> None:
    """Some designs; CARDSFLOW_DESIGNER_SEQUENCES=500 runs 50 sequences in each design."""
    for seed in range(SEQUENCES):
        order = random.Random(seed)
        name = list(DESIGNS)[7 * seed % len(DESIGNS)]
        with fake_fusion.install() as fusion, running():
            fusion.options.tokens_survive = bool(seed // len(DESIGNS) % 2)
            fusion.options.recomputed = order.choice(("invalid", "valid"))
            fusion.options.change_events = order.choice(("never", "nested", "queued"))
            DESIGNS[name]()
            designer = Designer(fusion, order)
            designer.define()
            designer.check()
            for _ in range(ACTIONS):
                designer.act()
                designer.check()
