// Mirror images of muscles in a plane through the origin of the world, at the initial pose.

// A word at the beginning or end of a name specifies its side, see addin_sdfusion/muscles/mirror.py.
const SIDES = [
  /^(l|r|left|right)(?=[_\-. ])/i, /(?<=[_\-. ])(l|r|left|right)$/i, /^(left|right)(?=[A-Z0-9])|^(L|R)(?=[A-Z][a-z])/,
  /^(Left|Right)(?=[A-Z0-9])|(?<=[a-z0-9])(Left|Right|L|R)$|^(left|right)$/,
];
const OTHER_SIDE = { l: "r", r: "l", left: "right", right: "left" };

// Returns a name with left and right exchanged; null if it does not contain a side.
function otherSide(name) {
  const match = SIDES.map(pattern => pattern.exec(name)).find(Boolean);
  if (!match) return null;
  const [word] = match, other = OTHER_SIDE[word.toLowerCase()];
  const written = word === word.toUpperCase() ? other.toUpperCase() : word[0] === word[0].toUpperCase() ? other[0].toUpperCase() + other.slice(1) : other;
  return name.slice(0, match.index) + written + name.slice(match.index + word.length);
}

// Returns the name of a mirror image that no item has.
function mirroredName(items, name) {
  const other = otherSide(name) ?? `${name}_mirrored`;
  return items.some(item => item.name === other) ? freeName(items, other) : other;
}

class Mirror {
  // `axis` is the index of the normal of the plane; `poses` and `otherSides` are by link.
  constructor(axis, poses, otherSides) { Object.assign(this, { axis, poses, otherSides }); }

  link(name) { return this.otherSides[name] ?? name; }
  flip(v) { return v.map((x, i) => i === this.axis ? -x : x); }
  point(point) {
    const link = this.link(point.link);
    return { ...point, link, position: tidy(toLink(this.poses[link], this.flip(toWorld(this.poses[point.link], point.position)))) };
  }

  // Returns the mirror image of a wrap surface; its y axis is reversed, because a reflection is not a rotation.
  surface(wrap, name) {
    const { link, position } = this.point(wrap), R = rotationOf(wrap.rpy);
    const column = (k, sign) => directionToLink(this.poses[link], this.flip(directionToWorld(this.poses[wrap.link], [R[k], R[3 + k], R[6 + k]]))).map(x => sign * x);
    return { ...wrap, name, link, position, rpy: rpyOf([column(0, 1), column(1, -1), column(2, 1)]) };
  }

  // Adds the mirror image of a muscle and of its wrap surfaces; returns its name.
  add(data, muscle) {
    const image = JSON.parse(JSON.stringify(muscle)), names = new Map();
    image.name = mirroredName(data.muscles, muscle.name);
    image.points = muscle.points.map(point => this.point(point));
    for (const wrap of image.wraps) {
      if (!names.has(wrap.surface)) names.set(wrap.surface, this.surfaceFor(data, data.wraps.find(one => one.name === wrap.surface)));
      wrap.surface = names.get(wrap.surface);
      wrap.side = -wrap.side || 0;
    }
    data.muscles.push(image);
    return image.name;
  }

  // Returns the name of the mirror image of a surface, which is added unless it exists.
  surfaceFor(data, wrap) {
    const otherName = otherSide(wrap.name), image = this.surface(wrap, otherName ?? wrap.name);
    const same = other => ["link", "shape", "position", "rpy", "radius", "half_axes", "length"].every(key => nearlySame(other[key], image[key]));
    const existing = data.wraps.find(other => same(other));
    if (existing) return existing.name;
    image.name = mirroredName(data.wraps, wrap.name);
    data.wraps.push(image);
    return image.name;
  }
}

const nearlySame = (a, b) => Array.isArray(a) && Array.isArray(b) ? a.every((x, i) => Math.abs(x - b[i]) < 1e-6) : a === b;

// Rounds numbers of a link frame to a micrometre, so that files are readable.
const tidy = numbers => numbers.map(x => Math.round(x * 1e6) / 1e6 || 0);

// Returns the rotation Rz(yaw) Ry(pitch) Rx(roll), row by row.
function rotationOf([roll, pitch, yaw]) {
  const [cr, sr, cp, sp, cy, sy] = [Math.cos(roll), Math.sin(roll), Math.cos(pitch), Math.sin(pitch), Math.cos(yaw), Math.sin(yaw)];
  return [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr, sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr, -sp, cp * sr, cp * cr];
}

// Returns roll, pitch, yaw of the rotation with axes x, y, z.
function rpyOf([x, y, z]) {
  const pitch = Math.asin(Math.max(-1, Math.min(1, -x[2])));
  if (Math.abs(x[2]) > 1 - 1e-9) return tidy([0, pitch, Math.atan2(-y[0], y[1])]);
  return tidy([Math.atan2(y[2], z[2]), pitch, Math.atan2(x[1], x[0])]);
}

// Returns roll, pitch, yaw whose z axis has a direction; the rotation from the old z axis is the smallest one.
function turnedTo(rpy, direction) {
  const R = rotationOf(rpy), z = unit(direction), column = k => [R[k], R[3 + k], R[6 + k]];
  let x = sum(column(0), z, -dot(column(0), z));
  if (Math.hypot(...x) < 1e-6) x = sum(column(1), z, -dot(column(1), z));
  x = unit(x);
  return rpyOf([x, cross(z, x), z]);
}
