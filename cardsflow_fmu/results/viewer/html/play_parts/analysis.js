// Joints with their torque ranges; moment arms and recent values of the selected muscle and joint.

const PLOT_SECONDS = 10;

class PlayAnalysis {
  constructor(panel) {
    const { client, setup, box } = panel;
    Object.assign(this, { panel, client, setup, muscle: 0, joint: 0, times: [], tensions: [], angles: [], desired: [] });
    this.columns = new Map(setup.columns.map(({ name }, i) => [name, i]));
    const field = element("fieldset", box, { className: "muscles" });
    element("legend", field, { textContent: "Joints" });
    const table = element("table", element("div", field)), head = element("tr", table);
    for (const textContent of ["name", "position", "torque range"]) element("th", head, { textContent });
    this.rows = setup.coordinates.map(({ name }, i) => {
      const row = element("tr", table, { className: "choice" });
      element("td", row, { textContent: name, title: name });
      row.addEventListener("click", () => this.select(this.muscle, i));
      return { row, position: element("td", row), range: element("td", row) };
    });
    panel.rows.forEach(({ row }, i) => {
      row.classList.add("choice");
      row.addEventListener("click", () => this.select(i, this.joint));
    });
    this.muscleRows = panel.rows.map(({ row }) => row);
    this.limit = panel.limit;
    this.isStill = panel.isStill;
    const plots = element("fieldset", box);
    element("legend", plots, { textContent: "Plots" });
    const plot = () => ({ title: element("div", plots), canvas: element("canvas", plots, { className: "curves" }) });
    this.arms = plot();
    if (this.isStill) this.length = plot();
    else [this.tension, this.angle] = [plot(), plot()];
    this.select(0, 0);
  }

  async select(muscle, joint) {
    Object.assign(this, { muscle, joint, tensions: [], angles: [], desired: [], times: [] });
    this.muscleRows.forEach((row, i) => row.classList.toggle("selected", i === muscle));
    this.rows.forEach(({ row }, i) => row.classList.toggle("selected", i === joint));
    this.curve = null;
    if (this.setup.muscles.length && !this.isStill) this.showLimit(muscle);
    await this.computeCurve();
  }

  // Computes moment arms and lengths at the current pose, one request at a time.
  async computeCurve() {
    if (!this.setup.muscles.length || !this.setup.coordinates.length || this.isComputing) return;
    this.isComputing = true;
    const { muscle, joint } = this, q = this.client.frame.q.slice();
    const curve = await this.client.call("momentArms", muscle, joint);
    this.isComputing = false;
    if (muscle === this.muscle && joint === this.joint) this.curve = { ...curve, at: q };
    else await this.computeCurve();
  }

  // Returns whether another joint has moved since the curve was computed.
  isOld({ q }) { return !this.curve || q.some((x, i) => i !== this.joint && Math.abs(x - this.curve.at[i]) > 1e-3); }

  // Shows the slider of f_max of the selected muscle.
  showLimit(muscle) {
    const { name, f_min, f_max } = this.setup.muscles[muscle], key = `muscles.${name}.f_max`, ofRobot = finiteOr(f_max, null);
    this.limit.replaceChildren();
    if (ofRobot === null) return;
    const set = value => this.panel.do(this.client.set(key, value === ofRobot ? null : value));
    const { input } = addSlider(this.limit, "f_max", "N", f_min, 2 * ofRobot, this.client.changes()[key] ?? ofRobot, set);
    input.ariaLabel = input.title = `f_max of ${name}`;
  }

  show(frame) {
    const { muscles, coordinates } = this.setup;
    this.rows.forEach(({ position, range }, i) => {
      const [low, high] = frame.torques.subarray(2 * i, 2 * i + 2);
      setText(position, short(frame.q[i]));
      const bound = x => Math.abs(x) < 1e300 ? short(x) : x > 0 ? "∞" : "−∞"; // forces without a limit
      setText(range, `${bound(low)} … ${bound(high)}`);
    });
    if (!muscles.length || !coordinates.length) return;
    const muscle = muscles[this.muscle], joint = coordinates[this.joint];
    if (this.isOld(frame)) this.computeCurve();
    if (this.curve) {
      const { q, arms, lengths } = this.curve, isLimited = joint.lower !== null && joint.upper !== null;
      const changes = isLimited && Math.min(...arms) < 0 && Math.max(...arms) > 0;
      this.arms.title.textContent = `moment arm of ${muscle.name} about ${joint.name}${changes ? ": changes sign" : ""}`;
      this.arms.title.className = changes ? "bound" : "";
      drawCurves(this.arms.canvas, [{ x: q, y: arms, colour: SERIES[0] }], frame.q[this.joint]);
      if (this.length) {
        this.length.title.textContent = `length of ${muscle.name} over ${joint.name}: ${short(frame.lengths[this.muscle])} m`;
        drawCurves(this.length.canvas, [{ x: q, y: lengths, colour: SERIES[0] }], frame.q[this.joint]);
      }
    }
    if (this.isStill) return;
    this.record(frame, joint.name);
    this.tension.title.textContent = `tension of ${muscle.name}: ${short(frame.tensions[this.muscle])} N`;
    drawCurves(this.tension.canvas, [{ x: this.times, y: this.tensions, colour: SERIES[0] }]);
    this.angle.title.textContent = `position of ${joint.name}: ${short(frame.q[this.joint])} ${joint.unit}`;
    drawCurves(this.angle.canvas, [
      { x: this.times, y: this.desired, colour: SERIES[2] }, { x: this.times, y: this.angles, colour: SERIES[0] }]);
  }

  // Adds the values of a frame; going back removes the later ones.
  record(frame, joint) {
    const lists = [this.times, this.tensions, this.angles, this.desired];
    while (this.times.length && this.times.at(-1) >= frame.time) lists.forEach(list => list.pop());
    while (this.times.length && this.times[0] < frame.time - PLOT_SECONDS) lists.forEach(list => list.shift());
    const desired = frame.mode === "joints" ? frame.target[this.joint] : frame.values[this.columns.get(`reference.q_d.${joint}`)];
    [frame.time, frame.tensions[this.muscle], frame.q[this.joint], desired ?? NaN].forEach((value, i) => lists[i].push(value));
  }
}
