"""Tests that the fake rejects the same calls in commands as Fusion."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import pytest
from fake_fusion import Fake, designs
from fake_fusion.driver import Driver, Rejected
from fake_fusion.maths import point

ID = "makePoints"


@dataclass
class Commands:
    """A command that creates construction points on picked entities and records its events.

    Attributes:
        fake: The Fusion that runs.
        events: Names of the events, in order.
        on: What handlers do, by event.
        kept: The handlers.
    """

    fake: Fake
    events: list[str] = field(default_factory=list)
    on: dict[str, Callable[[Any], None]] = field(default_factory=dict)
    kept: list[Any] = field(default_factory=list)

    def add(self) -> Any:
        ui = self.fake.app.userInterface
        definition = ui.commandDefinitions.addButtonDefinition(ID, "Points", "Puts points.")
        panel = ui.allToolbarPanels.itemById("SolidScriptsAddinsPanel")
        panel.controls.addCommand(definition)
        self.listen(definition.commandCreated, "CommandCreatedEventHandler", self._created)
        return definition

    def listen(self, event: Any, base: str, work: Callable[[Any], None]) -> None:
        import adsk.core

        def notify(_: Any, args: Any) -> None:
            self.events.append(event.name)
            work(args)

        handler = type("Handler", (getattr(adsk.core, base),), {"notify": notify})()
        self.kept.append(handler)
        event.add(handler)

    def _created(self, args: Any) -> None:
        command = args.command
        inputs = command.commandInputs
        picks = inputs.addSelectionInput("picks", "Picks", "Pick a point")
        for name in ("Vertices", "CircularEdges", "SketchPoints", "SphericalFaces"):
            picks.addSelectionFilter(name)
        picks.setSelectionLimits(0, 0)
        inputs.addStringValueInput("name", "Name", "VP")
        for name, base in (
            ("execute", "CommandEventHandler"),
            ("executePreview", "CommandEventHandler"),
            ("destroy", "CommandEventHandler"),
            ("inputChanged", "InputChangedEventHandler"),
            ("validateInputs", "ValidateInputsEventHandler"),
        ):
            self.listen(getattr(command, name), base, self.on.get(name, lambda _: None))

    def run(self) -> Driver:
        return self.fake.run_command(ID)


def add_point(component: Any, at: Any, context: Any = None) -> Any:
    request = component.constructionPoints.createInput(context)
    request.setByPoint(at)
    return component.constructionPoints.add(request)


def part(design: Any, name: str) -> Any:
    return occurrence(design, name).component


def vertex(design: Any, name: str) -> Any:
    return occurrence(design, name).bRepBodies[0].vertices[0]


def dialog(fusion: Fake, created: Callable[[Any], None]) -> Commands:
    """Return a command with a custom dialog, on a design with one cube."""
    designs.single_cube()
    made = Commands(fusion)
    definition = made.add()
    made.kept.clear()
    made.listen(definition.commandCreated, "CommandCreatedEventHandler", created)
    return made


@pytest.fixture
def commands(fusion: Fake) -> Commands:
    made = Commands(fusion)
    made.add()
    return made


def occurrence(design: Any, name: str) -> Any:
    return next(o for o in design.rootComponent.allOccurrences if o.component.name == name)


# Transactions ------------------------------------------------------------------------------------


EDITS: dict[str, Callable[[Any], Any]] = {
    "a point": lambda d: add_point(part(d, "base"), vertex(d, "base"), occurrence(d, "base")),
    "an attribute": lambda d: d.attributes.add("CARDSFlow", "muscles", "[]"),
    "graphics": lambda d: d.rootComponent.customGraphicsGroups.add(),
    "a name": lambda d: setattr(part(d, "upper"), "name", "x"),
    "a sketch": lambda d: d.rootComponent.sketches[0].deleteMe(),
    "a user's point": lambda d: part(d, "lower").constructionPoints[0].deleteMe(),
    "a joint": lambda d: setattr(d.rootComponent.joints[0], "isSuppressed", True),
}


@pytest.mark.parametrize("what", EDITS)
def test_edits_need_a_transaction(fusion: Fake, what: str) -> None:
    design = designs.things_to_pick()
    before = fusion.full_fingerprint()
    edit = EDITS[what]
    with pytest.raises(RuntimeError, match="outside of execute"):
        edit(design)
    assert fusion.full_fingerprint() == before
    with fusion.transaction():
        edit(design)
    assert fusion.full_fingerprint() != before
    fusion.undo()
    assert fusion.full_fingerprint() == before


@pytest.mark.parametrize("event", ["inputChanged", "validateInputs", "destroy"])
def test_other_events_may_not_edit(commands: Commands, event: str) -> None:
    design = designs.things_to_pick()
    before = commands.fake.full_fingerprint()
    commands.on[event] = lambda _: design.rootComponent.customGraphicsGroups.add()

    def play() -> None:
        command = commands.run()
        command.set("name", "x")
        command.ok()

    with pytest.raises(RuntimeError, match=f"now in {event}"):
        play()
    assert commands.fake.full_fingerprint() == before


def test_exception_reaches_the_test_and_changes_nothing(commands: Commands) -> None:
    design = designs.things_to_pick()
    before = commands.fake.full_fingerprint()

    def execute(_: Any) -> None:
        design.rootComponent.customGraphicsGroups.add()
        raise ValueError("mine")

    commands.on["execute"] = execute
    with pytest.raises(ValueError, match="mine"):
        commands.run().ok()
    assert commands.fake.full_fingerprint() == before


def test_events_have_the_order_of_fusion(commands: Commands) -> None:
    design = designs.things_to_pick()
    command = commands.run()
    command.pick("picks", vertex(design, "base"))
    command.ok()
    assert commands.events == [
        *("commandCreated", "validateInputs", "executePreview"),
        *("inputChanged", "validateInputs", "executePreview"),
        *("validateInputs", "execute", "destroy"),
    ]


def test_handlers_without_reference_are_not_called(commands: Commands) -> None:
    designs.things_to_pick()
    commands.kept.clear()
    commands.run()
    assert commands.events == []


# Selections and inputs ---------------------------------------------------------------------------


def test_filters_reject_entities_of_other_kinds(commands: Commands) -> None:
    design = designs.things_to_pick()
    command = commands.run()
    base, upper = occurrence(design, "base"), occurrence(design, "upper")
    with pytest.raises(Rejected, match="not one of"):
        command.pick("picks", base.bRepBodies[0].faces[0])
    with pytest.raises(Rejected, match="not one of"):
        command.pick("picks", base)
    with pytest.raises(Rejected, match="not one of"):
        command.pick("picks", base.bRepBodies[0].edges[0])
    command.pick("picks", upper.bRepBodies[0].edges[0])
    command.pick("picks", upper.bRepBodies[1].faces[0])
    with pytest.raises(Rejected, match="already"):
        command.pick("picks", upper.bRepBodies[1].faces[0])
    assert command["picks"].selectionCount == 2


def test_ids_are_unique_and_filters_known(fusion: Fake) -> None:
    caught: list[str] = []

    def created(args: Any) -> None:
        inputs = args.command.commandInputs
        inputs.addStringValueInput("a", "A", "")
        group = inputs.addGroupCommandInput("g", "G")
        for wrong in (
            lambda: group.children.addStringValueInput("a", "A", ""),
            lambda: inputs.addSelectionInput("s", "S", "").addSelectionFilter("Vertexes"),
            lambda: inputs.addTableCommandInput("t", "T", 2, "1,2"),
            lambda: inputs.itemById("s").addSelection(fusion.design.rootComponent),
            lambda: inputs.addTableCommandInput("u", "U", 2, "1:2").addCommandInput(
                inputs.itemById("s"), 0, 0
            ),
        ):
            with pytest.raises(RuntimeError) as error:
                wrong()
            caught.append(str(error.value))

    dialog(fusion, created).run()
    assert [text.split()[4] for text in caught[:3]] == ["id", "filter", "columnRatio"]
    assert "commandCreated" in caught[3]
    assert "cannot be used within a table" in caught[4]


# Construction points -----------------------------------------------------------------------------


def point_input(design: Any) -> Any:
    return design.rootComponent.constructionPoints.createInput()


def edge(design: Any) -> Any:
    return occurrence(design, "base").bRepBodies[0].edges[0]


REFUSED: list[tuple[str, Callable[[], Any], Callable[[Any], Any], str]] = [
    (
        "a mixed context",
        designs.things_to_pick,
        lambda d: add_point(part(d, "upper"), vertex(d, "base")),
        "paths are not valid",
    ),
    (
        "coordinates",
        designs.no_groups,
        lambda d: point_input(d).setByPoint(point((1.0, 2.0, 3.0))),
        "parametric",
    ),
    (
        "no centre",
        designs.things_to_pick,
        lambda d: point_input(d).setByCenter(edge(d)),
        "no centre",
    ),
    ("an edge", designs.things_to_pick, lambda d: point_input(d).setByPoint(edge(d)), "vertex"),
    (
        "another point",
        designs.things_to_pick,
        lambda d: point_input(d).setByPoint(part(d, "lower").constructionPoints[0]),
        "vertex",
    ),
    (
        "a referenced component",
        designs.referenced_components,
        lambda d: add_point(part(d, "lower"), vertex(d, "lower"), occurrence(d, "lower")),
        "external reference",
    ),
    (
        "an attribute in one",
        designs.referenced_components,
        lambda d: part(d, "lower").constructionPoints[0].attributes.add("CARDSFlow", "p", "{}"),
        "external reference",
    ),
    (
        "an assembly design",
        designs.assembly_intent,
        lambda d: add_point(d.rootComponent, vertex(d, "base")),
        "assembly",
    ),
]


@pytest.mark.parametrize(
    ("make", "edit", "message"), [row[1:] for row in REFUSED], ids=[row[0] for row in REFUSED]
)
def test_entities_without_a_point_are_rejected(
    fusion: Fake, make: Callable[[], Any], edit: Callable[[Any], Any], message: str
) -> None:
    design = make()
    with fusion.transaction(), pytest.raises(RuntimeError, match=message):
        edit(design)


# Dialogs -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(("low", "high"), [(0, 0), (1, 0), (5, 5)])
def test_progress_needs_a_range(fusion: Fake, low: int, high: int) -> None:
    dialog = fusion.app.userInterface.createProgressDialog()
    with pytest.raises(RuntimeError, match="3 : invalid argument minimumValue or maximumValue"):
        dialog.show("Export", "%p", low, high, 1)
