// Place under the pointer: on the surface of a link, at a vertex of its mesh, or on the axis of a joint.

const NEAR_SNAP = 9; // in pixels

// Returns { place, link, text, axis? } under the pointer, or null. Snapping is optional.
function placeAt(editor, [x, y], snaps) {
  const ray = rayAt(editor.camera, editor.canvas, x, y), hit = pick(ray, editor.linkShapes, editor.shown) ?? pick(ray, editor.linkShapes, editor.shown, 2.2);
  const onAxis = snaps && snapToAxis(editor, ray, [x, y], hit);
  if (onAxis) return onAxis;
  if (!hit) return null;
  const { link } = hit.shape, place = onSurface(hit.shape, onRay(ray, hit.t));
  const vertex = snaps && (hit.vertices || []).find(v => pixelsTo(editor, v, [x, y]) < NEAR_SNAP);
  return vertex ? { place: vertex, link, text: `${link}: vertex` } : { place, link, text: link };
}

// Returns the point of a capsule's surface below a place, because thin capsules are also hit next to them.
function onSurface({ kind, points, radius }, place) {
  if (kind !== "Capsule") return place;
  const a = pointAt(points.numbers, 0), axis = sum(pointAt(points.numbers, 1), a, -1), square = dot(axis, axis);
  const foot = sum(a, axis, square > 0 ? Math.max(0, Math.min(1, dot(sum(place, a, -1), axis) / square)) : 0);
  return sum(foot, unit(sum(place, foot, -1)), radius);
}

const pixelsTo = (editor, place, [x, y]) => {
  const pixel = editor.pixelOf(place);
  return pixel ? Math.hypot(pixel[0] - x, pixel[1] - y) : Infinity;
};

// Returns the point of a joint axis under the pointer, near the joint; its centre is preferred.
function snapToAxis(editor, ray, pointer, hit) {
  const reach = 0.06 * editor.act.reach;
  let best = null, nearest = NEAR_SNAP;
  for (const axis of editor.worldAxes()) {
    const along = Math.max(-reach, Math.min(reach, alongAxis(axis, ray)));
    for (const [distance, text, bonus] of [[along, "axis", 0], [0, "centre", 3]]) {
      const place = sum(axis.place, axis.direction, distance), away = pixelsTo(editor, place, pointer) - bonus;
      if (away < nearest) [best, nearest] = [{ place, axis, link: hit ? hit.shape.link : axis.child, text: `${text} of ${axis.name}` }, away];
    }
  }
  return best;
}

// Returns the coordinate along an axis of its point that is nearest to a ray.
function alongAxis({ place, direction }, ray) {
  const w = sum(ray.eye, place, -1), b = dot(direction, ray.direction), under = 1 - b * b;
  return under < 1e-9 ? 0 : (dot(w, direction) - b * dot(w, ray.direction)) / under;
}

// Returns the nearest handle within a few pixels; handles of the selection are preferred.
function handleAt(editor, pointer, wide) {
  let best = null, nearest = wide ? 22 : 11;
  for (const handle of editor.shapesOf.handles) {
    const away = pixelsTo(editor, handle.place, pointer) - (handle.isSelected ? 3 : 0);
    if (away < nearest) [best, nearest] = [handle, away];
  }
  return best;
}

// Returns the muscle or wrap surface under the pointer, as { muscle } or { wrap }, or null.
function itemAt(editor, pointer) {
  const { view } = editor.uniforms(), line = shapeAt(editor.shapesOf.shapes.filter(shape => shape.muscle), editor.shown, view, editor.played.box, pointer);
  if (line) return { muscle: line.muscle };
  const ray = rayAt(editor.camera, editor.canvas, ...pointer);
  let best = null, nearest = Infinity;
  for (const shape of editor.shapesOf.shapes) {
    const t = shape.wrap && editor.shown.has(shape.group) ? hitShape(ray, shape, 1).t : Infinity;
    if (t < nearest) [best, nearest] = [{ wrap: shape.wrap, t }, t];
  }
  return best;
}

// Returns a direction that is turned to a near axis of the link or of a joint, and a text.
function snapDirection(editor, wrap, direction) {
  const T = editor.poses[wrap.link], named = [..."xyz"].map((axis, i) => [`${axis} axis of ${wrap.link}`, [T[i], T[3 + i], T[6 + i]]]);
  for (const axis of editor.worldAxes()) named.push([`axis of ${axis.name}`, axis.direction]);
  for (const [text, d] of named) {
    const cosine = dot(direction, d);
    if (Math.abs(cosine) > Math.cos(0.1)) return { direction: d.map(v => Math.sign(cosine) * v), text };
  }
  return { direction, text: "" };
}
