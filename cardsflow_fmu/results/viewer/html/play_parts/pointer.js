// Pointer in a page that simulates: drag a link to pull it, drag the target to move it.

// Returns origin and direction of the ray through a point of the canvas.
function rayAt(camera, canvas, x, y) {
  const aspect = canvas.clientWidth / Math.max(canvas.clientHeight, 1), { eye } = camera.uniforms(aspect);
  const { back, right, top } = camera.axes();
  const across = (2 * x / canvas.clientWidth - 1) * SLOPE * aspect, up = (1 - 2 * y / canvas.clientHeight) * SLOPE;
  return { eye, direction: unit(sum(sum(back.map(v => -v), right, across), top, up)) };
}

const onRay = (ray, t) => sum(ray.eye, ray.direction, t);

// Returns the distance along a ray at which it enters a capsule from a to b, about; Infinity without a hit.
function hitCapsule({ eye, direction }, a, b, radius) {
  const axis = sum(b, a, -1), from = sum(eye, a, -1), length = dot(axis, axis);
  const along = dot(direction, axis), d = dot(direction, from), e = dot(axis, from);
  const skew = length - along * along;
  const part = length > 0 ? Math.max(0, Math.min(1, skew > 1e-12 * length ? (e - along * d) / skew : 0)) : 0;
  const t = dot(sum(sum(a, axis, part), eye, -1), direction);
  const near = sum(sum(eye, direction, t), sum(a, axis, part), -1);
  return t > 0 && dot(near, near) <= radius * radius ? t - Math.sqrt(radius * radius - dot(near, near)) : Infinity;
}

// Returns the distance along a ray, in the frame of a mesh, at which it hits a triangle.
function hitMesh(eye, direction, vertices, faces) {
  let best = Infinity;
  const at = k => [vertices[3 * k], vertices[3 * k + 1], vertices[3 * k + 2]];
  for (let k = 0; k < faces.length; k += 3) {
    const a = at(faces[k]), u = sum(at(faces[k + 1]), a, -1), v = sum(at(faces[k + 2]), a, -1);
    const p = cross(direction, v), det = dot(u, p);
    if (Math.abs(det) < 1e-15) continue;
    const s = sum(eye, a, -1), x = dot(s, p) / det, q = cross(s, u), y = dot(direction, q) / det;
    const t = dot(v, q) / det;
    if (x >= 0 && y >= 0 && x + y <= 1 && t > 0) best = Math.min(best, t);
  }
  return best;
}

// Returns the nearest shape of a link on a ray, as { shape, t }, or null.
function pick(ray, shapes, shown) {
  let best = null;
  for (const shape of shapes) {
    if (shape.link === undefined || !shown.has(shape.group)) continue;
    const p = shape.points.numbers, at = k => Array.from(p.subarray(3 * k, 3 * k + 3));
    let t = Infinity;
    if (shape.kind === "Sphere") t = hitCapsule(ray, at(0), at(0), shape.radius);
    if (shape.kind === "Capsule" || shape.kind === "Cylinder") t = hitCapsule(ray, at(0), at(1), 1.5 * shape.radius);
    if (shape.kind === "MeshShape") {
      const pose = poseOf(p, shape.lever), column = k => [pose[4 * k], pose[4 * k + 1], pose[4 * k + 2]];
      const local = v => [0, 1, 2].map(k => dot(v, column(k)));
      t = hitMesh(local(sum(ray.eye, at(0), -1)), local(ray.direction), shape.vertices.numbers, shape.faces.numbers);
    }
    if (t < (best ? best.t : Infinity)) best = { shape, t };
  }
  return best;
}

// Handles pointer events before the camera does. `play` has `client`, `shapes`, `shown`, `targetPoint`, `moveTarget`.
function handlePulling(canvas, camera, play) {
  let drag = null;
  const move = event => {
    const ray = rayAt(camera, canvas, event.offsetX, event.offsetY), { back } = camera.axes();
    const t = dot(sum(drag.place, ray.eye, -1), back) / dot(ray.direction, back);
    return onRay(ray, t);
  };
  canvas.addEventListener("pointerdown", event => {
    if (event.button !== 0 || event.shiftKey || drag || play.client.frame.mode === "pose") return;
    const ray = rayAt(camera, canvas, event.offsetX, event.offsetY), target = play.targetPoint();
    if (target && hitCapsule(ray, target, target, 2 * play.targetRadius) < Infinity) drag = { place: target, isTarget: true };
    else {
      const hit = pick(ray, play.shapes, play.shown);
      if (!hit) return;
      const place = onRay(ray, hit.t);
      drag = { place, link: hit.shape.link, point: play.inLink(hit.shape.link, place) };
    }
    event.stopImmediatePropagation();
    canvas.setPointerCapture(event.pointerId);
  }, true);
  canvas.addEventListener("pointermove", event => {
    if (!drag) return;
    event.stopImmediatePropagation();
    if (drag.isTarget) play.moveTarget(move(event));
    else {
      play.spring = move(event);
      play.panel.do(play.client.pull(drag.link, drag.point, play.spring, play.stiffness));
    }
  }, true);
  for (const end of ["pointerup", "pointercancel"])
    canvas.addEventListener(end, event => {
      if (!drag) return;
      event.stopImmediatePropagation();
      if (!drag.isTarget) play.client.release();
      play.spring = null;
      drag = null;
    }, true);
}
