// Bar and keys of the edit page.

const EDIT_KEYS = [
  ["n", "new muscle: click points on the links"], ["Enter or Esc", "end adding points"],
  ["click a wrap surface", "while adding points: route the muscle over it"],
  ["drag a handle", "move a point, or change a wrap surface"], ["Alt", "while clicking or dragging: do not snap"],
  ["Delete", "delete the selected point, surface or muscle"], ["m", "mirror the selected muscle"],
  ["Ctrl+Z, Ctrl+Y", "undo, redo"], ["Ctrl+S", "save: shows the difference first"],
  ["f, s, t, 0", "view from the front, the side, the top; fit"],
  ["drag elsewhere", "turn the view; with Shift: move it"], ["?", "this help"],
];
const SURFACES = [["", "Surface …"], ["sphere", "sphere"], ["cylinder", "cylinder"], ["ellipsoid", "ellipsoid"]];

// Adds the bar; returns a function that shows its state.
function addEditBar(editor) {
  const bar = element("div", document.body, { className: "bar playing editing" }), help = addHelp(EDIT_KEYS);
  const status = element("div", bar, { className: "status" });
  const button = (textContent, ariaLabel, act) => {
    const added = addButton(bar, textContent, act, ariaLabel);
    added.ariaLabel = ariaLabel;
    return added;
  };
  const drawing = button("New muscle", "new muscle", () => { if (editor.drawing) editor.endDrawing(); else editor.newMuscle(); });
  const showSurface = addChoice(bar, { title: "add a wrap surface", options: () => SURFACES, get: () => editor.placing ?? "", set: shape => editor.place(shape || null) });
  const undo = button("↶", "undo", () => editor.document.undo()), redo = button("↷", "redo", () => editor.document.redo());
  const output = element("output", bar), store = button(editor.server.exists ? "Save" : "Download", "save", () => editor.saving.open());
  const toggleHelp = () => { help.hidden = !help.hidden; };
  button("?", "help", toggleHelp);
  const keys = {
    n: () => editor.newMuscle(), m: () => editor.mirror(), Enter: () => editor.endDrawing(), Delete: () => editor.deleteSelected(),
    Backspace: () => editor.deleteSelected(), "?": toggleHelp,
    Escape: () => { if (help.hidden && !editor.saving.isOpen) editor.escape(); help.hidden = true; editor.saving.close(); },
  };
  const withControl = { z: () => editor.document.undo(), y: () => editor.document.redo(), Z: () => editor.document.redo(), s: () => editor.saving.open() };
  addEventListener("keydown", event => {
    const isControl = event.ctrlKey || event.metaKey, act = (isControl ? withControl : keys)[event.key];
    const isTyping = event.target.matches?.("input[type=text]") && !(isControl && event.key === "s");
    if (!act || isTyping || event.altKey) return;
    event.preventDefault();
    act();
  });
  return () => {
    const { message, isFailure } = editor;
    status.textContent = message || editor.instruction();
    status.classList.toggle("bad", Boolean(message) && isFailure);
    drawing.textContent = editor.drawing ? "Done" : "New muscle";
    drawing.classList.toggle("on", Boolean(editor.drawing));
    undo.disabled = !editor.document.past.length;
    redo.disabled = !editor.document.future.length;
    output.textContent = editor.document.isChanged ? "not saved" : "";
    store.classList.toggle("on", editor.document.isChanged);
    showSurface();
  };
}
