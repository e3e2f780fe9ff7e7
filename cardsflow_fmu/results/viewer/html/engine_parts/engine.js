// Simulation of an experiment in steps, with drive modes, pulling, live changes and history.
// models/browser/pack.py defines the data.

const HISTORY_SECONDS = 20, SNAPSHOT_SECONDS = 0.01, HISTORY_BYTES = 2 ** 27;
const TARGET_RATE = 12; // in rad/s: a new target is approached with critical damping

class Engine {
  static async open(bytes) {
    const size = new DataView(bytes.buffer, bytes.byteOffset).getUint32(0, true);
    const header = JSON.parse(new TextDecoder().decode(bytes.subarray(4, 4 + size)));
    const contents = bytes.slice(4 + size + ((-4 - size) & 7));
    const part = ([at, length]) => contents.subarray(at, at + length);
    return new Engine(await Module.open(part(header.module)), header, part);
  }

  constructor(module, header, part) {
    Object.assign(this, { module, header, step: header.step });
    this.models = header.models.map(entry => new Model(module, entry, part(entry.file), part(entry.ports)));
    this.loops = Object.fromEntries(Object.entries(header.loops).map(([mode, entry]) =>
      [mode, new Loop(module, entry.models.map(k => this.models[k]), entry, part)]));
    this.plant = this.models[0];
    this.drawing = new Drawing(this.plant, header.drawing, part);
    this.changes = new Changes(this, part);
    this.analysis = new Analysis(this);
    this.columns = this.namesOfColumns();
    this.mode = Object.keys(this.loops)[0];
    this.reset();
  }

  get loop() { return this.loops[this.mode]; }
  get controller() { return this.loop.models.find(model => model.role === "controller"); }
  get time() { return this.k * this.step; }
  get modes() { return Object.keys(this.loops); }

  // Goes to the start of the experiment in the current mode; live changes stay.
  reset() {
    this.k = 0;
    this.pulled = null;
    this.history = [];
    const { models, values } = this.loop;
    models.forEach((model, i) => model.values.set(new Float64Array(values[i].buffer)));
    this.changes.write();
    for (const model of models.slice().reverse()) model.initialize(0);
    this.changes.openModels();
    this.holdTargets();
    this.isChanged = true;
  }

  // ------------------------------------------------------------------------------------- steps

  // Runs some steps. Throws an error with the message of the model that failed.
  run(count) {
    this.requireDynamics();
    const every = Math.max(1, Math.round(SNAPSHOT_SECONDS / this.step));
    while (count > 0) {
      if (this.isChanged || this.k % every === 0) this.remember();
      count -= this.runSome(Math.min(count, every - this.k % every));
    }
  }

  runSome(count) {
    const { loop } = this, isDriven = this.target || this.pulled;
    const asked = isDriven ? 1 : Math.min(count, Loop.MAX_STEPS);
    if (this.target) this.moveTarget();
    if (this.pulled) this.pullLink();
    const done = loop.run(this.step, this.k, asked);
    this.k += done;
    if (loop.failure) throw new Error(loop.failure);
    return done;
  }

  // ------------------------------------------------------------------------------------- modes

  setMode(mode) {
    if (!this.loops[mode]) throw new Error(this.header.missing[mode] || `unknown mode ${mode}`);
    const before = new Set(this.loop.models), { models, values } = this.loops[mode];
    const commands = this.plant.group("commands").slice(), motors = this.plant.group("torques").slice();
    const loads = new Float64Array(this.loops[mode].values[0].buffer);
    this.mode = mode;
    this.plant.values.set(loads.subarray(0, this.plant.entry.outputs[0]));
    this.plant.group("commands").set(commands);
    this.plant.group("torques").set(motors);
    models.forEach((model, i) => {
      if (before.has(model) && model.role !== "reference") return;
      model.values.set(new Float64Array(values[i].buffer));
    });
    this.changes.write();
    for (const model of models.slice().reverse())
      if (!before.has(model)) model.initialize(this.time);
    this.changes.openModels();
    this.holdTargets();
    this.isChanged = true;
  }

  requireDynamics() {
    if (this.mode === "pose") throw new Error("choose another drive mode: without dynamics, only the sliders move the robot");
  }

  // Moves the joints to positions, at rest.
  setPose(q) {
    const { plant } = this, state = plant.state();
    writePose(state, q);
    plant.setState(state);
    if (this.target) this.holdTargets();
    this.isChanged = true;
  }

  // Sets the targets of joints or task to the current state.
  holdTargets() {
    this.target = null;
    if (this.mode !== "joints" && this.mode !== "task") return;
    const now = this.plant.group(this.mode === "joints" ? "q" : "tasks").slice();
    this.target = { goal: now, x: now.slice(), v: new Float64Array(now.length) };
  }

  setTarget(values) {
    if (!this.target) throw new Error("this mode has no target");
    this.target.goal = Float64Array.from(values);
    this.isChanged = true;
  }

  // Moves the reference of the controller towards the target, critically damped.
  moveTarget() {
    const { goal, x, v } = this.target, w = TARGET_RATE, h = this.step, n = goal.length;
    const reference = this.controller.group("reference"), decay = Math.exp(-w * h);
    for (let i = 0; i < n; i++) {
      const error = x[i] - goal[i], rate = v[i] + w * error;
      reference[i] = x[i];
      reference[n + i] = v[i];
      reference[2 * n + i] = -w * w * error - 2 * w * v[i];
      x[i] = goal[i] + (error + rate * h) * decay;
      v[i] = (v[i] - w * rate * h) * decay;
    }
  }

  // Sets the commands of all muscles and joint motors, in the mode "muscles".
  setMuscles(values, torques = []) {
    const commands = this.plant.group("commands");
    this.header.commanded.forEach((muscle, i) => { commands[i] = values[muscle]; });
    this.plant.group("torques").set(torques);
    this.isChanged = true;
  }

  commands() {
    const byMuscle = new Float64Array(this.header.muscles.length), commands = this.plant.group("commands");
    this.header.commanded.forEach((muscle, i) => { byMuscle[muscle] = commands[i]; });
    return byMuscle;
  }

  // ------------------------------------------------------------------------------------- pulling

  // Pulls a point of a link, in its frame, with a spring to a target in the world, or with a constant force.
  pull(link, point, { target = null, stiffness = 100, damping = 0.05 * stiffness, force = null }) {
    const { frames, wrenched } = this.drawing;
    const at = wrenched.findIndex(other => frames[other] === frames[link]);
    if (at < 0) throw new Error(`${this.drawing.links[link]} cannot be pulled: it does not move, or its ` +
                                "name is also that of an end-effector point");
    this.pulled = { link, point, target, stiffness, damping, force, at, last: null };
    this.isChanged = true;
  }

  release() {
    if (!this.pulled) return;
    this.plant.group("wrenches").fill(0);
    this.pulled = null;
    this.isChanged = true;
  }

  pullLink() {
    const spring = this.pulled, place = pointAt(this.drawing.pose(spring.link), spring.point);
    const origin = this.drawing.pose(this.drawing.wrenched[spring.at]).subarray(9);
    const last = spring.last || place;
    spring.last = place;
    spring.place = place;
    spring.acting = spring.force || place.map((x, i) =>
      spring.stiffness * (spring.target[i] - x) - spring.damping * (x - last[i]) / this.step);
    const lever = place.map((x, i) => x - origin[i]), wrenches = this.plant.group("wrenches");
    wrenches.fill(0);
    wrenches.set([...spring.acting, ...cross3(lever, spring.acting)], 6 * spring.at);
  }

  // Changes a number of the running simulation by the key of `cardsflow run --set`; null: as in the experiment.
  // Returns the value in effect: a cable does not break before the present time, which a busy page shows late.
  change(key, value) {
    const isBreak = value !== null && key.startsWith("plant.break_time.");
    const now = isBreak ? Math.max(value, this.time) : value;
    this.changes.set(key, now);
    this.isChanged = true;
    return now;
  }

  // ------------------------------------------------------------------------------------- history

  // Returns everything that the next steps depend on.
  snapshot() {
    const copy = object => object && Object.fromEntries(Object.entries(object).map(([key, value]) =>
      [key, value && value.slice ? value.slice() : value]));
    return {
      k: this.k,
      mode: this.mode,
      target: copy(this.target),
      pulled: copy(this.pulled),
      changes: this.changes.all,
      models: this.models.map(model => ({ values: model.values.slice(), state: model.state() })),
    };
  }

  restore(snapshot) {
    const { k, mode, target, pulled, changes, models } = structuredClone(snapshot);
    if (JSON.stringify(changes) !== JSON.stringify(this.changes.all)) this.changes.replace(changes);
    Object.assign(this, { k, mode, target, pulled });
    models.forEach(({ values, state }, i) => {
      this.models[i].values.set(values);
      this.models[i].setState(state);
      this.models[i].values.set(values);
    });
    this.isChanged = false;
  }

  remember() {
    while (this.history.length && this.history.at(-1).k >= this.k) this.history.pop();
    const snapshot = this.snapshot();
    this.history.push(snapshot);
    const bytes = snapshot.models.reduce((sum, { values, state }) => sum + values.byteLength + state.length, 0);
    const oldest = this.k - Math.round(HISTORY_SECONDS / this.step);
    while (this.history.length > 1 && (this.history[1].k <= oldest || this.history.length * bytes > HISTORY_BYTES))
      this.history.shift();
    this.isChanged = false;
  }

  // Goes to a step within the history. Steps from there on replace the later history.
  goTo(k) {
    if (k < this.first || k > this.last) throw new Error("this step is no longer in the history");
    if (this.isChanged || this.history.at(-1).k < this.k) {
      if (this.k > this.history.at(-1).k || !this.history.length) this.remember();
    }
    this.restore(this.history.findLast(one => one.k <= k));
    while (this.k < k) this.runSome(k - this.k);
  }

  // Returns the state and everything that the user has changed, as bytes; `load` restores it.
  saved() {
    const text = JSON.stringify({ version: this.header.version, snapshot: this.snapshot() }, (key, value) =>
      ArrayBuffer.isView(value) ? { [value.constructor.name]: Array.from(value, x => Number.isFinite(x) ? x : String(x)) } : value);
    return new TextEncoder().encode(text);
  }

  load(bytes) {
    const kinds = { Float64Array, Uint8Array };
    const { version, snapshot } = JSON.parse(new TextDecoder().decode(bytes), (key, value) => {
      const [kind] = value && typeof value === "object" ? Object.keys(value) : [];
      return kinds[kind] ? kinds[kind].from(value[kind], Number) : value;
    });
    const sizes = snapshot.models.map(({ values }) => values.length);
    if (version !== this.header.version || sizes.join() !== this.models.map(model => model.count).join())
      throw new Error("this state is of another experiment or version");
    this.restore(snapshot);
    this.history = [];
    this.isChanged = true;
  }

  get first() { return this.history.length ? this.history[0].k : this.k; }
  get last() { return Math.max(this.k, this.history.length ? this.history.at(-1).k : 0); }

  // ------------------------------------------------------------------------------------- outputs

  // Lists the outputs of all models once, as `<role>.<name>`, with their places in each mode.
  namesOfColumns() {
    const columns = new Map();
    this.models.forEach((model, number) => {
      const [inputs, outputs] = model.entry.outputs;
      for (let i = inputs; i < inputs + outputs; i++) {
        const name = `${model.role}.${model.entry.names[i]}`;
        if (!columns.has(name)) columns.set(name, { name, unit: model.entry.units[i], places: new Map() });
        columns.get(name).places.set(model, i);
      }
    });
    return [...columns.values()];
  }

  values() {
    const views = new Map(this.loop.models.map(model => [model, model.values]));
    return Float64Array.from(this.columns, ({ places }) => {
      for (const [model, i] of places) if (views.has(model)) return views.get(model)[i];
      return NaN;
    });
  }

  // The core computes tensions if a muscle has a law; otherwise commands are tensions.
  tensions() {
    if (this.plant.group("tensions").length) return this.plant.array("tensions").slice();
    const scales = this.plant.array("tension_scale");
    return this.commands().map((command, i) => scales[i] * Math.max(command, 0));
  }

  // Returns which cables are broken.
  broken() { return Array.from(this.plant.array("tension_scale"), scale => scale === 0); }

  // Returns the time of the newest fault that the estimator has found, in s.
  faultTime() {
    const estimator = this.loop.models.find(model => model.role === "estimator"), report = estimator?.group("fault_report");
    return report?.length ? estimator.begin + report[1] : this.time;
  }

  status() {
    const report = this.controller ? this.controller.group("report") : [0, 0, 0, 0];
    const infeasible = report[2] !== 0, shortfall = infeasible ? this.analysis.shortfall() : null;
    return { infeasible, notConverged: report[3] !== 0, shortfall };
  }

  frame() {
    const { pulled } = this, lines = this.plant.lines();
    return {
      time: this.time,
      step: this.k,
      values: this.values(),
      q: this.plant.group("q").slice(),
      poses: this.drawing.allPoses().slice(),
      paths: lines.points,
      pathSizes: lines.sizes,
      tensions: this.tensions(),
      broken: this.broken(),
      faultTime: this.faultTime(),
      commands: this.commands(),
      motors: this.plant.group("torques").slice(),
      lengths: this.plant.group("lengths").slice(),
      jacobian: this.plant.array("jacobian").slice(),
      torques: this.analysis.torqueRange(),
      mode: this.mode,
      target: this.target && this.target.goal.slice(),
      pull: pulled && pulled.acting && { link: pulled.link, point: pulled.place, force: Array.from(pulled.acting) },
      status: this.status(),
      first: this.first,
      last: this.last,
    };
  }
}

// Writes joint positions, and zero velocities, into a state of the plant: ticks, q, qd, ...
function writePose(state, q) {
  const numbers = new Float64Array(state.buffer);
  numbers.set(q, 1);
  numbers.fill(0, 1 + q.length, 1 + 2 * q.length);
}

function pointAt(pose, point) {
  return [0, 1, 2].map(i => pose[9 + i] + dot3(pose.subarray(3 * i, 3 * i + 3), point));
}
