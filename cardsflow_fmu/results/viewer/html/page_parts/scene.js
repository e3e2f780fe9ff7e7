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

function drawAct(played, index, count, drawing, camera, shown, now, pointer) {
  const { act, box, world } = played, [k, part] = frameAt(act.time, now);
  const lists = { solid: {}, clear: {}, shadowed: {} }, meshes = [], rgb = [0, 0, 0], value = [0];
  const uniforms = camera.uniforms(box.clientWidth / Math.max(box.clientHeight, 1));
  for (const shape of act.shapes) {
    const visible = shown.has(shape.group);
    if (!visible && !shape.element) continue;
    const trail = shape.kind === "Trail";
    const points = trail ? shape.points.numbers : rowAt(shape.points, k, part, shape.now);
    const colour = rowAt(shape.colours, k, 0, rgb), alpha = shape.opacity || 1;
    if (shape.kind === "Label") placeLabel(shape, points, rowAt(shape.values, k, part, value)[0], box, uniforms.view, visible, pointer);
    else if (shape.kind === "MeshShape") meshes.push({ mesh: shape.mesh, pose: poseOf(points, shape.lever), colour: colour.map(c => c / 255) });
    else {
      const targets = alpha < 1 ? [lists.clear] : trail || shape.kind === "Frame" || points.length > 200 ? [lists.solid] : [lists.solid, lists.shadowed];
      const shownPoints = trail ? rowAt(shape.values, k, 0, value)[0] : 0;
      compose(shape, points, shownPoints, colour, (body, a, b, radius, [red, green, blue]) => {
        for (const list of targets)
          (list[body] ||= []).push(a[0], a[1], a[2], b[0], b[1], b[2], radius, red / 255, green / 255, blue / 255, alpha);
      });
    }
  }
  drawing.draw(index, count, uniforms, world, lists, meshes);
}

function poseOf(p, lever) {
  const axis = i => [0, 1, 2].map(j => (p[3 * i + j] - p[j]) / lever);
  return new Float32Array([...axis(1), 0, ...axis(2), 0, ...axis(3), 0, p[0], p[1], p[2], 1]);
}

const NEAR = 70; // in pixels: a hidden label is shown if the pointer is closer

function placeLabel({ element: label, label: title }, point, value, box, view, visible, pointer) {
  const place = project(view, point);
  const x = place && place[0] * box.clientWidth, y = place && place[1] * box.clientHeight;
  const near = place && Math.hypot(x + box.offsetLeft - pointer[0], y + box.offsetTop - pointer[1]) < NEAR;
  label.hidden = !place || !(visible || near);
  if (label.hidden) return;
  label.textContent = `${title}: ${value.toFixed(3)}`;
  label.style.transform = `translate(${x}px, ${y}px) translate(-50%, -50%)`;
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
