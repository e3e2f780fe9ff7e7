// Wrap surfaces in the edit panel.

class WrapSection {
  constructor(editor, into) {
    this.editor = editor;
    this.box = element("div", into);
  }

  get wrap() { return this.editor.document.wrap(this.editor.selected.wrap); }

  show() {
    const { wrap } = this, names = this.editor.document.data.wraps.map(one => one.name);
    const key = JSON.stringify([names, wrap && [wrap.name, wrap.shape]]);
    if (key !== this.key) {
      this.key = key;
      this.box.replaceChildren();
      this.shows = [];
      if (names.length) this.addList(names);
      if (wrap) this.addWrap();
    }
    for (const show of this.shows) show();
  }

  addList(names) {
    const { field, body } = addSection(this.box, "Wrap surfaces");
    field.className = "muscles";
    const table = element("table", body);
    for (const name of names) {
      const row = element("tr", table, { className: "choice" });
      element("td", row, { textContent: name, title: name });
      const cell = element("td", row);
      row.addEventListener("click", () => this.editor.select({ wrap: name }));
      this.shows.push(() => {
        const { shape, link } = this.editor.document.wrap(name);
        row.classList.toggle("selected", name === this.editor.selected.wrap);
        cell.textContent = cell.title = `${shape} on ${link}`;
      });
    }
  }

  addWrap() {
    const { editor } = this, { body } = addSection(this.box, "Selected wrap surface"), done = () => editor.endStep();
    const set = (name, value) => editor.change(() => { this.wrap[name] = value; }, name);
    const positive = value => value !== null && !(value > 0) ? "must be positive" : "";
    const rename = name => nameProblem(editor.document.data.wraps, this.wrap, name) || editor.renameWrap(this.wrap.name, name);
    this.shows.push(addName(body, { title: "name of the wrap surface", get: () => this.wrap.name, set: rename, fail: text => editor.fail(text) }));
    const row = element("div", body, { className: "buttons" });
    this.shows.push(addChoice(row, { name: "on", title: "link of the wrap surface", options: () => editor.linkNames, get: () => this.wrap.link, set: link => editor.attach(this.wrap, link) }));
    addButton(row, "Delete", () => editor.deleteWrap(), "delete the wrap surface");
    this.shows.push(addVector(body, ["x", "y", "z"], { unit: "m", title: "position of the surface", done, get: () => this.wrap.position, set: value => set("position", value) }));
    if (this.wrap.shape !== "sphere") this.addAxis(body, set, done);
    const number = (name, title, get, change, more = {}) =>
      this.shows.push(addNumber(body, { name, unit: "m", title, done, valid: positive, get, set: change, ...more }));
    const isEllipsoid = this.wrap.shape === "ellipsoid";
    number(isEllipsoid ? "half axis x" : "radius", "radius", () => this.wrap.radius, value => set("radius", value));
    if (this.wrap.shape === "cylinder") number("length", "length of the cylinder", () => this.wrap.length, value => set("length", value), { empty: null });
    if (isEllipsoid) ["y", "z"].forEach((axis, i) => number(`half axis ${axis}`, `half axis ${axis}`, () => this.wrap.half_axes[i],
      value => set("half_axes", this.wrap.half_axes.map((old, k) => k === i ? value : old))));
  }

  addAxis(into, set, done) {
    const { editor } = this, titles = "rotation of the surface";
    this.shows.push(addVector(into, ["roll", "pitch", "yaw"], { unit: "rad", title: titles, done, get: () => this.wrap.rpy, set: value => set("rpy", value) }));
    const axes = () => [["", "Turn its z axis to …"], ...[..."xyz"].map(axis => [axis, `${axis} axis of the link`]), ...editor.worldAxes().map(({ name }, i) => [String(i), `axis of ${name}`])];
    this.shows.push(addChoice(into, { title: "turn the z axis of the surface", options: axes, get: () => "", set: value => { if (value) editor.turnWrap(this.wrap, value); } }));
  }
}
