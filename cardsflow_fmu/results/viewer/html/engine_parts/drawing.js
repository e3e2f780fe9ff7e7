// Poses of links and polylines of muscles at the state of the plant; see path_shapes.py.

class Drawing {
  constructor(plant, tables, part) {
    this.plant = plant;
    const integers = name => new Int32Array(part(tables[name]).slice().buffer);
    const reals = name => new Float64Array(part(tables[name]).slice().buffer);
    for (const name of ["frames", "points", "surfaces", "pulleys", "wrenched"]) this[name] = integers(name);
    for (const name of ["places", "half_axes", "radii"]) this[name] = reals(name);
    this.links = tables.links;
    this.poses = new Float32Array(12 * this.links.length);
    this.sizes = new Int32Array(this.points.length);
  }

  // Returns rotation, row by row, and position of a link in the world.
  pose(link, into = new Float64Array(12), at = 0) {
    const frame = this.frames[link], local = this.places.subarray(12 * link, 12 * link + 12);
    if (frame < 0) {
      into.set(local, at);
      return into;
    }
    const R = this.plant.array("frame_rotation").subarray(9 * frame, 9 * frame + 9);
    const o = this.plant.array("frame_origin").subarray(3 * frame, 3 * frame + 3);
    for (let i = 0; i < 3; i++) {
      for (let j = 0; j < 3; j++)
        into[at + 3 * i + j] = R[3 * i] * local[j] + R[3 * i + 1] * local[3 + j] + R[3 * i + 2] * local[6 + j];
      into[at + 9 + i] = o[i] + R[3 * i] * local[9] + R[3 * i + 1] * local[10] + R[3 * i + 2] * local[11];
    }
    return into;
  }

  allPoses() {
    for (let link = 0; link < this.links.length; link++) this.pose(link, this.poses, 12 * link);
    return this.poses;
  }

  // Returns the polylines of all muscles, one after the other; their lengths are in `sizes`.
  paths() {
    this.plant.trace();
    const points = this.plant.array("points"), shares = this.plant.array("point_share");
    const contacts = this.contacts(), line = [];
    let point = 0;
    this.points.forEach((count, muscle) => {
      const begin = line.length;
      for (const end = point + count; point < end; point++) {
        if (shares[point] < 0.5) continue;
        line.push(points[3 * point], points[3 * point + 1], points[3 * point + 2]);
        for (const contact of contacts.get(point) || []) drawArc(contact, line);
      }
      this.sizes[muscle] = (line.length - begin) / 3;
    });
    return new Float32Array(line);
  }

  // Returns the contacts with surfaces and pulleys by the via point before them, in order.
  contacts() {
    const byPoint = new Map(), add = (point, contact) =>
      byPoint.has(point) ? byPoint.get(point).push(contact) : byPoint.set(point, [contact]);
    const pulleys = this.plant.array("pulley_contacts"), wraps = this.plant.array("wrap_contacts");
    const firsts = [];
    this.points.reduce((first, count) => (firsts.push(first), first + count), 0);
    this.pulleys.forEach((muscle, k) => {
      const contact = contactOf(pulleys.subarray(22 * k, 22 * k + 22));
      const across = cross3(contact.axis, contact.entering);
      contact.centre = contact.touch.map((x, i) => x + this.radii[k] * across[i]);
      if (contact.angle) add(firsts[muscle], contact);
    });
    const before = this.plant.array("wrap_before"), rank = this.plant.array("wrap_rank");
    const places = this.plant.array("surface_places"), across = this.plant.array("surface_across");
    const order = Array.from(before.keys()).sort((a, b) => before[a] - before[b] || rank[a] - rank[b]);
    for (const k of order) {
      const contact = contactOf(wraps.subarray(22 * k, 22 * k + 22)), surface = this.surfaces[k];
      if (!contact.angle || before[k] < 0) continue;
      contact.centre = Array.from(places.subarray(6 * surface, 6 * surface + 3));
      const half = this.half_axes.subarray(3 * surface, 3 * surface + 3);
      if (half[0]) {
        const z = Array.from(places.subarray(6 * surface + 3, 6 * surface + 6));
        const x = Array.from(across.subarray(3 * surface, 3 * surface + 3));
        contact.ellipsoid = { half, axes: [x, cross3(z, x), z] };
      }
      add(before[k], contact);
    }
    return byPoint;
  }
}

function contactOf(numbers) {
  const at = k => Array.from(numbers.subarray(3 * k, 3 * k + 3));
  return { entering: at(1), touch: at(4), lift: at(5), axis: at(6), angle: numbers[21] };
}

const dot3 = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross3 = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];

// Appends the points of an arc from touch to lift.
function drawArc({ touch, lift, centre, axis, angle, ellipsoid }, line) {
  if (ellipsoid) {
    drawEllipsoidArc(touch, lift, centre, ellipsoid, line);
    return;
  }
  const steps = Math.max(1, Math.ceil(angle / (Math.PI / 36)));
  const start = touch.map((x, i) => x - centre[i]), along = dot3(start, axis);
  const across = start.map((x, i) => x - along * axis[i]), aside = cross3(axis, across);
  const climb = dot3(lift.map((x, i) => x - touch[i]), axis);
  line.push(...touch);
  for (let k = 1; k < steps; k++) {
    const c = Math.cos(angle * k / steps), s = Math.sin(angle * k / steps), up = along + climb * k / steps;
    for (let i = 0; i < 3; i++) line.push(centre[i] + c * across[i] + s * aside[i] + up * axis[i]);
  }
  line.push(...lift);
}

// Draws the great circle of the unit sphere that the ellipsoid is scaled from; it is close to the shortest path.
function drawEllipsoidArc(touch, lift, centre, { half, axes }, line) {
  const scaled = point => axes.map((axis, i) => dot3(point.map((x, j) => x - centre[j]), axis) / half[i]);
  const a = scaled(touch), b = scaled(lift);
  line.push(...touch);
  for (let k = 1; k < 16; k++) {
    const mix = a.map((x, i) => x + (b[i] - x) * k / 16), size = Math.hypot(...mix) || 1;
    for (let j = 0; j < 3; j++)
      line.push(centre[j] + axes.reduce((sum, axis, i) => sum + axis[j] * half[i] * mix[i] / size, 0));
  }
  line.push(...lift);
}
