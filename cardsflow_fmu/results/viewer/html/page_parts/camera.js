// Camera that orbits a point. Dragging rotates it, dragging with Shift or another button moves it, the wheel zooms.

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = a => { const l = Math.hypot(...a); return a.map(x => x / l); };
const sum = (a, b, factor = 1) => a.map((x, i) => x + factor * b[i]);

// Returns the eight corners of a box.
const corners = (low, high) => [0, 1, 2, 3, 4, 5, 6, 7].map(k => low.map((x, j) => k >> j & 1 ? high[j] : x));

// Returns the surroundings of a motion: bounding box, centre, floor, and axes of the camera.
function surroundings(act) {
  const up = act.up, east = unit(cross(Math.abs(up[1]) < 0.9 ? [0, 1, 0] : [0, 0, 1], up)), north = cross(up, east);
  const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  const include = p => [east, north, up].forEach((axis, j) => {
    low[j] = Math.min(low[j], dot(axis, p));
    high[j] = Math.max(high[j], dot(axis, p));
  });
  corners(...act.box).forEach(include);
  for (const { kind, name, points } of act.shapes) {
    if (kind === "Frame" || kind === "Arrow" || kind === "Label") continue; // their points include points of other parts
    if (kind === "MeshShape" && !name.startsWith("objects/")) continue;
    const step = kind === "MeshShape" ? points.columns : 3; // only the origin of a mesh
    for (let i = 0; i < points.numbers.length; i += step) include(points.numbers.subarray(i, i + 3));
  }
  const size = high.map((x, j) => x - low[j]), mid = high.map((x, j) => (x + low[j]) / 2);
  const place = (e, n, u) => sum(sum(east.map(x => e * x), north, n), up, u);
  const floorHeight = act.floor ?? low[2] - 0.06 * act.reach;
  return {
    up, east, north, reach: act.reach, floorHeight,
    centre: place(...mid), middle: place(mid[0], mid[1], floorHeight),
    flat: Math.min(size[0], size[1]) < 0.02 * act.reach, alongEast: size[0] < size[1], plane: act.plane,
    corners: corners(low, high).map(([e, n, u]) => place(e, n, u)),
  };
}

const RIGHT_ANGLE = Math.PI / 2;
const SLOPE = Math.tan(0.36), FILLED = 0.88; // slope of half the field of view; filled fraction of the view at the start

class Camera {
  constructor(world, aspect) {
    this.world = world;
    this.target = world.centre;
    this.aspect = aspect;
    this.lookAtStart();
    this.distance = this.fittingDistance();
  }

  // Turns to the plane of motion of a planar robot, or to the widest side of another one.
  lookAtStart() {
    const { flat, alongEast, plane, up, east, north } = this.world, rotation = flat || plane ? 0.22 : 0.5;
    this.turn = (alongEast ? 0 : -Math.PI / 2) + rotation;
    this.tilt = flat ? 0.14 : 0.3;
    if (!plane) return;
    const back = dot(plane, up) < -0.5 || dot(plane, north) > 0.5 || dot(plane, east) < -0.5 ? plane.map(x => -x) : plane;
    const isLevel = Math.abs(dot(back, up)) < 0.999;
    this.turn = isLevel ? Math.atan2(dot(back, north), dot(back, east)) + rotation : -Math.PI / 2;
    this.tilt = Math.max(-RIGHT_ANGLE, Math.min(RIGHT_ANGLE, Math.asin(Math.max(-1, Math.min(1, dot(back, up)))) + (isLevel ? 0.14 : 0)));
  }

  // Shows the front, a side, the top, or the whole scene from the current direction.
  show(view) {
    const views = { front: [-Math.PI / 2, 0], side: [0, 0], top: [-Math.PI / 2, RIGHT_ANGLE] };
    if (views[view]) [this.turn, this.tilt] = views[view];
    this.target = this.world.centre;
    this.distance = this.fittingDistance();
  }

  // Returns the distance from which all corners of the bounding box are visible.
  fittingDistance() {
    const { back, right, top } = this.axes();
    return Math.max(1e-6, ...this.world.corners.map(corner => {
      const p = sum(corner, this.target, -1);
      return Math.max(Math.abs(dot(top, p)), Math.abs(dot(right, p)) / this.aspect) / (FILLED * SLOPE) + dot(back, p);
    }));
  }

  axes() {
    const { up, east, north } = this.world, c = Math.cos(this.tilt);
    const level = sum(east.map(x => Math.cos(this.turn) * x), north, Math.sin(this.turn));
    const back = sum(level.map(x => c * x), up, Math.sin(this.tilt)), right = unit(cross(up, level));
    return { back, right, top: cross(back, right) };
  }

  handleInput(canvas, changed) {
    const fingers = new Map();
    canvas.addEventListener("contextmenu", event => event.preventDefault());
    canvas.addEventListener("pointerdown", event => { canvas.setPointerCapture(event.pointerId); fingers.set(event.pointerId, event); });
    for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, event => fingers.delete(event.pointerId));
    canvas.addEventListener("pointermove", event => {
      const before = fingers.get(event.pointerId);
      if (!before) return;
      const dx = event.clientX - before.clientX, dy = event.clientY - before.clientY;
      if (fingers.size === 2) {
        const [other] = [...fingers.values()].filter(finger => finger.pointerId !== event.pointerId);
        const apart = finger => Math.hypot(finger.clientX - other.clientX, finger.clientY - other.clientY) || 1;
        this.distance *= apart(before) / apart(event);
      } else if (event.buttons === 1 && !event.shiftKey) {
        this.turn -= 0.008 * dx;
        this.tilt = Math.max(-RIGHT_ANGLE, Math.min(RIGHT_ANGLE, this.tilt + 0.008 * dy));
      } else {
        const { right, top } = this.axes(), step = this.distance * 0.0011;
        this.target = sum(sum(this.target, right, -step * dx), top, step * dy);
      }
      fingers.set(event.pointerId, event);
      changed();
    });
    canvas.addEventListener("wheel", event => {
      event.preventDefault();
      this.distance *= Math.exp(0.001 * event.deltaY);
      changed();
    }, { passive: false });
  }

  // Returns the column-major projection matrix and the position of the eye, which are cached until the view changes.
  uniforms(aspect) {
    const { turn, tilt, distance, target, cached } = this;
    if (cached && cached.turn === turn && cached.tilt === tilt && cached.distance === distance && cached.target === target && cached.aspect === aspect)
      return cached.uniforms;
    this.cached = { turn, tilt, distance, target, aspect, uniforms: this.computeUniforms(aspect) };
    return this.cached.uniforms;
  }

  computeUniforms(aspect) {
    const { back, right, top } = this.axes();
    const far = Math.max(1, this.aspect / aspect) * this.distance, eye = sum(this.target, back, far);
    const near = far / 50, end = far * 20, f = 1 / SLOPE;
    const row = (axis, factor) => [...axis.map(x => factor * x), -factor * dot(axis, eye)];
    const x = row(right, f / aspect), y = row(top, f), w = row(back, -1); // w: distance in front of the eye
    const z = w.map((d, i) => (d * (end + near) - (i === 3 ? 2 * end * near : 0)) / (end - near));
    const view = new Float32Array(16);
    for (let i = 0; i < 4; i++) [x, y, z, w].forEach((line, j) => { view[4 * i + j] = line[i]; });
    return { view, eye };
  }
}

// Returns the position of a point in the window, as fractions of width and height; null behind the camera.
function project(view, p) {
  const at = j => view[j] * p[0] + view[4 + j] * p[1] + view[8 + j] * p[2] + view[12 + j];
  const w = at(3);
  return w > 0 ? [0.5 + at(0) / w / 2, 0.5 - at(1) / w / 2] : null;
}
