// Edit page: the robot, the document, the selection, and what the user does with them.

const NO_RESULT = { lengths: new Map(), paths: new Map(), arms: {}, torques: {}, findings: [], error: "" };

class Editor {
  constructor(motion, data, drawing, canvas) {
    const [act] = motion.acts, edited = ["muscles", "via points", "forces", "wrap surfaces"].map(name => motion.groups.indexOf(name));
    Object.assign(this, { data, canvas, poses: data.poses, pose: data.coordinates.map(({ value }) => value), selected: {}, mirrorAxis: 1, result: NO_RESULT });
    this.linkNames = ["world", ...Object.keys(data.poses).filter(name => name !== "world")];
    const still = act.shapes.filter(shape => !edited.includes(shape.group));
    for (const shape of still) if (data.links[shape.name]) fixShape(shape, data.links[shape.name], this.poses[data.links[shape.name]]);
    this.linkShapes = still.filter(shape => shape.link && act.shapes.indexOf(shape) >= 0 && motion.groups[shape.group] === "links");
    this.still = still;
    this.played = playAct({ ...act, shapes: still, time: [0], tensions: [] }, 0, 1, drawing);
    this.act = this.played.act;
    this.document = new EditDocument(data.document);
    this.server = new EditServer(data.token);
    this.shapesOf = new EditShapes(this, motion.groups, drawing);
    this.shapesOf.compose();
    this.document.onchange = () => this.changed();
    this.server.onresult = answer => this.receive(answer);
    this.redraw = () => {};
  }

  // Geometry

  worldOf({ link, position }) { return toWorld(this.poses[link] ?? this.poses.world, position); }
  localOf(link, place) { return tidy(toLink(this.poses[link], place)); }

  // Returns centre and axes of a wrap surface in the world.
  frameOf(wrap) {
    const T = this.poses[wrap.link] ?? this.poses.world, R = rotationOf(wrap.rpy);
    return { centre: toWorld(T, wrap.position), axes: [0, 1, 2].map(k => directionToWorld(T, [R[k], R[3 + k], R[6 + k]])) };
  }

  // Returns the evaluated path of a muscle; null before its evaluation.
  pathOf({ name, points }) {
    const path = this.result.paths.get(name);
    return path && path.length >= points.length ? path : null;
  }

  worldAxes() {
    return this.data.axes.map(({ name, link, child, position, direction }) =>
      ({ name, child, place: toWorld(this.poses[link], position), direction: directionToWorld(this.poses[link], direction) }));
  }

  uniforms() { return this.camera.uniforms(this.canvas.clientWidth / Math.max(this.canvas.clientHeight, 1)); }
  pixelOf(place) {
    const at = project(this.uniforms().view, place);
    return at && [at[0] * this.canvas.clientWidth, at[1] * this.canvas.clientHeight];
  }

  // Changes

  change(edit, key = null) {
    this.message = "";
    return this.document.change(edit, key);
  }

  endStep() { this.document.endStep(); }
  fail(message) { this.tell(message, true); }
  say(message) { this.tell(message, false); }
  tell(message, isFailure) {
    Object.assign(this, { message, isFailure });
    this.redraw();
  }

  // Updates everything after a change of the document.
  changed() {
    const { selected } = this, muscle = this.document.muscle(selected.muscle);
    if (!muscle) Object.assign(selected, { muscle: null, point: null });
    else if (selected.point !== null && !(selected.point < muscle.points.length)) selected.point = muscle.points.length ? muscle.points.length - 1 : null;
    if (!this.document.wrap(selected.wrap)) selected.wrap = null;
    if (this.drawing && !this.document.muscle(this.drawing.muscle)) this.drawing = null;
    this.evaluate();
    this.redraw();
  }

  evaluate() { this.server.evaluate(this.document.data, this.pose); }

  receive({ muscles = [], moment_arms = {}, torque_ranges = {}, poses, findings = [], error }) {
    this.result = {
      lengths: new Map(muscles.map(({ name, length }) => [name, length])), paths: new Map(muscles.map(({ name, path }) => [name, path])),
      arms: moment_arms, torques: torque_ranges, findings, error: error || "",
    };
    if (poses) this.setLinkPoses(poses);
    this.redraw();
  }

  setLinkPoses(poses) {
    this.poses = poses;
    for (const shape of this.still) if (shape.link) moveShape(shape, poses[shape.link]);
  }

  setJoint(i, value) { this.setPose(this.pose.map((old, k) => k === i ? value : old)); }
  setPose(pose) {
    this.pose = pose;
    this.evaluate();
    this.redraw();
  }

  select(selected) {
    const muscle = selected.muscle ?? (selected.wrap ? this.selected.muscle : null);
    this.selected = { muscle, point: selected.muscle && !selected.wrap ? selected.point ?? null : null, wrap: selected.wrap ?? null };
    if (this.drawing && muscle !== this.drawing.muscle) this.drawing = null;
    this.endStep();
    this.redraw();
  }

  // Modes: adding points to a muscle, placing a wrap surface

  instruction() {
    if (this.placing) return `Click where the ${this.placing} shall be; near a joint it snaps to the joint's axis.`;
    if (!this.drawing) return "";
    const muscle = this.document.muscle(this.drawing.muscle);
    return muscle && muscle.points.length ? "Click the next point, or a wrap surface to route over it. Enter or Done ends." : "Click the first point on a link.";
  }

  // Adds a muscle without points, with law and limits of the selected or last muscle.
  newMuscle() {
    const { muscles } = this.document.data, like = this.document.muscle(this.selected.muscle) ?? muscles.at(-1);
    const { law, parameters, f_min, f_max } = like ?? { law: "ideal", parameters: {}, f_min: 0, f_max: null };
    const muscle = { name: freeName(muscles, "muscle"), law, parameters: { ...parameters }, f_min, f_max, points: [], wraps: [] };
    this.placing = null;
    this.drawing = { muscle: muscle.name };
    this.selected = { muscle: muscle.name, point: null, wrap: null };
    this.change(data => { data.muscles.push(muscle); });
  }

  // Adds further points behind a point of a muscle.
  draw(muscle, after) {
    this.placing = null;
    this.drawing = { muscle: muscle.name };
    this.selected = { muscle: muscle.name, point: after >= 0 ? after : null, wrap: null };
    this.redraw();
  }

  endDrawing() {
    const muscle = this.drawing && this.document.muscle(this.drawing.muscle);
    this.drawing = null;
    this.setHint(null);
    if (!muscle) return;
    if (muscle.points.length) this.change(() => dropLooseWraps(muscle));
    else this.deleteMuscle();
    if (muscle.points.length === 1) this.fail(`${muscle.name} has 1 point; a muscle needs at least 2`);
    this.redraw();
  }

  place(shape) {
    this.drawing = null;
    this.placing = shape;
    this.message = "";
    this.redraw();
  }

  escape() {
    if (this.drawing) this.endDrawing();
    else if (this.placing) this.place(null);
    else this.select({});
    this.setHint(null);
  }

  hover(at, snaps) { this.setHint(this.drawing || this.placing ? placeAt(this, at, snaps) : null); }
  setHint(hint) {
    if (hint === this.hint || (!hint && !this.hint)) return;
    this.hint = hint;
    this.redraw();
  }

  mayDrag(handle) {
    if (this.placing) return false;
    return !this.drawing || (handle.kind === "point" && handle.muscle === this.drawing.muscle);
  }

  endDrag() {
    this.endStep();
    this.setHint(null);
  }

  click(at, snaps) {
    if (this.placing) this.addWrap(placeAt(this, at, snaps));
    else if (this.drawing) this.addPoint(at, snaps);
    else {
      const item = itemAt(this, at);
      if (item) this.select(item.muscle ? { muscle: item.muscle } : { wrap: item.wrap });
    }
  }

  addPoint(at, snaps) {
    const muscle = this.document.muscle(this.drawing.muscle), after = this.selected.point ?? -1, target = placeAt(this, at, snaps);
    const surface = itemAt(this, at), isNearer = surface?.wrap && !(target && !target.axis && this.depthOf(target.place) < surface.t);
    if (isNearer && muscle.points.length && !muscle.wraps.some(wrap => wrap.surface === surface.wrap && wrap.segment === after)) {
      this.change(() => addRoute(muscle, surface.wrap, after));
      this.say(`${muscle.name} passes over ${surface.wrap}; click the next point`);
      return;
    }
    if (!target) {
      this.fail("there is no link under the pointer; click the surface of a link");
      return;
    }
    this.selected.point = after + 1;
    this.change(() => insertPoint(muscle, after + 1, { link: target.link, position: this.localOf(target.link, target.place) }));
    this.redraw();
  }

  depthOf(place) { return Math.hypot(...sum(place, this.uniforms().eye, -1)); }

  // Surfaces

  addWrap(target) {
    if (!target) {
      this.fail("there is no link under the pointer; click the surface of a link");
      return;
    }
    const shape = this.placing, { link, axis } = target, radius = tidy([0.04 * this.act.reach])[0];
    const rpy = axis && shape !== "sphere" ? turnedTo([0, 0, 0], directionToLink(this.poses[link], axis.direction)) : [0, 0, 0];
    const wrap = { name: freeName(this.document.data.wraps, shape), link, shape, position: this.localOf(link, target.place), rpy, radius,
      length: shape === "cylinder" ? tidy([0.2 * this.act.reach])[0] : null, half_axes: shape === "ellipsoid" ? [radius, tidy([1.5 * radius])[0]] : null };
    this.placing = null;
    this.selected = { muscle: this.selected.muscle ?? null, point: null, wrap: wrap.name };
    this.setHint(null);
    this.change(data => { data.wraps.push(wrap); });
  }

  turnWrap(wrap, axis) {
    const direction = { x: [1, 0, 0], y: [0, 1, 0], z: [0, 0, 1] }[axis] ?? directionToLink(this.poses[wrap.link], this.worldAxes()[Number(axis)].direction);
    this.change(() => { wrap.rpy = turnedTo(wrap.rpy, direction); });
  }

  // Routes the selected muscle over a surface, between the points whose straight line is nearest to it.
  route(name) {
    const muscle = this.document.muscle(this.selected.muscle), { centre } = this.frameOf(this.document.wrap(name));
    const places = muscle.points.map(point => this.worldOf(point));
    const away = places.slice(1).map((place, i) => distanceToSegment(centre, places[i], place));
    this.change(() => addRoute(muscle, name, away.indexOf(Math.min(...away))));
  }

  // Attaches a point or surface to another link; its place in the world stays.
  attach(item, link) {
    this.change(() => {
      const place = this.worldOf(item), before = this.poses[item.link] ?? this.poses.world;
      if (item.rpy) {
        const { axes } = this.frameOf(item);
        item.rpy = rpyOf(axes.map(axis => directionToLink(this.poses[link], axis)));
      }
      if (before) Object.assign(item, { link, position: this.localOf(link, place) });
    });
  }

  // Muscles

  renameMuscle(muscle, name) {
    this.selected.muscle = name;
    if (this.drawing) this.drawing.muscle = name;
    this.change(() => { muscle.name = name; });
    return "";
  }

  renameWrap(name, other) {
    this.selected.wrap = other;
    this.change(data => renameWrap(data, name, other));
    return "";
  }

  // Sets the law of the selected muscle, with the default values of its parameters.
  setLaw(law) {
    const defaults = (this.data.laws[law] || []).filter(field => field.default !== null && field.default !== undefined);
    this.change(() => Object.assign(this.document.muscle(this.selected.muscle), { law, parameters: Object.fromEntries(defaults.map(field => [field.name, field.default])) }));
  }

  mirror() {
    const muscle = this.document.muscle(this.selected.muscle);
    if (!muscle) this.fail("select a muscle first");
    else {
      const image = new Mirror(this.mirrorAxis, this.data.poses, this.data.otherSides);
      this.change(data => { this.selected = { muscle: image.add(data, muscle), point: null, wrap: null }; });
    }
  }

  deleteSelected() {
    if (this.selected.wrap) this.deleteWrap();
    else if (this.selected.point !== null && this.selected.point !== undefined) this.deletePoint();
    else if (this.selected.muscle) this.deleteMuscle();
  }

  deletePoint() {
    const muscle = this.document.muscle(this.selected.muscle), { point } = this.selected;
    this.selected.point = point > 0 ? point - 1 : muscle.points.length > 1 ? 0 : null;
    this.change(() => deletePoint(muscle, point));
  }

  deleteMuscle() {
    const name = this.selected.muscle;
    this.change(data => { data.muscles = data.muscles.filter(muscle => muscle.name !== name); });
  }

  deleteWrap() {
    const name = this.selected.wrap;
    this.change(data => deleteWrap(data, name));
  }
}

function distanceToSegment(p, a, b) {
  const along = sum(b, a, -1), square = dot(along, along), part = square > 0 ? Math.max(0, Math.min(1, dot(sum(p, a, -1), along) / square)) : 0;
  return Math.hypot(...sum(p, sum(a, along, part), -1));
}
