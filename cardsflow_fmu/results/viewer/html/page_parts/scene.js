// Draws the shapes of an act at a time, with labels; the pointer and the text under it.

function playAct(act, index, count, drawing) {
  const box = element("div", document.querySelector(".scene") || document.body, { className: index === count - 1 ? "act last" : "act" });
  Object.assign(box.style, { left: `${100 * index / count}%`, width: `${100 / count}%` });
  addTitle(act, box);
  const world = surroundings(act);
  for (const shape of act.shapes) {
    shape.now = new Float32Array(shape.points.columns);
    if (shape.kind === "Label") shape.element = element("div", box, { className: "label" });
    if (shape.kind === "MeshShape") shape.mesh = drawing.mesh(shape.vertices.numbers, shape.faces.numbers);
  }
  return { act, box, world, end: act.time.at(-1) };
}

// Returns the last frame at or before a time, and the fraction of time to the next frame, from 0 to 1.
function frameAt(times, now) {
  let k = 0;
  for (let step = 1 << 20; step; step >>= 1) if (k + step < times.length && times[k + step] <= now) k += step;
  const next = times[k + 1];
  return [k, next === undefined ? 0 : Math.max(0, Math.min(1, (now - times[k]) / (next - times[k])))];
}

// Draws the shapes of an act at a time. Shapes keep their memory from frame to frame.
function drawAct(played, index, count, drawing, camera, shown, now, pointer) {
  const { act, box, world } = played, [k, part] = frameAt(act.time, now), { lists } = drawing;
  const uniforms = camera.uniforms(box.clientWidth / Math.max(box.clientHeight, 1));
  const meshes = played.meshes ||= [], value = played.value ||= [0], rgb = played.rgb ||= [0, 0, 0];
  const avoided = played.avoided ||= [];
  let list = lists.solid, alpha = 1;
  const put = (body, points, i, j, radius, colour) => list[body].add(points, i, j, radius, colour, alpha);
  drawing.clearBatches();
  meshes.length = avoided.length = 0;
  for (const shape of act.shapes) {
    const visible = shown.has(shape.group), { kind } = shape;
    if (!visible && !shape.element) continue;
    const trail = kind === "Trail", points = pointsAt(shape, k, part);
    if (kind === "Label") {
      placeLabel(shape, points, rowAt(shape.values, k, part, value)[0], box, uniforms.view, visible, pointer, avoided);
      continue;
    }
    rowAt(shape.colours, k, 0, rgb);
    if (kind === "MeshShape") {
      poseOf(points, shape.lever, shape.pose ||= new Float32Array(16));
      shape.tint ||= new Float32Array(3);
      for (let i = 0; i < 3; i++) shape.tint[i] = rgb[i] / 255;
      meshes.push(shape);
      continue;
    }
    alpha = shape.opacity || 1;
    list = shape.onTop ? lists.top : alpha < 1 ? lists.clear : trail || kind === "Frame" || points.length > 200 ? lists.solid : lists.shadowed;
    compose(shape, points, trail ? rowAt(shape.values, k, 0, value)[0] : 0, rgb, put);
  }
  drawing.draw(index, count, uniforms, world, meshes);
}

// Returns the points of a shape between frames k and k + 1, or all points of a trail.
function pointsAt({ kind, points, now }, k, part) {
  return kind === "Trail" || points.rows === 1 ? points.numbers : rowAt(points, k, part, now);
}

// Returns the pose of a mesh, column by column, from its origin and the tips of its axes.
function poseOf(p, lever, into = new Float32Array(16)) {
  for (let i = 0; i < 3; i++) for (let j = 0; j < 3; j++) into[4 * i + j] = (p[3 * i + 3 + j] - p[j]) / lever;
  for (let j = 0; j < 3; j++) into[12 + j] = p[j];
  into[15] = 1;
  return into;
}

const NEAR = 70; // in pixels: a hidden label is shown if the pointer is closer
const GAP = 2; // between labels, in pixels

// Shows a label at a point. `avoided` are the rectangles of title and other labels.
function placeLabel({ element: label, label: title }, point, value, box, view, visible, pointer, avoided) {
  const place = visible || !Number.isNaN(pointer[0]) ? project(view, point) : null;
  const x = place && place[0] * box.clientWidth, y = place && place[1] * box.clientHeight;
  const near = place && Math.hypot(x + box.offsetLeft - pointer[0], y + box.offsetTop - pointer[1]) < NEAR;
  label.hidden = !place || !(visible || near);
  if (label.hidden) return;
  const text = `${title}: ${value.toFixed(3)}`;
  setText(label, text);
  if (label.letters !== text.length) Object.assign(label, { letters: text.length, width: label.offsetWidth, height: label.offsetHeight });
  const left = x - label.width / 2, right = left + label.width;
  let top = y - label.height / 2;
  if (!avoided.length) avoided.push(titleOf(box));
  for (let i = 0; i < avoided.length; i++) {
    const other = avoided[i];
    if (left > other.right + GAP || right < other.left - GAP || top > other.bottom + GAP || top + label.height < other.top - GAP) continue;
    top = other.bottom + GAP + 1;
    i = -1; // the new place can meet another label
  }
  avoided.push({ left, right, top, bottom: top + label.height });
  label.style.transform = `translate(${left}px, ${top}px)`;
}

// Returns the rectangle of a title.
function titleOf(box) {
  const { offsetLeft: left, offsetTop: top, offsetWidth, offsetHeight } = box.firstChild;
  return { left, top, right: left + offsetWidth, bottom: top + offsetHeight };
}

// Returns the pointer position, [x, y]; NaN if the pointer is outside of the canvas.
function trackPointer(canvas, changed) {
  const pointer = [NaN, NaN];
  const at = (x, y) => { [pointer[0], pointer[1]] = [x, y]; changed(); };
  canvas.addEventListener("pointermove", event => at(event.clientX, event.clientY));
  canvas.addEventListener("pointerleave", () => at(NaN, NaN));
  return pointer;
}

// Returns the text of the thing under the pointer, or an empty text; valueOf(act, name) is the value of a signal.
function textAt(pointer, played, camera, shown, valueOf) {
  for (const { act, box } of played) {
    if (!(pointer[0] >= box.offsetLeft && pointer[0] < box.offsetLeft + box.clientWidth)) continue;
    const { view } = camera.uniforms(box.clientWidth / Math.max(box.clientHeight, 1));
    const shape = shapeAt(act.shapes, shown, view, box, pointer);
    return shape ? describe(shape, act, name => valueOf(act, name)) : "";
  }
  return "";
}
