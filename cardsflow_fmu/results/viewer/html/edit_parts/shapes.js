// Shapes of muscles, via points, wrap surfaces and their handles.

const MUSCLE = [0, 114, 178], SELECTED = [222, 120, 0], POINT = [40, 46, 56], SURFACE = [110, 190, 150], HINT = [204, 80, 150];
const AXIS = [120, 130, 145];
const SPHERE_MESH = unitSphere(24, 12);

function unitSphere(around, rings) {
  const { vertices, faces } = ball(around, rings), points = new Float32Array(vertices.length / 7 * 3);
  for (let i = 0; i < points.length / 3; i++) points.set(vertices.subarray(7 * i, 7 * i + 3), 3 * i);
  return { vertices: { numbers: points }, faces: { numbers: faces } };
}

// Returns a shape at points of the world.
function shapeOf(kind, group, name, points, colour, radius, more = {}) {
  const shape = { kind, group, name, radius, ...more };
  setPoints(shape, Float32Array.from(points.flat()), colour);
  return shape;
}

class EditShapes {
  constructor(editor, groups, drawing) {
    Object.assign(this, { editor, reach: editor.act.reach, drawing });
    this.group = name => groups.indexOf(name);
  }

  // Returns shapes and handles of the document. A handle is { place, kind, ... } in the world.
  compose() {
    const { editor } = this, { muscles, wraps } = editor.document.data;
    this.shapes = [];
    this.handles = [];
    for (const wrap of wraps) this.addWrap(wrap, wrap.name === editor.selected.wrap);
    for (const muscle of muscles) this.addMuscle(muscle, muscle.name === editor.selected.muscle);
    if (editor.hint) this.addHint(editor.hint);
    return this.shapes;
  }

  put(...shape) { this.shapes.push(shapeOf(...shape)); }

  addMuscle(muscle, isSelected) {
    const { editor, reach } = this, places = muscle.points.map(point => editor.worldOf(point));
    const path = editor.pathOf(muscle) ?? places, colour = isSelected ? SELECTED : MUSCLE;
    if (path.length > 1) this.put("Line", this.group("muscles"), `muscles/${muscle.name}`, path, colour, 0.004 * reach, { muscle: muscle.name });
    places.forEach((place, index) => {
      const isCurrent = isSelected && index === editor.selected.point;
      const radius = (isCurrent ? 0.013 : isSelected ? 0.01 : 0.007) * reach;
      this.put("Sphere", this.group("via points"), `via points/${muscle.name}/${index}`, [place], isCurrent ? SELECTED : POINT, radius, { onTop: isSelected });
      this.handles.push({ kind: "point", muscle: muscle.name, index, place, isSelected });
    });
  }

  addWrap(wrap, isSelected) {
    const { reach } = this, group = this.group("wrap surfaces"), name = `wrap surfaces/${wrap.name}`;
    const { centre, axes } = this.editor.frameOf(wrap), colour = isSelected ? SELECTED : SURFACE;
    const more = { wrap: wrap.name, opacity: isSelected ? 0.6 : 0.45 };
    if (wrap.shape === "cylinder") {
      const half = drawnLength(wrap, reach) / 2;
      this.put("Cylinder", group, name, [sum(centre, axes[2], -half), sum(centre, axes[2], half)], colour, wrap.radius, more);
    } else if (wrap.shape === "sphere") this.put("Sphere", group, name, [centre], colour, wrap.radius, more);
    else {
      this.mesh ||= this.drawing.mesh(SPHERE_MESH.vertices.numbers, SPHERE_MESH.faces.numbers);
      const tips = radiiOf(wrap).map((radius, i) => sum(centre, axes[i], radius));
      this.put("MeshShape", group, name, [centre, ...tips], colour, 0, { ...more, ...SPHERE_MESH, lever: 1, mesh: this.mesh });
    }
    if (isSelected) this.addWrapHandles(wrap, centre, axes);
    else this.handles.push({ kind: "wrap", wrap: wrap.name, part: "centre", place: centre, isSelected: false });
  }

  addWrapHandles(wrap, centre, axes) {
    const group = this.group("via points"), radii = radiiOf(wrap);
    const add = (part, place, axis) => {
      this.handles.push({ kind: "wrap", wrap: wrap.name, part, place, isSelected: true });
      if (axis) this.put("Line", group, `wrap handles/${part} line`, [centre, place], AXIS, 0.002 * this.reach, { onTop: true });
      this.put("Sphere", group, `wrap handles/${part}`, [place], axis ? SELECTED : POINT, 0.011 * this.reach, { onTop: true });
    };
    add("centre", centre, false);
    radii.forEach((radius, i) => { if (radius !== null) add(["x", "y", "z"][i], sum(centre, axes[i], radius), true); });
    if (wrap.shape === "cylinder") add("axis", sum(centre, axes[2], drawnLength(wrap, this.reach) / 2 + 0.03 * this.reach), true);
  }

  addHint({ place, axis }) {
    const group = this.group("via points");
    if (axis) this.put("Line", group, "hint axis", [-1, 1].map(sign => sum(axis.place, axis.direction, sign * 0.12 * this.reach)), HINT, 0.003 * this.reach, { onTop: true });
    this.put("Sphere", group, "hint", [place], HINT, 0.008 * this.reach, { onTop: true });
  }
}

// Returns the radii along x, y, z of a wrap surface that handles change; null without a handle.
function radiiOf(wrap) {
  return wrap.shape === "ellipsoid" ? [wrap.radius, ...wrap.half_axes] : [wrap.radius, null, null];
}

// Returns the drawn length of a cylinder, which may be infinite, as in scene/wrap_surfaces.py.
const drawnLength = (wrap, reach) => Math.min(wrap.length ?? Infinity, Math.max(4 * wrap.radius, 0.1 * reach));
