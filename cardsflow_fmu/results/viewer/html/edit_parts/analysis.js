// Pose of the joints with torque ranges, moment arms over the range of a joint, and the findings of `cardsflow check`.

class EditAnalysis {
  constructor(editor, arms, rest) {
    this.editor = editor;
    this.addArms(arms);
    this.addJoints(rest);
    const { body } = addSection(rest, "Check");
    this.findings = body;
  }

  addArms(into) {
    this.arms = addSection(into, "Moment arms");
    this.warning = element("p", this.arms.body, { className: "bound" });
    this.canvas = element("canvas", this.arms.body, { className: "curves", ariaLabel: "moment arms over joint positions" });
    this.range = element("div", this.arms.body, { className: "ends" });
    this.legend = element("div", this.arms.body, { className: "plot-values" });
  }

  addJoints(into) {
    const { field, body } = addSection(into, "Joints"), { editor } = this, { coordinates } = editor.data;
    field.hidden = !coordinates.length;
    if (!editor.server.exists) element("p", body, { textContent: NO_SERVER });
    this.joints = coordinates.map(({ name, unit, lower, upper, value }, i) => {
      const wide = unit === "rad" ? Math.PI : 1;
      const slider = addSlider(body, name, unit, lower ?? value - wide, upper ?? value + wide, value, q => editor.setJoint(i, q));
      slider.input.disabled = !editor.server.exists;
      return { name, slider, torque: element("small", body, { className: "torque" }) };
    });
    if (editor.server.exists) addButton(body, "Initial pose", () => editor.setPose(coordinates.map(({ value }) => value)));
  }

  show() {
    const { result, pose, data } = this.editor;
    this.joints.forEach(({ name, slider, torque }, i) => {
      slider.set(pose[i]);
      const range = result.torques[name], unit = data.coordinates[i].unit === "rad" ? "N·m" : "N";
      torque.textContent = range ? `muscles: ${torqueText(range[0], "−∞")} … ${torqueText(range[1], "∞")} ${unit}` : "";
    });
    this.showArms();
    this.showFindings();
  }

  showArms() {
    const { selected, result, pose, data } = this.editor, found = Object.entries(result.arms[selected.muscle] || {});
    const units = new Map(data.coordinates.map(({ name, unit }) => [name, unit]));
    const curves = found.filter(([, { values: [, r] }]) => r.some(x => Math.abs(x) > 1e-9)).slice(0, SERIES.length)
      .map(([joint, { values: [x, y], sign_change }], i) => ({ joint, x, y, colour: SERIES[i], changes: sign_change, marks: sign_change ? zerosOf(x, y) : [] }));
    this.arms.field.hidden = !this.editor.server.exists || !selected.muscle;
    this.canvas.hidden = this.range.hidden = !curves.length;
    const changing = curves.filter(({ changes }) => changes);
    const cause = this.editor.document.muscle(selected.muscle)?.wraps.length ? "usually the wrong side of a wrap" : "a wrap surface at the joint avoids this";
    const where = ({ joint, marks }) => `${joint}${marks.length ? ` at ${marks.map(short).join(", ")} ${units.get(joint) ?? ""}` : ""}`;
    this.warning.textContent = changing.length ? `The moment arm changes sign about ${changing.map(where).join(" and ")}: ${cause}.` : "";
    this.arms.legend.textContent = selected.muscle ? `Moment arms of ${selected.muscle}` : "Moment arms";
    this.legend.replaceChildren();
    if (!curves.length) this.legend.textContent = result.paths.has(selected.muscle) ? "none: the muscle crosses no joint" : "not evaluated, see Check";
    curves.forEach(({ joint, x, y, colour }) => {
      const item = element("span", this.legend), i = data.coordinates.findIndex(({ name }) => name === joint);
      element("i", item).style.background = colour;
      item.append(`${joint} `);
      element("output", item, { textContent: `${short(valueOn(x, y, pose[i]))} ${units.get(joint) === "rad" ? "m" : ""}` });
    });
    if (!curves.length) return;
    drawCurves(this.canvas, curves, curves.length === 1 ? pose[data.coordinates.findIndex(({ name }) => name === curves[0].joint)] : undefined);
    const all = curves.flatMap(({ x }) => x), ends = [Math.min(...all), Math.max(...all)];
    this.range.textContent = `${short(ends[0])} … ${short(ends[1])} ${units.get(curves[0].joint) ?? ""}`;
  }

  showFindings() {
    const { result, server } = this.editor, lines = result.error ? [result.error, ...result.findings] : result.findings;
    const text = JSON.stringify([lines, server.exists]);
    if (text === this.shown) return;
    this.shown = text;
    this.findings.replaceChildren();
    if (!server.exists) element("p", this.findings, { textContent: NO_SERVER });
    else if (!lines.length) element("p", this.findings, { textContent: "no errors or warnings" });
    for (const line of lines) element("p", this.findings, { textContent: line, className: /^error|^warning/.test(line) || line === result.error ? "bound" : "" });
  }
}

const NO_SERVER = "Lengths, moment arms, checks and poses need `cardsflow edit`.";
const torqueText = (x, infinite) => x === null || Math.abs(x) > 1e300 ? infinite : short(x);

// Returns where a curve crosses zero.
function zerosOf(x, y) {
  const zeros = [];
  for (let i = 1; i < x.length; i++) if (y[i - 1] * y[i] < 0) zeros.push(x[i - 1] + (x[i] - x[i - 1]) * y[i - 1] / (y[i - 1] - y[i]));
  return zeros.slice(0, 3);
}

// Returns the value of a curve, interpolated.
function valueOn(x, y, at) {
  const after = x.findIndex(value => value >= at), i = after < 0 ? x.length - 1 : Math.max(1, after), fraction = (at - x[i - 1]) / (x[i] - x[i - 1] || 1);
  return y[i - 1] + fraction * (y[i] - y[i - 1]);
}
