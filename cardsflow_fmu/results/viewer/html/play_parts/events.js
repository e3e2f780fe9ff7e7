// Detected faults and decisions of a running simulation.

class PlayEvents {
  constructor({ columns, reports, step }) {
    const { parts, kinds, decisions } = reports, speed = columns.findIndex(({ name }) => name === "controller.reference_speed");
    Object.assign(this, { all: [], step });
    this.watched = columns.flatMap(({ name }, column) => {
      const [, signal, part] = /^estimator\.(\w+)\.(.+)$/.exec(name) || [];
      if (parts[signal])
        return [{ column, timeOf: frame => Math.min(frame.faultTime, frame.time), textOf: k => `${parts[signal]} ${part}: ${kinds[k].replaceAll("_", " ")}` }];
      if (name !== "controller.reaction") return [];
      const percent = ({ values }) => values[speed] > 0 && values[speed] < 1 ? ` to ${Math.round(100 * values[speed])} %` : "";
      return [{ column, timeOf: frame => frame.time, textOf: (k, frame) => `decision: ${decisions[k]}${percent(frame)}` }];
    });
  }

  // Adds new events of a frame, and removes events that are no longer in the history.
  update(frame) {
    this.all = this.all.filter(({ time }) => time <= frame.last * this.step);
    this.shown = this.all.filter(({ time }) => time <= frame.time);
    for (const { column, timeOf, textOf } of this.watched) {
      const value = frame.values[column] || 0, known = this.shown.findLast(event => event.column === column);
      if (!value || known?.value === value) continue;
      const time = timeOf(frame);
      this.all.push({ time, column, value, text: `${time.toFixed(3)} s ${textOf(value, frame)}` });
    }
    this.all.sort((a, b) => a.time - b.time);
    this.shown = this.all.filter(({ time }) => time <= frame.time);
  }
}
