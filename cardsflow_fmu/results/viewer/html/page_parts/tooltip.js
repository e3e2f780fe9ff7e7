// Names and values under the pointer.

const HIT = 9; // in pixels: maximum distance between the pointer and a thing

// Returns the distance between a point and a segment in the window, in pixels.
function toSegment([x, y], [ax, ay], [bx, by]) {
  const dx = bx - ax, dy = by - ay, square = dx * dx + dy * dy;
  const part = square > 0 ? Math.max(0, Math.min(1, ((x - ax) * dx + (y - ay) * dy) / square)) : 0;
  return Math.hypot(x - ax - part * dx, y - ay - part * dy);
}

// Returns the shape under the pointer, or null; muscles come first because they are thin.
function shapeAt(shapes, shown, view, box, pointer) {
  let best = null, nearest = HIT;
  for (const shape of shapes) {
    if (!shown.has(shape.group) || !["Line", "Sphere", "Capsule", "Cylinder", "Arrow"].includes(shape.kind)) continue;
    const points = shape.points.rows > 1 ? shape.now : shape.points.numbers, placed = [];
    if (points.length > 600) continue;
    for (let i = 0; i < points.length; i += 3) {
      const place = project(view, points.subarray(i, i + 3));
      if (!place) break;
      placed.push([place[0] * box.clientWidth + box.offsetLeft, place[1] * box.clientHeight]);
    }
    for (let i = 0; i < placed.length; i++) {
      const away = toSegment(pointer, placed[Math.max(i - 1, 0)], placed[i]) + (shape.kind === "Line" ? 0 : 3);
      if (away < nearest) [best, nearest] = [shape, away];
    }
  }
  return best;
}

// Returns name and values of a shape at a time, such as `biceps: 41.3 N, 0.312 m`.
function describe(shape, act, valueOf) {
  const key = shape.name.slice(shape.name.indexOf("/") + 1), group = shape.name.slice(0, shape.name.indexOf("/"));
  const muscle = act.muscles.find(({ name }) => name === key || (group !== "muscles" && key.startsWith(`${name}/`)));
  if (muscle && ["muscles", "via points", "forces"].includes(group)) {
    const force = valueOf(muscle.tension) ?? valueOf(muscle.force), length = valueOf(muscle.length);
    const parts = [force !== undefined && `${short(force)} N`, length !== undefined && `${short(length)} m`].filter(Boolean);
    return parts.length ? `${muscle.name}: ${parts.join(", ")}` : muscle.name;
  }
  if (group === "links") {
    const joint = key.startsWith("joint ") && act.joints.find(({ name }) => key === `joint ${name}`);
    const value = joint && valueOf(joint.actual);
    return joint && value !== undefined ? `${joint.name}: ${short(value)} ${joint.unit}` : key.replace(/\/(\d+|hull)$/, "");
  }
  return key;
}

// Returns a function that shows the text of the thing under the pointer.
function addTooltip() {
  const tip = element("div", document.body, { className: "label tip", hidden: true });
  return (text, [x, y]) => {
    tip.hidden = !text;
    if (!text) return;
    tip.textContent = text;
    tip.style.transform = `translate(${Math.max(0, Math.min(x + 14, innerWidth - tip.offsetWidth - 4))}px, ${Math.max(0, y - 30)}px)`;
  };
}
