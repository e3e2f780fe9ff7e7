// Panel of a page that simulates: drive mode, targets, commands, live changes, table of muscles.

const MODE_NAMES = { reference: "follow the reference", joints: "hold joint targets", task: "drag the end effector", muscles: "muscle and motor commands",
  pose: "set joint positions" };

const EVENT_SECONDS = 3; // for which the bar shows a fault or decision

// Adds the legend of a colour scale from the smallest f_min to the largest tension up to now.
function addScale(ramp, muscles, into) {
  const scale = { low: Math.min(...muscles.map(muscle => muscle.f_min)), high: -Infinity };
  const legend = element("div", muscles.length ? into : null, { className: "legend", textContent: "tension, up to the largest one" });
  element("i", legend).style.background = `linear-gradient(90deg, ${ramp.map(colour => `rgb(${colour})`)})`;
  const row = element("span", legend), ends = [element("span", row), element("span", row)];
  scale.include = tensions => {
    const high = Math.max(scale.high, ...tensions);
    if (high === scale.high) return;
    scale.high = high;
    [scale.low, high].forEach((value, i) => { ends[i].textContent = `${short(value)} N`; });
  };
  return scale;
}

class PlayPanel {
  constructor(client, data, motion, box) {
    Object.assign(this, { client, data, box, setup: client.setup, reach: motion.acts[0].reach });
    box.classList.add("play");
    this.status = element("div", null, { className: "status" });
    this.slow = "";
    this.events = new PlayEvents(this.setup);
    this.isStill = this.setup.modes.length === 1; // a robot without dynamics
    this.shown = element("details", box);
    element("summary", this.shown, { textContent: "Show" });
    this.faults = element("fieldset", box, { className: "faults" });
    if (!this.isStill) this.addModes();
    this.targets = element("fieldset", this.box, { className: "targets" });
    if (!this.isStill) this.addChanges();
    this.addMuscles();
    this.limit = element("div", this.muscles);
    if (!this.isStill) this.scale = addScale(motion.ramp, this.setup.muscles, this.muscles);
    this.analysis = new PlayAnalysis(this);
    if (!this.isStill) this.addFiles();
  }

  // Shows the message of a failed call, until the next call succeeds.
  async do(promise) {
    try {
      const result = await promise;
      this.failure = "";
      return result;
    } catch (error) {
      this.failure = error.message;
    } finally {
      this.showStatus();
    }
    return undefined;
  }

  addModes() {
    const field = element("fieldset", this.box);
    element("legend", field, { textContent: "Drive" });
    this.modes = {};
    for (const mode of Object.keys(MODE_NAMES)) {
      const label = element("label", field), possible = this.setup.modes.includes(mode);
      const input = element("input", label, { type: "radio", name: "mode", value: mode, disabled: !possible });
      element("span", label, { textContent: MODE_NAMES[mode] });
      if (!possible) label.title = this.setup.missing[mode];
      input.addEventListener("change", () => this.do(this.client.setMode(mode)));
      this.modes[mode] = input;
    }
  }

  // Shows the sliders of a mode; called when the mode has changed.
  showTargets(frame) {
    this.mode = frame.mode;
    if (this.modes) this.modes[frame.mode].checked = true;
    this.targets.replaceChildren();
    if (this.isStill) element("legend", this.targets, { textContent: "Joint positions" });
    this.sliders = [];
    const { client } = this, { coordinates, tasks, muscles, motors } = this.setup;
    const values = this.values = Array.from(this.targetOf(frame) || frame.commands), torques = Array.from(frame.motors);
    const send = {
      joints: () => client.setTarget(values), task: () => client.setTarget(values),
      muscles: () => client.setMuscles(values, torques), pose: () => client.setPose(values),
    }[frame.mode];
    const add = ({ name, unit }, low, high, i, list = values) =>
      this.sliders.push(addSlider(this.targets, name, unit, low, high, list[i], value => { list[i] = value; this.do(send()); }));
    if (frame.mode === "joints" || frame.mode === "pose")
      coordinates.forEach((c, i) => {
        const reach = c.unit === "m" ? this.reach : 3;
        add(c, finiteOr(c.lower, values[i] - reach), finiteOr(c.upper, values[i] + reach), i);
      });
    if (frame.mode === "task") tasks.forEach((task, i) => add(task, values[i] - 0.5, values[i] + 0.5, i));
    if (frame.mode !== "muscles") return;
    for (const i of this.setup.commanded)
      add(muscles[i], finiteOr(muscles[i].low, 0), finiteOr(muscles[i].high, Math.max(100, 3 * values[i])), i);
    motors.forEach((motor, i) => add(motor, finiteOr(motor.low, -100), finiteOr(motor.high, 100), i, torques));
  }

  // Returns the positions that the sliders of a mode set, or null.
  targetOf({ mode, q, target }) { return mode === "pose" ? q : target; }

  addChanges() {
    const field = element("fieldset", this.box), { gravity } = this.setup;
    element("legend", field, { textContent: "Change" });
    const label = element("label", field), on = element("input", label, { type: "checkbox", checked: true, name: "gravity" });
    element("span", label, { textContent: "gravity" });
    on.addEventListener("change", () => this.do(this.client.set("robot.gravity", on.checked ? null : [0, 0, 0])));
    const scale = (name, key, high) => addSlider(field, name, "x", 0.2, high, 1, value => this.do(this.setAll(key, value)));
    scale("mass", "mass", 3);
    if (this.setup.hasFriction) scale("cable friction", "friction", 5);
    if (this.setup.hasSensors) addSlider(field, "sensor noise", "x", 0, 10, 1, value => this.do(this.client.set("noise", value)));
    for (const gain of ["kp", "kd"])
      addSlider(field, gain, "x", 0.1, 4, 1, value => this.do(this.setGains(gain, value)));
  }

  async setAll(kind, value) {
    const names = kind === "mass" ? this.setup.links : this.setup.muscles.map(muscle => muscle.name);
    const factor = value === 1 ? null : value;
    for (const name of names) await this.client.set(`plant.${kind}_scale.${name}`, factor);
  }

  async setGains(gain, factor) {
    for (const { name, value } of this.setup.gains)
      if (name.startsWith(`${gain}.`)) await this.client.set(`controller.${name}`, factor === 1 ? null : factor * value);
  }

  addMuscles() {
    const field = this.muscles = element("fieldset", this.box, { className: "muscles" });
    element("legend", field, { textContent: "Muscles" });
    const table = element("table", element("div", field));
    const head = element("tr", table);
    for (const textContent of ["name", ...(this.isStill ? ["m", "moment arm"] : ["N", "command", "m", "cut"])])
      element("th", head, { textContent });
    this.rows = this.setup.muscles.map(({ name }) => {
      const row = element("tr", table), cell = () => element("td", row);
      Object.assign(cell(), { textContent: name, title: name });
      if (this.isStill) return { row, length: cell(), arm: cell() };
      const cells = { row, tension: cell(), command: cell(), length: cell() };
      const cut = cells.cut = element("input", cell(), { type: "checkbox", ariaLabel: `cut ${name}` });
      const now = () => Math.max(this.client.frame.time, this.setup.step); // 0 would be never
      cut.addEventListener("change", () => this.do(this.client.set(`plant.break_time.${name}`, cut.checked ? now() : null)));
      return cells;
    });
  }

  addFiles() {
    const field = element("fieldset", this.box);
    const button = (textContent, act) => element("button", field, { textContent }).addEventListener("click", act);
    button("Copy command", () => this.do(navigator.clipboard.writeText(this.command())));
    button("Save state", async () => {
      const state = await this.do(this.client.getState());
      if (!state) return;
      save(new Blob([state]), "state.json");
    });
    button("Download experiment", () => this.do(this.download()));
    const file = element("input", field, { type: "file", accept: ".json", hidden: true });
    button("Load state", () => file.click());
    file.addEventListener("change", async () => {
      if (file.files[0]) await this.do(this.client.setState(new Uint8Array(await file.files[0].arrayBuffer())));
      file.value = "";
    });
  }

  // Returns the live changes, without gains of the controllers of other drive modes.
  settings() {
    const names = new Set(gainNames(this.data, this.setup)), isGain = /^controller\.k[pd]\.(.+)$/;
    return Object.fromEntries(Object.entries(this.client.changes()).filter(([key]) => !isGain.test(key) || names.has(isGain.exec(key)[1])));
  }

  // Downloads the files of the experiment with the live changes.
  async download() {
    const { noise, ...changes } = this.settings();
    const archive = await archiveOf(document.getElementById("files").textContent, this.data, this.setup, changes);
    save(archive, `${this.data.name}.zip`);
    if (noise !== undefined) throw new Error("downloaded without the factor of the sensor noise, which is not a setting");
  }

  // Returns the command that runs the experiment with the live changes.
  command() {
    const quote = word => /^[\w./=-]+$/.test(word) ? word : `'${word.replaceAll("'", "'\\''")}'`;
    const { robotFile, path, changes } = this.data, joined = words => words.map(quote).join(" ");
    const first = robotFile ? `${joined(["cardsflow", "init", robotFile, "-o", path])} && ` : "";
    return first + joined(["cardsflow", "run", path, ...changes.flatMap(change => ["--set", change]), ...this.client.options(this.settings())]);
  }

  // Shows numbers and plots of a frame; `showStatus` shows the rest.
  show(frame) {
    if (frame.mode !== this.mode) this.showTargets(frame);
    const target = this.targetOf(frame);
    if (target) target.forEach((x, i) => { this.values[i] = x; this.sliders[i].set(x); });
    if (!this.box.open) return;
    this.showEvents(frame);
    this.showMuscles(frame);
    this.analysis.show(frame);
  }

  // Lists detected faults and decisions.
  showEvents(frame) {
    const texts = this.events.shown.map(({ text }) => text);
    if (this.listed === texts.join()) return;
    this.listed = texts.join();
    this.faults.replaceChildren();
    if (texts.length) element("legend", this.faults, { textContent: "Faults" });
    for (const textContent of texts) element("div", this.faults, { textContent });
  }

  showMuscles(frame) {
    const { coordinates, muscles } = this.setup, { joint } = this.analysis;
    this.rows.forEach(({ tension, command, length, arm, cut }, i) => {
      setText(length, short(frame.lengths[i]));
      if (arm) {
        setText(arm, short(-frame.jacobian[coordinates.length * i + joint]));
        return;
      }
      cut.checked = frame.broken[i];
      const { low, high } = muscles[i], u = frame.commands[i];
      setText(tension, short(frame.tensions[i]));
      setText(command, short(u));
      command.className = u <= low || high !== null && u >= high ? "bound" : "";
      command.title = command.className && `at a limit (${short(finiteOr(low, -Infinity))} to ${high === null ? "unlimited" : short(high)})`;
    });
  }

  // Returns which joint lacks torque, and in which direction.
  lack(shortfall) {
    if (!shortfall) return "the muscles cannot produce the required motion";
    const { name, value, unit } = shortfall;
    return `the muscles cannot produce the required motion: ${name} lacks ${value > 0 ? "+" : "−"}${short(Math.abs(value))} ${unit}`;
  }

  showStatus(frame = this.client.frame) {
    const { infeasible, notConverged } = frame.status;
    const text = this.failure || (infeasible ? this.lack(frame.status.shortfall) :
      notConverged ? "the solver did not converge" :
      this.events.shown?.findLast(({ time }) => time > frame.time - EVENT_SECONDS)?.text || (frame.behind > 0.05 ? `slower than real time: ${Math.round(100 * (1 - frame.behind))} %` : this.slow));
    setText(this.status, text);
    this.status.className = this.failure || infeasible ? "status bad" : "status";
  }
}
