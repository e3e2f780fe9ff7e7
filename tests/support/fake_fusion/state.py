"""State of the fake: transactions, options, and messages shown to the user."""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any, Literal

ProductSign = Literal["tensor", "integral"]


@dataclass
class Options:
    """Properties of Fusion that are unknown or differ between versions and designs.

    Attributes:
        product_sign: `tensor`: xy of getXYZMomentsOfInertia is -∫xy dm; `integral`: +∫xy dm.
        nested_native_geometry: Value of geometryOrOriginOne of a native joint in a sub-component:
            `null`, or `local` to that component.
        joint_transforms: Frame of Joint.geometryOneTransform, geometryTwoTransform and
            JointOrigin.transform of a proxy: `component`, the frame of its component, like
            AsBuiltJoint.transform; or `context`.
        ball_vectors: Directions of a ball joint: `fixed` to occurrenceTwo at the zero pose, or
            `carried` by the preceding rotations.
        mesh_frame: Frame of the mesh of a body's proxy: `context` or `component`.
        tokens_survive: findEntityByToken finds an occurrence that was moved to another component.
        all_joints_fail: allJoints and allAsBuiltJoints of a design with assembly constraints raise
            InternalValidationError.
        recomputed: API objects of vertices, edges and faces after the model was recomputed, and of
            points after an edit of their base feature: `invalid`, or still `valid`.
        change_events: inputChanged events of changes by the add-in: `never`, `nested` in the
            change, or `queued` until the handler returns.
    """

    product_sign: ProductSign = "tensor"
    nested_native_geometry: Literal["null", "local"] = "null"
    joint_transforms: Literal["context", "component"] = "component"
    ball_vectors: Literal["fixed", "carried"] = "fixed"
    mesh_frame: Literal["context", "component"] = "context"
    tokens_survive: bool = True
    all_joints_fail: bool = False
    recomputed: Literal["invalid", "valid"] = "invalid"
    change_events: Literal["never", "nested", "queued"] = "never"


@dataclass
class ProgressRecord:
    """A progress dialog that was shown."""

    title: str
    message: str
    minimum: int
    maximum: int
    values: list[int] = field(default_factory=list)
    messages: list[str] = field(default_factory=list)
    hidden: bool = False


class World:
    """State of a running Fusion.

    Attributes:
        options: See Options.
        missing: Members that this version does not have, such as `Design.designIntent`.
        documents: Open documents (private data).
        active: The active document, or None.
        messages: Texts of message boxes, in order.
        message_boxes: Texts of message boxes with title, buttons and icon.
        log: Texts of app.log, with level and type.
        message_answers: DialogResults of message boxes; OK (or Yes) if empty.
        folder_answers: Folders chosen in folder dialogs; None or an empty queue cancels.
        file_answers: Files chosen in file dialogs; None or an empty queue cancels.
        folder_dialogs: Title and initial folder of every folder dialog shown.
        file_dialogs: Title and filter of every file dialog shown.
        progress: Progress dialogs that were shown.
        in_design: Whether the Design workspace is active; otherwise the product is not a design.
        modeling_orientation: Preference of the up axis: 0 for y, 1 for z.
        cancel_progress_after: Number of updates after which a progress dialog is cancelled.
        do_events: Number of calls of adsk.doEvents.
        waiting: Actions of the user or of Fusion; each call of adsk.doEvents processes one.
        recomputes: Number of times that the model was recomputed.
        nested: Depth of nested events of inputs; see Options.change_events.
        calls: Number of calls of each member, such as `Component.getPhysicalProperties`.
        edit_scopes: Number of edits of base features.
        changing: Input whose inputChanged event is handled.
    """

    def __init__(self) -> None:
        self.options = Options()
        self.missing: set[str] = set()
        self.documents: list[Any] = []
        self.active: Any = None
        self.messages: list[str] = []
        self.message_boxes: list[tuple[str, str, int, int]] = []
        self.log: list[tuple[str, int, int]] = []
        self.message_answers: deque[int] = deque()
        self.folder_answers: deque[str | None] = deque()
        self.file_answers: deque[str | None] = deque()
        self.folder_dialogs: list[tuple[str, str]] = []
        self.file_dialogs: list[tuple[str, str]] = []
        self.progress: list[ProgressRecord] = []
        self.cancel_progress_after: int | None = None
        self.do_events = 0
        self.waiting: deque[Callable[[], Any]] = deque()
        self.recomputes = 0
        self.nested = 0
        self.undo_steps: list[list[Callable[[], None]]] = []
        self.journal: list[Callable[[], None]] | None = None
        self.why: str = ""
        self.ui: Any = None
        self.running: Any = None
        self.changing: Any = None
        self.calls: Counter[str] = Counter()
        self.edit_scopes = 0
        self.in_design = True
        self.modeling_orientation = 1
        self.text_commands: list[str] = []
        self.camera: dict[str, Any] = {
            "target": (0.0, 0.0, 0.0),
            "eye": (0.0, -100.0, 0.0),
            "fit": False,
            "smooth": True,
        }

    def show_message(self, text: str, title: str = "", buttons: int = 0, icon: int = 0) -> int:
        """Show a message box and return the next item of `message_answers`, else OK or Yes."""
        self.messages.append(text)
        self.message_boxes.append((text, title, buttons, icon))
        if self.message_answers:
            return self.message_answers.popleft()
        return 2 if buttons in (3, 4) else 0

    # Edits of the model ----------------------------------------------------------------------

    def require_edit(self, what: str) -> None:
        """Reject an edit without an open transaction.

        Raises:
            RuntimeError: The edit is not in execute or executePreview of a command.
        """
        if self.journal is None:
            where = f" (now in {self.why})" if self.why else ""
            raise RuntimeError(
                f"3 : {what}: the model is edited outside of execute and executePreview{where}"
            )

    def set(self, owner: Any, name: str, value: Any, what: str = "") -> None:
        """Set a field of the model and record it for undo."""
        self.require_edit(what or name)
        old = getattr(owner, name)
        self.journal.append(lambda: setattr(owner, name, old))  # type: ignore[union-attr]
        setattr(owner, name, value)

    def append(self, items: list, item: Any, what: str = "") -> None:
        """Append to a list of the model and record it for undo."""
        self.require_edit(what)
        self.journal.append(lambda: _take_back(items, item))  # type: ignore[union-attr]
        items.append(item)

    def remove(self, items: list, item: Any, what: str = "") -> None:
        """Remove from a list of the model and record it for undo."""
        self.require_edit(what)
        i = next(k for k, other in enumerate(items) if other is item)
        self.journal.append(lambda: _put_back(items, i, item))  # type: ignore[union-attr]
        del items[i]

    def put(self, mapping: dict, key: Any, value: Any, what: str = "") -> None:
        """Set an entry of the model, or remove it if None, and record it for undo."""
        self.require_edit(what)
        old = dict(mapping)

        def undo() -> None:
            mapping.clear()
            mapping.update(old)

        self.journal.append(undo)  # type: ignore[union-attr]
        if value is None:
            mapping.pop(key, None)
        else:
            mapping[key] = value

    @contextmanager
    def transaction(self, *, keep: Callable[[], bool] = lambda: True) -> Iterator[None]:
        """Allow edits as one undo step; they are undone at the end if `keep()` is False."""
        outer, self.journal = self.journal, []
        done = False
        try:
            yield
            done = keep()
        finally:
            steps, self.journal = self.journal, outer
            if not done:
                roll_back(steps)
            elif steps and outer is not None:
                outer.extend(steps)
            elif steps:
                self.undo_steps.append(steps)

    @contextmanager
    def building(self) -> Iterator[None]:
        """Allow edits of the user before the test, without an undo step."""
        outer, self.journal = self.journal, []
        try:
            yield
        finally:
            self.journal = outer


def roll_back(steps: list[Callable[[], None]]) -> None:
    """Undo edits in reverse order, and recompute the model."""
    for undo in reversed(steps):
        undo()
    world().recomputes += bool(steps)


def _take_back(items: list, item: Any) -> None:
    """Undo the creation of an item, whose API objects become invalid."""
    del items[next(k for k, other in enumerate(items) if other is item)]
    item.gone = True


def _put_back(items: list, index: int, item: Any) -> None:
    items.insert(index, item)
    item.gone = False


_current = World()


def world() -> World:
    """Return the running Fusion."""
    return _current


def replace_world(other: World | None = None) -> World:
    """Replace the running Fusion (default: by a new one) and return the old one."""
    global _current
    old, _current = _current, other or World()
    return old
