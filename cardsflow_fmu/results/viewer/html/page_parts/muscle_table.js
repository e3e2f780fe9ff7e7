// Panels of an act: table of muscles, and plots of the selected muscles and the joints.

class ActPanel {
  constructor(into, act, clock, changed) {
    Object.assign(this, { act, clock, changed });
    this.selected = new Set();
    if (act.muscles.length) this.addTable(into);
    if (clock.seek) {
      const plots = element("details", into, { open: true, className: "plots" });
      element("summary", plots, { textContent: "Plots" });
      this.into = element("div", plots);
      this.addPlots();
    }
  }

  addTable(into) {
    const box = element("details", into, { className: "muscles", open: true });
    element("summary", box, { textContent: "Muscles" });
    const table = element("table", element("div", box)), head = element("tr", table);
    const has = key => this.act.muscles.some(m => this.act.signals[m[key]]);
    this.columns = [["force", "N", m => [m.tension, m.force]], ["command", "command", m => [m.command]], ["length", "m", m => [m.length]]]
      .filter(([key]) => has(key) || (key === "force" && has("tension")));
    element("th", head, { textContent: "name" });
    for (const [, textContent] of this.columns) element("th", head, { textContent });
    this.rows = this.act.muscles.map(muscle => {
      const row = element("tr", table), name = element("button", element("td", row), { textContent: muscle.name, title: muscle.name });
      name.addEventListener("click", () => this.select(muscle.name, row));
      return { muscle, row, cells: this.columns.map(() => element("td", row)) };
    });
  }

  select(name, row) {
    row.classList.toggle("selected", !this.selected.delete(name) && !!this.selected.add(name));
    if (this.into) this.addPlots();
    this.changed();
  }

  addPlots() {
    this.into.replaceChildren();
    const { end, seek } = this.clock;
    this.plots = plotsOf(this.act, this.selected).map(plot => new Plot(this.into, this.act, plot, end, seek));
  }

  show(now) {
    const { act } = this, [k, part] = frameAt(act.time, now);
    const value = names => names.map(name => valueAt(act, name, k, part)).find(x => x !== undefined);
    for (const { muscle, row, cells } of this.rows || []) {
      this.columns.forEach(([, , names], i) => {
        const x = value(names(muscle));
        setText(cells[i], x === undefined ? "" : short(x));
      });
      const force = value([muscle.force, muscle.tension]), { f_min: low, f_max: high } = muscle;
      const near = 1e-3 * Math.max(1, (high ?? low) - low);
      row.classList.toggle("bound", force !== undefined && (force <= low + near || (high !== null && force >= high - near)));
      row.title = row.classList.contains("bound") ? `at a force limit (${short(low)} to ${high === null ? "unlimited" : short(high)} N)` : "";
    }
    for (const plot of this.plots || []) plot.draw(now, k, part);
  }
}
