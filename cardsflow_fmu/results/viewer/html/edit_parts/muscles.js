// Muscles in the edit panel: list, properties, via points, and routing over wrap surfaces.

const SIDE_NAMES = [["0", "shorter"], ["1", "side +"], ["-1", "side −"]];

class MuscleSection {
  constructor(editor, into, law) {
    Object.assign(this, { editor, law });
    const list = addSection(into, "Muscles");
    list.field.className = "muscles";
    this.list = list.body;
    this.box = element("div", into);
  }

  get muscle() { return this.editor.document.muscle(this.editor.selected.muscle); }

  change(edit, key = null) { this.editor.change(() => edit(this.muscle), key); }

  show() {
    this.showList();
    const { muscle } = this, { data } = this.editor.document, { point } = this.editor.selected;
    const key = muscle ? JSON.stringify([muscle.name, muscle.law, muscle.points.length, point, muscle.wraps.map(wrap => wrap.surface), data.wraps.length]) : "";
    if (key !== this.key) {
      this.key = key;
      this.box.replaceChildren();
      this.law.replaceChildren();
      this.shows = [];
      if (muscle) this.addMuscle(muscle);
    }
    for (const show of this.shows) show();
  }

  showList() {
    const { muscles } = this.editor.document.data, key = JSON.stringify([muscles.map(muscle => muscle.name)]);
    if (key !== this.listKey) {
      this.listKey = key;
      this.list.replaceChildren();
      if (!muscles.length) element("p", this.list, { textContent: "No muscles yet. Press “New muscle”, then click points on the links." });
      const table = element("table", this.list);
      this.rows = muscles.map(({ name }) => {
        const row = element("tr", table, { className: "choice" });
        element("td", row, { textContent: name, title: name });
        row.addEventListener("click", () => this.editor.select({ muscle: name, point: null }));
        return { name, row, points: element("td", row), length: element("td", row) };
      });
    }
    for (const { name, row, points, length } of this.rows) {
      const found = this.editor.result.lengths.get(name);
      row.classList.toggle("selected", name === this.editor.selected.muscle);
      points.textContent = `${this.editor.document.muscle(name).points.length} points`;
      length.textContent = found === undefined ? "" : `${found.toFixed(4)} m`;
    }
  }

  addMuscle(muscle) {
    const { body } = addSection(this.box, "Selected muscle"), { editor } = this;
    const rename = name => nameProblem(editor.document.data.muscles, this.muscle, name) || editor.renameMuscle(this.muscle, name);
    this.shows.push(addName(body, { title: "name of the muscle", get: () => this.muscle.name, set: rename, fail: text => editor.fail(text) }));
    const buttons = element("div", body, { className: "buttons" });
    addButton(buttons, "Add points", () => editor.draw(this.muscle, editor.selected.point ?? this.muscle.points.length - 1), "click further points behind the selected one");
    addButton(buttons, "Mirror", () => editor.mirror(), "add the mirror image in the chosen plane");
    this.shows.push(addChoice(buttons, { title: "mirror plane", options: () => [["0", "x → −x"], ["1", "y → −y"], ["2", "z → −z"]],
      get: () => editor.mirrorAxis, set: value => { editor.mirrorAxis = Number(value); } }));
    addButton(buttons, "Delete", () => editor.deleteMuscle(), "delete the muscle");
    this.addPoints(body, muscle);
    this.addRoutes(body, muscle);
    this.addLaw(muscle);
  }

  addPoints(into, muscle) {
    const table = element("table", into, { className: "points" }), { editor } = this;
    muscle.points.forEach((_, i) => {
      const isCurrent = i === editor.selected.point, row = element("tr", table, { className: isCurrent ? "choice selected" : "choice" });
      element("td", row, { textContent: i + 1 });
      const link = element("td", row), place = element("td", row);
      row.addEventListener("click", () => editor.select({ muscle: muscle.name, point: i }));
      this.shows.push(() => {
        const point = this.muscle.points[i];
        link.textContent = link.title = point.link;
        place.textContent = point.position.map(x => x.toFixed(3)).join(", ");
      });
      if (isCurrent) this.addPoint(element("td", element("tr", table), { colSpan: 3 }), i);
    });
  }

  addPoint(into, i) {
    const { editor } = this, point = () => this.muscle.points[i];
    const done = () => editor.endStep();
    this.shows.push(addVector(into, ["x", "y", "z"], { unit: "m", title: "position of the point", done,
      get: () => point().position, set: position => this.change(muscle => { muscle.points[i].position = position; }, `point ${i}`) }));
    const row = element("div", into, { className: "buttons" });
    this.shows.push(addChoice(row, { name: "on", title: "link of the point", options: () => editor.linkNames, get: () => point().link, set: link => editor.attach(point(), link) }));
    const move = by => this.change(muscle => { swapPoints(muscle, i, i + by); editor.selected.point = i + by; });
    const up = addButton(row, "↑", () => move(-1), "earlier"), down = addButton(row, "↓", () => move(1), "later");
    up.disabled = i === 0;
    down.disabled = i === this.muscle.points.length - 1;
    addButton(row, "Delete point", () => editor.deletePoint(), "key Delete");
  }

  addRoutes(into, muscle) {
    const { editor } = this;
    muscle.wraps.forEach((_, k) => {
      const row = element("div", into, { className: "buttons route" }), wrap = () => this.muscle.wraps[k];
      const edit = (name, value) => this.change(one => { one.wraps[k][name] = value; one.wraps.sort((a, b) => a.segment - b.segment); });
      const name = element("button", row, { type: "button", className: "link", textContent: `over ${wrap().surface}` });
      name.addEventListener("click", () => editor.select({ muscle: muscle.name, wrap: wrap().surface }));
      const segments = () => this.muscle.points.slice(1).map((point, i) => [String(i), `${i + 1}–${i + 2}`]);
      this.shows.push(addChoice(row, { title: "between points", options: segments, get: () => wrap().segment, set: value => edit("segment", Number(value)) }));
      if (!wrap().options)
        this.shows.push(addChoice(row, { title: "side of the surface", options: () => SIDE_NAMES, get: () => wrap().side ?? 0, set: value => edit("side", Number(value)) }));
      addButton(row, "×", () => this.change(one => { one.wraps.splice(k, 1); }), `do not route over ${wrap().surface}`);
    });
    const free = editor.document.data.wraps.map(wrap => wrap.name).filter(name => !muscle.wraps.some(wrap => wrap.surface === name));
    if (!free.length || muscle.points.length < 2) return;
    const row = element("div", into, { className: "buttons" });
    this.shows.push(addChoice(row, { title: "route over a surface", options: () => [["", "Route over …"], ...free], get: () => "", set: name => { if (name) editor.route(name); } }));
  }

  addLaw(muscle) {
    const { editor } = this, { body } = addSection(this.law, "Muscle law"), { laws } = editor.data;
    const done = () => editor.endStep();
    this.shows.push(addChoice(body, { name: "law", title: "muscle law", get: () => this.muscle.law, set: law => editor.setLaw(law),
      options: () => [...new Set([...Object.keys(laws), muscle.law])] }));
    const limit = (key, empty) => this.shows.push(addNumber(body, { name: key, unit: "N", title: key === "f_min" ? "minimum force" : "maximum force", empty, done,
      get: () => this.muscle[key], set: value => this.change(one => { one[key] = value; }, key), valid: value => value !== null && value < 0 ? "must not be negative" : "" }));
    limit("f_min");
    limit("f_max", null);
    for (const field of laws[muscle.law] || []) this.addParameter(body, field, done);
  }

  addParameter(into, { name, unit, lower, upper, description, default: usual }, done) {
    const range = lower === null && upper === null ? "" : ` (${lower ?? "−∞"} to ${upper ?? "∞"})`;
    const valid = value => value !== null && (value < (lower ?? -Infinity) || value > (upper ?? Infinity)) ? `must be in the range${range}` : "";
    this.shows.push(addNumber(into, { name, unit, title: `${name}${description ? `: ${description}` : ""}${range}`, done, valid, empty: usual === undefined ? undefined : null,
      get: () => this.muscle.parameters[name] ?? null,
      set: value => this.change(one => { if (value === null) delete one.parameters[name]; else one.parameters[name] = value; }, name) }));
  }
}
