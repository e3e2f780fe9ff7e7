// Starts the edit page and draws it.

async function startEdit() {
  const text = id => document.getElementById(id).textContent;
  const scene = element("div", document.body, { className: "scene" }), canvas = element("canvas", scene), drawing = new Drawing(canvas);
  const motion = await unpack(text("motion")), editor = new Editor(motion, JSON.parse(text("edit")), drawing, canvas);
  let stale = true;
  editor.redraw = () => { stale = true; };
  const box = addPanel("Edit");
  box.classList.add("wide", "play", "edit");
  const show = element("details", box);
  element("summary", show, { textContent: "Show" });
  const groups = ["muscles", "via points", "wrap surfaces"].map(name => ({ group: motion.groups.indexOf(name) }));
  editor.shown = addSwitches({ ...motion, acts: [{ ...editor.act, shapes: [...editor.still, ...groups], arrows: [] }] }, show, editor.redraw);
  const { clientWidth, clientHeight } = editor.played.box;
  const camera = editor.camera = new Camera(editor.played.world, clientWidth / clientHeight || 1), showTip = addTooltip();
  addViews(camera, box, editor.redraw);
  editor.saving = new Saving(editor);
  const [muscles, arms, wraps, law, rest] = Array.from({ length: 5 }, () => element("div", box));
  const sections = [new MuscleSection(editor, muscles, law), new WrapSection(editor, wraps), new EditAnalysis(editor, arms, rest)];
  const showBar = addEditBar(editor), pointer = trackPointer(canvas, editor.redraw);
  new EditPointer(editor);
  camera.handleInput(canvas, editor.redraw);
  addEventListener("resize", editor.redraw);
  box.addEventListener("toggle", editor.redraw);
  drawing.dark.addEventListener("change", editor.redraw);
  addEventListener("beforeunload", event => { if (editor.document.isChanged) event.preventDefault(); });
  const draw = () => {
    if (stale) {
      stale = false;
      editor.act.shapes = [...editor.still, ...editor.shapesOf.compose()];
      showBar();
      if (box.open) for (const section of sections) section.show();
      drawing.begin();
      drawAct(editor.played, 0, 1, drawing, camera, editor.shown, 0, [NaN, NaN]); // the panel shows joint values
      showTip(editor.hint ? editor.hint.text : tipOf(editor, pointer), pointer);
      document.body.dataset.drawn = editor.document.past.length;
    }
    requestAnimationFrame(draw);
  };
  editor.evaluate();
  requestAnimationFrame(draw);
  window.edit = editor;
}

// Returns the name of the thing under the pointer; a muscle with its length.
function tipOf(editor, pointer) {
  const muscles = editor.document.data.muscles.map(({ name }) => ({ name, length: name }));
  const played = { act: { ...editor.act, muscles, joints: [] }, box: editor.played.box };
  return textAt(pointer, [played], editor.camera, editor.shown, (_, name) => editor.result.lengths.get(name));
}

startEdit().catch(error => { element("div", document.body, { className: "message", textContent: `The editor cannot start: ${error.message}.` }); });
