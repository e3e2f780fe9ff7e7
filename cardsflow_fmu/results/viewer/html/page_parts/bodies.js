// Unit bodies. A vertex is [x, y, z, t, normal]; its position is a + t (b - a) + radius * (x, y, z).
// The z axis points from a to b.

function ball(around, rings) {
  const vertices = [], faces = [];
  for (let i = 0; i <= rings; i++)
    for (let j = 0; j <= around; j++) {
      const up = Math.PI * i / rings, turn = 2 * Math.PI * j / around;
      const n = [Math.sin(up) * Math.cos(turn), Math.sin(up) * Math.sin(turn), Math.cos(up)];
      vertices.push(...n, 0, ...n);
      if (i && j) {
        const d = i * (around + 1) + j, c = d - around - 1;
        faces.push(c - 1, d - 1, d, c - 1, d, c);
      }
    }
  return { vertices: new Float32Array(vertices), faces: new Uint16Array(faces) };
}

// Returns a tube with radius 1 at a and radius `top` at b; discs close it if `closed` is true.
function tube(around, top, closed) {
  const vertices = [], faces = [];
  const ring = (radius, t, normal) => {
    const first = vertices.length / 7;
    for (let j = 0; j <= around; j++) {
      const x = Math.cos(2 * Math.PI * j / around), y = Math.sin(2 * Math.PI * j / around);
      vertices.push(radius * x, radius * y, 0, t, ...(normal || [x, y, 0]));
    }
    return first;
  };
  const a = ring(1, 0), b = ring(top, 1);
  for (let j = 0; j < around; j++) faces.push(a + j, a + j + 1, b + j + 1, a + j, b + j + 1, b + j);
  if (closed)
    for (const [radius, t, z] of [[1, 0, -1], [top, 1, 1]]) {
      const rim = ring(radius, t, [0, 0, z]), centre = ring(0, t, [0, 0, z]);
      for (let j = 0; j < around; j++) faces.push(rim + j, rim + j + 1, centre + j);
    }
  return { vertices: new Float32Array(vertices), faces: new Uint16Array(faces) };
}

const BODIES = {
  ball: ball(20, 12),
  bead: ball(8, 5),
  tube: tube(14, 1, false),
  thread: tube(5, 1, false),
  cylinder: tube(32, 1, true),
  cone: tube(14, 0, true),
};

// Calls put(body, a, b, radius, colour) for each body of a shape; `points` is the flat list of its points at one time.
function compose(shape, points, shown, colour, put) {
  const at = i => points.subarray(3 * i, 3 * i + 3), last = points.length / 3 - 1, r = shape.radius;
  const far = (a, b) => Math.hypot(b[0] - a[0], b[1] - a[1], b[2] - a[2]);
  const along = (a, b, part) => a.map((x, i) => x + part * (b[i] - x));
  switch (shape.kind) {
    case "Line": {
      const fine = last > 60;
      for (let i = 0; i < last; i++) {
        put(fine ? "thread" : "tube", at(i), at(i + 1), r, colour);
        if (i && !fine) put("bead", at(i), at(i), r, colour);
      }
      break;
    }
    case "Trail":
      for (let i = 0; i < shown; i++) put("bead", at(i), at(i), r, colour);
      break;
    case "Sphere":
      put("ball", at(0), at(0), r, colour);
      break;
    case "Capsule":
      put("ball", at(0), at(0), r, colour);
      put("ball", at(1), at(1), r, colour);
      put("tube", at(0), at(1), r, colour);
      break;
    case "Cylinder":
      put("cylinder", at(0), at(1), r, colour);
      break;
    case "Arrow": {
      const length = far(at(0), at(1)), head = Math.min(13 * r, 0.6 * length);
      if (length < 0.5 * r) break;
      const neck = along(at(0), at(1), 1 - head / length);
      put("tube", at(0), neck, r, colour);
      put("cone", neck, at(1), Math.min(4.5 * r, 0.6 * head), colour);
      break;
    }
    case "Frame":
      [[214, 58, 58], [52, 160, 76], [52, 104, 220]].forEach((axis, i) => put("tube", at(0), at(i + 1), r, axis));
      break;
  }
}
