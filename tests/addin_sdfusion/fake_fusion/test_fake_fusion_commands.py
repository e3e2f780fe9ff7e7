"""The fake's transactions and user interface behave as the user manual has it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import pytest
from fake_fusion import Fake, designs
from fake_fusion.driver import Driver, Refused
from fake_fusion.maths import point, xyz

ID = "makePoints"


@dataclass
class Commands:
    """A command that puts construction points on what is picked, and what happened to it.

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
    reasons: list[int] = field(default_factory=list)

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
        import adsk.core

        command = args.command
        inputs = command.commandInputs
        tab = inputs.addTabCommandInput("tab", "Points")
        picks = tab.children.addSelectionInput("picks", "Picks", "Pick a point")
        for name in ("Vertices", "CircularEdges", "SketchPoints", "SphericalFaces"):
            picks.addSelectionFilter(name)
        picks.setSelectionLimits(0, 0)
        tab.children.addStringValueInput("name", "Name", "VP")
        style = adsk.core.DropDownStyles.TextListDropDownStyle
        choice = tab.children.addDropDownCommandInput("link", "Link", style)
        choice.listItems.add("base", True)
        choice.listItems.add("upper", False)
        tab.children.addIntegerSpinnerCommandInput("number", "Number", 0, 10, 1, 0)
        tab.children.addBoolValueInput("clear", "Clear", False)
        for name, base in (
            ("activate", "CommandEventHandler"),
            ("execute", "CommandEventHandler"),
            ("executePreview", "CommandEventHandler"),
            ("destroy", "CommandEventHandler"),
            ("inputChanged", "InputChangedEventHandler"),
            ("validateInputs", "ValidateInputsEventHandler"),
            ("preSelect", "SelectionEventHandler"),
        ):
            self.listen(getattr(command, name), base, self._handler(name))

    def _handler(self, name: str) -> Callable[[Any], None]:
        def handle(args: Any) -> None:
            if name == "destroy":
                self.reasons.append(args.terminationReason)
            self.on.get(name, lambda _: None)(args)

        return handle

    def run(self) -> Driver:
        return self.fake.run_command(ID)

    def make_points(self, args: Any) -> None:
        inputs = args.command.commandInputs
        picks = inputs.itemById("picks")
        for k in range(picks.selectionCount):
            add_point(picks.selection(k).entity, inputs.itemById("name").value)


def add_point(entity: Any, name: str) -> Any:
    import adsk.fusion

    body = getattr(entity, "body", None)
    component = body.parentComponent if body else entity.parentSketch.parentComponent
    points = component.constructionPoints
    request = points.createInput(entity.assemblyContext)
    if isinstance(entity, (adsk.fusion.BRepVertex, adsk.fusion.SketchPoint)):
        request.setByPoint(entity)
    else:
        request.setByCenter(entity)
    made = points.add(request)
    made.name = name
    made.attributes.add("CARDSFlow", "point", "{}")
    return made


def dialog(fusion: Fake, created: Callable[[Any], None]) -> Commands:
    """A command with a dialog of its own, on a design of one cube."""
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
    "a point": lambda d: add_point(occurrence(d, "base").bRepBodies[0].vertices[0], "VP"),
    "an attribute": lambda d: d.attributes.add("CARDSFlow", "muscles", "[]"),
    "graphics": lambda d: d.rootComponent.customGraphicsGroups.add(),
    "a light bulb": lambda d: setattr(occurrence(d, "upper"), "isLightBulbOn", False),
    "a name": lambda d: setattr(occurrence(d, "upper").component, "name", "x"),
    "a sketch": lambda d: d.rootComponent.sketches[0].deleteMe(),
    "a user's point": lambda d: occurrence(d, "lower").component.constructionPoints[0].deleteMe(),
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


@pytest.mark.parametrize("event", ["activate", "inputChanged", "validateInputs", "destroy"])
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


def test_execute_is_one_undo_step(commands: Commands) -> None:
    design = designs.things_to_pick()
    fake = commands.fake
    user, everything = fake.fingerprint(), fake.full_fingerprint()
    commands.on["execute"] = commands.make_points
    command = commands.run()
    vertices = occurrence(design, "base").bRepBodies[0].vertices
    command.pick("picks", vertices[0])
    command.pick("picks", vertices[1])
    assert fake.full_fingerprint() == everything
    command.ok()
    assert len(fake.world.undo_steps) == 1
    assert fake.fingerprint() == user
    made = occurrence(design, "base").component.constructionPoints
    assert [p.name for p in made] == ["VP", "VP (1)"]
    fake.undo()
    assert fake.full_fingerprint() == everything
    assert commands.reasons == [1]


def test_preview_is_rolled_back(commands: Commands) -> None:
    design = designs.things_to_pick()
    before = commands.fake.full_fingerprint()
    commands.on["executePreview"] = lambda _: design.rootComponent.customGraphicsGroups.add()
    command = commands.run()
    groups = design.rootComponent.customGraphicsGroups
    for _ in range(3):
        command.set("name", "x")
        assert groups.count == 1
    (shown,) = groups
    command.cancel()
    assert groups.count == 0
    assert not shown.isValid or groups.count == 0
    assert commands.fake.full_fingerprint() == before
    assert commands.fake.world.undo_steps == []
    assert commands.reasons == [2]


def test_preview_may_be_the_result(commands: Commands) -> None:
    design = designs.things_to_pick()

    def preview(args: Any) -> None:
        commands.make_points(args)
        args.isValidResult = True

    commands.on["executePreview"] = preview
    command = commands.run()
    command.pick("picks", occurrence(design, "base").bRepBodies[0].vertices[0])
    command.ok()
    assert "execute" not in commands.events
    assert occurrence(design, "base").component.constructionPoints.count == 1
    assert len(commands.fake.world.undo_steps) == 1


def test_failed_execute_changes_nothing(commands: Commands) -> None:
    design = designs.things_to_pick()
    before = commands.fake.full_fingerprint()

    def execute(args: Any) -> None:
        design.rootComponent.customGraphicsGroups.add()
        args.executeFailed = True
        args.executeFailedMessage = "no"

    commands.on["execute"] = execute
    command = commands.run()
    command.ok()
    assert command.failed == "no"
    assert commands.fake.messages == ["no"]
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


def test_events_come_in_fusions_order(commands: Commands) -> None:
    design = designs.things_to_pick()
    command = commands.run()
    command.pick("picks", occurrence(design, "base").bRepBodies[0].vertices[0])
    command.ok()
    assert commands.events == [
        *("commandCreated", "activate", "validateInputs", "executePreview"),
        *("preSelect", "inputChanged", "validateInputs", "executePreview"),
        *("validateInputs", "execute", "destroy"),
    ]


def test_invalid_inputs_grey_ok_out(commands: Commands) -> None:
    designs.things_to_pick()

    def validate(args: Any) -> None:
        args.areInputsValid = args.inputs.itemById("name").value != ""

    commands.on["validateInputs"] = validate
    command = commands.run()
    command.set("name", "")
    with pytest.raises(Refused, match="disabled"):
        command.ok()
    command.set("name", "x")
    command.ok()
    with pytest.raises(Refused, match="closed"):
        command.cancel()


def test_handlers_that_nobody_keeps_are_silent(commands: Commands) -> None:
    designs.things_to_pick()
    commands.kept.clear()
    commands.run()
    assert commands.events == []


def test_command_is_gone_afterwards(commands: Commands) -> None:
    designs.things_to_pick()
    command = commands.run()
    name = command["name"]
    command.cancel()
    with pytest.raises(RuntimeError, match="deleted"):
        _ = name.value


def test_another_command_ends_the_first(commands: Commands) -> None:
    designs.things_to_pick()
    first = commands.run()
    commands.run()
    assert not first.is_open
    assert commands.reasons == [4]
    assert "execute" in commands.events  # isExecutedWhenPreEmpted


# Selections and inputs ---------------------------------------------------------------------------


def test_filters_refuse_entities_of_other_kinds(commands: Commands) -> None:
    design = designs.things_to_pick()
    command = commands.run()
    base, upper = occurrence(design, "base"), occurrence(design, "upper")
    with pytest.raises(Refused, match="none of"):
        command.pick("picks", base.bRepBodies[0].faces[0])
    with pytest.raises(Refused, match="none of"):
        command.pick("picks", base)
    with pytest.raises(Refused, match="none of"):
        command.pick("picks", base.bRepBodies[0].edges[0])
    command.pick("picks", upper.bRepBodies[0].edges[0])
    command.pick("picks", upper.bRepBodies[1].faces[0])
    with pytest.raises(Refused, match="already"):
        command.pick("picks", upper.bRepBodies[1].faces[0])
    assert command["picks"].selectionCount == 2


def test_preselect_may_refuse(commands: Commands) -> None:
    design = designs.things_to_pick()
    commands.on["preSelect"] = lambda args: setattr(args, "isSelectable", False)
    command = commands.run()
    with pytest.raises(Refused, match="does not let"):
        command.pick("picks", occurrence(design, "base").bRepBodies[0].vertices[0])


def test_inputs_of_the_event_are_those_beside_the_changed_one(commands: Commands) -> None:
    designs.things_to_pick()
    seen = []
    commands.on["inputChanged"] = lambda args: seen.append(
        (args.input.id, args.inputs.count, args.inputs.itemById("tab"))
    )
    commands.run().set("link", "upper")
    assert seen == [("link", 5, None)]


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


def test_mixed_contexts_are_refused(fusion: Fake) -> None:
    design = designs.things_to_pick()
    vertex = occurrence(design, "base").bRepBodies[0].vertices[0]
    points = occurrence(design, "upper").component.constructionPoints
    request = points.createInput()
    request.setByPoint(vertex)
    with fusion.transaction(), pytest.raises(RuntimeError, match="paths are not valid"):
        points.add(request)
    with fusion.transaction():
        request = points.createInput(occurrence(design, "upper"))
        request.setByPoint(vertex)
        made = points.add(request).createForAssemblyContext(occurrence(design, "upper"))
        assert xyz(made.geometry) == pytest.approx(xyz(vertex.geometry))
        in_root = design.rootComponent.constructionPoints.createInput()
        in_root.setByPoint(vertex)
        made = design.rootComponent.constructionPoints.add(in_root)
        assert xyz(made.geometry) == pytest.approx(xyz(vertex.geometry))


def test_free_points_need_direct_modelling(fusion: Fake) -> None:
    for design, works in ((designs.no_groups(), False), (designs.direct_modelling(), True)):
        points = design.rootComponent.constructionPoints
        request = points.createInput()
        if not works:
            with pytest.raises(RuntimeError, match="parametric"):
                request.setByPoint(point((1.0, 2.0, 3.0)))
            continue
        request.setByPoint(point((1.0, 2.0, 3.0)))
        with fusion.transaction():
            assert xyz(points.add(request).geometry) == pytest.approx([1.0, 2.0, 3.0])


def test_wrong_entities_are_refused(fusion: Fake) -> None:
    design = designs.things_to_pick()
    base = occurrence(design, "base")
    request = design.rootComponent.constructionPoints.createInput()
    with pytest.raises(RuntimeError, match="no centre"):
        request.setByCenter(base.bRepBodies[0].edges[0])
    with pytest.raises(RuntimeError, match="vertex"):
        request.setByPoint(base.bRepBodies[0].edges[0])
    native = occurrence(design, "lower").component.constructionPoints[0]
    with pytest.raises(RuntimeError, match="vertex"):
        request.setByPoint(native)


def test_referenced_components_are_read_only(fusion: Fake) -> None:
    design = designs.referenced_components()
    lower = occurrence(design, "lower")
    assert lower.isReferencedComponent
    with fusion.transaction():
        with pytest.raises(RuntimeError, match="external reference"):
            add_point(lower.bRepBodies[0].vertices[0], "VP")
        with pytest.raises(RuntimeError, match="external reference"):
            lower.component.constructionPoints[0].attributes.add("CARDSFlow", "point", "{}")


def test_assembly_designs_take_no_points(fusion: Fake) -> None:
    design = designs.assembly_intent()
    points = design.rootComponent.constructionPoints
    request = points.createInput()
    request.setByPoint(occurrence(design, "base").bRepBodies[0].vertices[0])
    with fusion.transaction(), pytest.raises(RuntimeError, match="assembly"):
        points.add(request)


# Graphics ----------------------------------------------------------------------------------------


# Dialogs -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(("low", "high"), [(0, 0), (1, 0), (5, 5)])
def test_progress_needs_a_range(fusion: Fake, low: int, high: int) -> None:
    dialog = fusion.app.userInterface.createProgressDialog()
    with pytest.raises(RuntimeError, match="3 : invalid argument minimumValue or maximumValue"):
        dialog.show("Export", "%p", low, high, 1)


def test_wrong_handlers_are_refused(fusion: Fake) -> None:
    import adsk.core

    definition = fusion.app.userInterface.commandDefinitions.addButtonDefinition(ID, "P", "t")
    with pytest.raises(TypeError, match="is no CommandCreatedEventHandler"):
        definition.commandCreated.add(adsk.core.CommandEventHandler())
    with pytest.raises(TypeError):
        definition.commandCreated.add(print)


def test_command_without_inputs_is_executed_at_once(fusion: Fake) -> None:

    def created(args: Any) -> None:
        made.listen(args.command.execute, "CommandEventHandler", lambda _: None)
        made.listen(args.command.destroy, "CommandEventHandler", lambda _: None)

    made = dialog(fusion, created)
    command = made.run()
    assert made.events == ["commandCreated", "execute", "destroy"]
    assert not command.is_open
