// Shows a run in progress: the server of the page sends the shapes of the current frame.

const oneRow = numbers => ({ rows: 1, columns: numbers.length, numbers: Float32Array.from(numbers) });

// Moves the shapes of an act to a frame; creates shapes that are new, except meshes and labels.
function applyFrame(act, { shapes }) {
  const shapeByName = new Map(act.shapes.map(shape => [shape.name, shape]));
  for (const { name, kind, group, points, colour, opacity, radius, value } of shapes) {
    let shape = shapeByName.get(name);
    if (!shape) {
      if (kind === "MeshShape" || kind === "Label") continue;
      act.shapes.push(shape = { name, kind, group, opacity });
    }
    Object.assign(shape, { points: oneRow(points), colours: oneRow(colour), now: new Float32Array(points.length) });
    if (radius) shape.radius = radius;
    if (value !== undefined) shape.values = oneRow([value]);
  }
}

// Follows the run until the server replaces the page by the replay of the run.
function followRun(act, changed) {
  const events = new EventSource("frames"), state = element("div", document.body, { className: "bar", textContent: "the run starts" });
  events.onmessage = event => {
    const frame = JSON.parse(event.data);
    applyFrame(act, frame);
    state.textContent = `running: ${frame.time.toFixed(2)} s`;
    changed();
  };
  events.addEventListener("reload", () => { events.close(); location.reload(); });
}
