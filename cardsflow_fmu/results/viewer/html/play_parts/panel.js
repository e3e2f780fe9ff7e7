// Panel of a page that simulates: drive mode, targets, commands, live changes, table of muscles.

// Adds a slider; returns { set(value), input }.
function addSlider(into, name, unit, low, high, value, changed) {
  const label = element("label", into), title = element("span", label, { textContent: name, title: name });
  const input = element("input", label, { type: "range", min: low, max: high, step: "any", value, ariaLabel: name });
  const output = element("output", label), show = () => { output.textContent = `${short(input.valueAsNumber)} ${unit}`; };
  input.addEventListener("input", () => { show(); changed(input.valueAsNumber); });
  show();
  return { input, title, set: number => { if (document.activeElement !== input) { input.value = number; show(); } } };
}

const MODE_NAMES = { reference: "follow the reference", joints: "hold joint targets", task: "drag the end effector", muscles: "muscle commands" };

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
    Object.assign(this, { client, data, box, setup: client.setup });
    box.classList.add("play");
    this.status = element("div", null, { className: "status" });
    this.shown = element("details", box);
    element("summary", this.shown, { textContent: "Show" });
    this.addModes();
    this.targets = element("fieldset", this.box);
    this.addChanges();
    this.addMuscles();
    this.limit = element("div", this.muscles);
    this.scale = addScale(motion.ramp, this.setup.muscles, this.muscles);
    this.analysis = new PlayAnalysis(this);
    this.addFiles();
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
    this.modes[frame.mode].checked = true;
    this.targets.replaceChildren();
    this.sliders = [];
    const { coordinates, tasks, muscles } = this.setup, values = Array.from(frame.target || frame.commands);
    const send = () => this.do(frame.mode === "muscles" ? this.client.setMuscles(values) : this.client.setJoints(values));
    const add = (name, unit, low, high, i) =>
      this.sliders.push(addSlider(this.targets, name, unit, low, high, values[i], value => { values[i] = value; send(); }));
    this.values = values;
    if (frame.mode === "joints")
      coordinates.forEach(({ name, unit, lower, upper }, i) =>
        add(name, unit, finiteOr(lower, values[i] - 3), finiteOr(upper, values[i] + 3), i));
    if (frame.mode === "task") tasks.forEach(({ name, unit }, i) => add(name, unit, values[i] - 0.5, values[i] + 0.5, i));
    if (frame.mode === "muscles")
      muscles.forEach(({ name, unit, low, high }, i) => {
        if (this.setup.commanded.includes(i)) add(name, unit, finiteOr(low, 0), finiteOr(high, Math.max(100, 3 * values[i])), i);
      });
  }

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
    for (const textContent of ["name", "N", "command", "cut"]) element("th", head, { textContent });
    this.rows = this.setup.muscles.map(({ name }) => {
      const row = element("tr", table);
      element("td", row, { textContent: name, title: name });
      const tension = element("td", row), command = element("td", row);
      const cut = element("input", element("td", row), { type: "checkbox", ariaLabel: `cut ${name}` });
      cut.addEventListener("change", () => this.do(this.client.set(`plant.tension_scale.${name}`, cut.checked ? 0 : null)));
      return { row, tension, command };
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
    return ["cardsflow", "run", this.data.path, ...this.client.options(this.settings())].map(quote).join(" ");
  }

  show(frame) {
    if (frame.mode !== this.mode) this.showTargets(frame);
    if (frame.mode === "task" && frame.target) frame.target.forEach((x, i) => { this.values[i] = x; this.sliders[i].set(x); });
    this.rows.forEach(({ tension, command }, i) => {
      const { low, high } = this.setup.muscles[i], u = frame.commands[i];
      tension.textContent = short(frame.tensions[i]);
      command.textContent = short(u);
      command.className = u <= low || high !== null && u >= high ? "bound" : "";
      command.title = command.className && `at a limit (${short(finiteOr(low, -Infinity))} to ${high === null ? "unlimited" : short(high)})`;
    });
    if (this.box.open) this.analysis.show(frame);
    this.showStatus(frame);
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
      frame.behind > 0.05 ? `slower than real time: ${Math.round(100 * (1 - frame.behind))} %` : "");
    this.status.textContent = text;
    this.status.className = this.failure || infeasible ? "status bad" : "status";
  }
}
