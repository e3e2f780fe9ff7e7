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

const AXES = [[214, 58, 58], [52, 160, 76], [52, 104, 220]];
const arrow = new Float32Array(6); // neck and tip

// Calls put(body, points, i, j, radius, colour) for each body of a shape, which extends from point i to point j;
// `points` is the flat list of the points at one time, of which a trail shows only some.
function compose({ kind, radius }, points, shown, colour, put) {
  const last = points.length / 3 - 1;
  switch (kind) {
    case "Line":
      for (let i = 0; i < last; i++) {
        put(last > 60 ? "thread" : "tube", points, i, i + 1, radius, colour);
        if (i && last <= 60) put("bead", points, i, i, radius, colour);
      }
      break;
    case "Trail":
      for (let i = 0; i < shown; i++) put("bead", points, i, i, radius, colour);
      break;
    case "Sphere":
      put("ball", points, 0, 0, radius, colour);
      break;
    case "Capsule":
      put("ball", points, 0, 0, radius, colour);
      put("ball", points, 1, 1, radius, colour);
      put("tube", points, 0, 1, radius, colour);
      break;
    case "Cylinder":
      put("cylinder", points, 0, 1, radius, colour);
      break;
    case "Arrow": {
      const length = Math.hypot(points[3] - points[0], points[4] - points[1], points[5] - points[2]);
      if (!(length >= 0.5 * radius)) break;
      const head = Math.min(13 * radius, 0.6 * length), part = 1 - head / length;
      for (let k = 0; k < 3; k++) {
        arrow[k] = points[k] + part * (points[3 + k] - points[k]);
        arrow[3 + k] = points[3 + k];
      }
      put("cone", arrow, 0, 1, Math.min(4.5 * radius, 0.6 * head), colour);
      for (let k = 0; k < 3; k++) {
        arrow[3 + k] = arrow[k];
        arrow[k] = points[k];
      }
      put("tube", arrow, 0, 1, radius, colour);
      break;
    }
    case "Frame":
      for (let i = 0; i < 3; i++) put("tube", points, 0, i + 1, radius, AXES[i]);
      break;
  }
}
