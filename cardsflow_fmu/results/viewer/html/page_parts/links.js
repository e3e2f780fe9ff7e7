// Shapes that move with links, and rays from the pointer that hit them. A pose has 12 numbers: rotation row by row, position.

// Returns a point of a link's frame in the world.
const toWorld = (T, [x, y, z]) => [0, 1, 2].map(j => T[9 + j] + T[3 * j] * x + T[3 * j + 1] * y + T[3 * j + 2] * z);

// Returns a point of the world in a link's frame.
const toLink = (T, place) => directionToLink(T, [0, 1, 2].map(j => place[j] - T[9 + j]));
const directionToLink = (T, v) => [0, 1, 2].map(k => T[k] * v[0] + T[3 + k] * v[1] + T[6 + k] * v[2]);
const directionToWorld = (T, v) => [0, 1, 2].map(j => T[3 * j] * v[0] + T[3 * j + 1] * v[1] + T[3 * j + 2] * v[2]);

const pointAt = (numbers, k) => Array.from(numbers.subarray(3 * k, 3 * k + 3));

// Fixes a shape to a link at its pose; `moveShape` then moves it with the link.
function fixShape(shape, link, T) {
  const points = shape.points.numbers;
  shape.link = link;
  shape.local = new Float32Array(points.length);
  for (let i = 0; i < points.length; i += 3) shape.local.set(toLink(T, points.subarray(i, i + 3)), i);
}

function moveShape({ local, points: { numbers } }, T) {
  for (let i = 0; i < local.length; i += 3)
    for (let j = 0; j < 3; j++)
      numbers[i + j] = T[9 + j] + T[3 * j] * local[i] + T[3 * j + 1] * local[i + 1] + T[3 * j + 2] * local[i + 2];
}

function setPoints(shape, numbers, colour) {
  shape.points = { rows: 1, columns: numbers.length, numbers };
  if (colour) shape.colours = { rows: 1, columns: 3, numbers: Float32Array.from(colour) };
}

const BROKEN = [150, 60, 60]; // colour of a broken cable

// Returns the points of a broken cable, which ends after a share of its path.
function stumpOf(points, share = 0.4) {
  const stump = points.slice(), apart = at => Math.hypot(points[at] - points[at - 3], points[at + 1] - points[at - 2], points[at + 2] - points[at - 1]);
  let left = 0;
  for (let at = 3; at < points.length; at += 3) left += share * apart(at);
  for (let at = 3; at < points.length; at += 3) {
    const length = apart(at), fraction = length > 0 ? Math.min(1, left / length) : 0;
    for (let i = at; i < at + 3; i++) stump[i] = stump[i - 3] + fraction * (points[i] - points[i - 3]);
    left -= fraction * length;
  }
  return stump;
}

// Returns origin and direction of the ray through a point of the canvas.
function rayAt(camera, canvas, x, y) {
  const aspect = canvas.clientWidth / Math.max(canvas.clientHeight, 1), { eye } = camera.uniforms(aspect);
  const { back, right, top } = camera.axes();
  const across = (2 * x / canvas.clientWidth - 1) * SLOPE * aspect, up = (1 - 2 * y / canvas.clientHeight) * SLOPE;
  return { eye, direction: unit(sum(sum(back.map(v => -v), right, across), top, up)) };
}

const onRay = (ray, t) => sum(ray.eye, ray.direction, t);

// Returns the distance along a ray at which it enters a ball; Infinity without a hit.
function hitBall({ eye, direction }, centre, radius) {
  const from = sum(eye, centre, -1), b = dot(from, direction), under = b * b - dot(from, from) + radius * radius;
  return under >= 0 && -b > Math.sqrt(under) ? -b - Math.sqrt(under) : Infinity;
}

// Returns the distance to the side of a tube from a to b.
function hitTube({ eye, direction }, a, b, radius) {
  const axis = sum(b, a, -1), length = Math.hypot(...axis);
  if (!length) return Infinity;
  const n = axis.map(x => x / length), from = sum(eye, a, -1), d = sum(direction, n, -dot(direction, n)), m = sum(from, n, -dot(from, n));
  const A = dot(d, d), B = dot(d, m), under = B * B - A * (dot(m, m) - radius * radius);
  if (!(under >= 0 && A > 0)) return Infinity;
  const t = (-B - Math.sqrt(under)) / A, along = dot(from, n) + t * dot(direction, n);
  return t > 0 && along >= 0 && along <= length ? t : Infinity;
}

// Returns the distance to the disc around a, across the direction to b.
function hitDisc({ eye, direction }, a, b, radius) {
  const n = sum(b, a, -1), t = dot(sum(a, eye, -1), n) / dot(direction, n), p = sum(sum(eye, direction, t), a, -1);
  return t > 0 && dot(p, p) <= radius * radius ? t : Infinity;
}

const hitCapsule = (ray, a, b, radius) => Math.min(hitTube(ray, a, b, radius), hitBall(ray, a, radius), hitBall(ray, b, radius));
const hitCylinder = (ray, a, b, radius) => Math.min(hitTube(ray, a, b, radius), hitDisc(ray, a, b, radius), hitDisc(ray, b, a, radius));

// Returns the distance along a ray, in the frame of a mesh, at which it hits a triangle, and the triangle.
function hitMesh({ eye, direction }, vertices, faces) {
  let t = Infinity, face = -1;
  const at = k => [vertices[3 * k], vertices[3 * k + 1], vertices[3 * k + 2]];
  for (let k = 0; k < faces.length; k += 3) {
    const a = at(faces[k]), u = sum(at(faces[k + 1]), a, -1), v = sum(at(faces[k + 2]), a, -1);
    const p = cross(direction, v), det = dot(u, p);
    if (Math.abs(det) < 1e-15) continue;
    const s = sum(eye, a, -1), x = dot(s, p) / det, q = cross(s, u), y = dot(direction, q) / det;
    const along = dot(v, q) / det;
    if (x >= 0 && y >= 0 && x + y <= 1 && along > 0 && along < t) [t, face] = [along, k];
  }
  return { t, face };
}

// Returns the radius of a mesh about its origin, which is computed once.
function meshRadius(shape) {
  if (shape.around === undefined) {
    const { numbers } = shape.vertices;
    let square = 0;
    for (let i = 0; i < numbers.length; i += 3) square = Math.max(square, numbers[i] ** 2 + numbers[i + 1] ** 2 + numbers[i + 2] ** 2);
    shape.around = Math.sqrt(square);
  }
  return shape.around;
}

// Returns whether a ray meets a ball, also from inside.
function meetsBall({ eye, direction }, centre, radius) {
  const to = sum(centre, eye, -1), t = Math.max(0, dot(to, direction));
  return Math.hypot(...sum(to, direction, -t)) <= radius;
}

// Returns the distance at which a ray hits a shape; { t, vertices } with the corners of the triangle of a mesh.
function hitShape(ray, shape, thicker) {
  const p = shape.points.numbers;
  if (shape.kind === "Sphere") return { t: hitBall(ray, pointAt(p, 0), shape.radius) };
  if (shape.kind === "Capsule") return { t: hitCapsule(ray, pointAt(p, 0), pointAt(p, 1), thicker * shape.radius) };
  if (shape.kind === "Cylinder") return { t: hitCylinder(ray, pointAt(p, 0), pointAt(p, 1), shape.radius) };
  if (shape.kind !== "MeshShape") return { t: Infinity };
  const pose = poseOf(p, shape.lever), columns = [0, 1, 2].map(k => [pose[4 * k], pose[4 * k + 1], pose[4 * k + 2]]);
  const squares = columns.map(c => dot(c, c)); // not 1 for an ellipsoid, whose mesh is a sphere
  if (!meetsBall(ray, pointAt(p, 0), Math.sqrt(Math.max(...squares)) * meshRadius(shape))) return { t: Infinity };
  const local = v => columns.map((c, k) => dot(v, c) / squares[k]);
  const numbers = shape.vertices.numbers, faces = shape.faces.numbers;
  const { t, face } = hitMesh({ eye: local(sum(ray.eye, pointAt(p, 0), -1)), direction: local(ray.direction) }, numbers, faces);
  const placed = v => [0, 1, 2].reduce((sumOf, k) => sum(sumOf, columns[k], v[k]), pointAt(p, 0));
  return { t, vertices: face < 0 ? [] : [0, 1, 2].map(k => placed(pointAt(numbers, faces[face + k]))) };
}

// Returns the nearest shape of a link on a ray, as { shape, t, vertices }, or null.
function pick(ray, shapes, shown, thicker = 1) {
  let best = null;
  for (const shape of shapes) {
    if (shape.link === undefined || !shown.has(shape.group)) continue;
    const hit = hitShape(ray, shape, thicker);
    if (hit.t < (best ? best.t : Infinity)) best = { shape, ...hit };
  }
  return best;
}

// Returns where a ray meets the plane through a place that faces the camera.
function onPlane(ray, camera, place) {
  const { back } = camera.axes();
  return onRay(ray, dot(sum(place, ray.eye, -1), back) / dot(ray.direction, back));
}
