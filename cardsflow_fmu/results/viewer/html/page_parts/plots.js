// Plots of recorded signals over time, with a cursor at the time of the replay.

const SERIES = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9"]; // differ for colour-blind people, too
const MAX_SERIES = 6;
const PANEL_MILLISECONDS = 100; // between updates of numbers and plots

const signal = (act, name) => act.signals[name];

// Returns the values of a signal at frame k, between frames.
const valueAt = (act, name, k, part) => signal(act, name) ? rowAt(signal(act, name), k, part, [0])[0] : undefined;

function largest(table) {
  let most = 0;
  for (const x of table.numbers) if (Math.abs(x) > most) most = Math.abs(x);
  return most;
}

// Returns the plots of an act: titles with lists of { name, table }.
function plotsOf(act, selected) {
  const plots = [], add = (title, series) => { if (series.length) plots.push({ title, series: series.slice(0, MAX_SERIES), omitted: Math.max(0, series.length - MAX_SERIES) }); };
  const force = muscle => signal(act, muscle.tension) || signal(act, muscle.force);
  const muscles = act.muscles.filter(m => force(m) && (!selected.size || selected.has(m.name)));
  const drawn = muscles.map(m => ({ name: m.name, table: force(m) })).sort((a, b) => largest(b.table) - largest(a.table));
  add("muscle force [N]", drawn);
  for (const [unit, title] of [["rad", "joint position [rad]"], ["m", "joint position [m]"]])
    add(title, act.joints.filter(j => j.unit === unit && signal(act, j.actual)).map(j => ({ name: j.name, table: signal(act, j.actual) })));
  const tracked = [...act.joints, ...act.tasks].filter(x => signal(act, x.actual) && signal(act, x.desired));
  for (const unit of ["rad", "m"])
    add(`tracking error [${unit}]`, tracked.filter(x => x.unit === unit).map(x => ({ name: x.name, table: difference(signal(act, x.desired), signal(act, x.actual)) })));
  return plots;
}

function difference(a, b) {
  const rows = Math.max(a.rows, b.rows), numbers = new Float32Array(rows);
  for (let k = 0; k < rows; k++) numbers[k] = a.numbers[Math.min(k, a.rows - 1)] - b.numbers[Math.min(k, b.rows - 1)];
  return { rows, columns: 1, numbers };
}

class Plot {
  constructor(into, act, { title, series, omitted }, end, seek) {
    Object.assign(this, { act, series, end });
    const box = element("div", into, { className: "plot" });
    element("div", box, { className: "plot-title", textContent: omitted ? `${title}, ${omitted} more: select muscles` : title });
    this.canvas = element("canvas", box, { ariaLabel: title });
    const values = element("div", box, { className: "plot-values" });
    this.outputs = series.map(({ name }, i) => {
      const item = element("span", values);
      element("i", item).style.background = SERIES[i];
      item.append(`${name} `);
      return element("output", item);
    });
    const limits = series.map(({ table }) => [Math.min(...sampled(table)), Math.max(...sampled(table))]);
    this.low = Math.min(...limits.map(([low]) => low));
    this.high = Math.max(...limits.map(([, high]) => high));
    if (!(this.high > this.low)) [this.low, this.high] = [this.low - 0.5, this.low + 0.5];
    const at = event => seek((event.offsetX / this.canvas.clientWidth) * end);
    this.canvas.addEventListener("pointerdown", event => { this.canvas.setPointerCapture(event.pointerId); at(event); });
    this.canvas.addEventListener("pointermove", event => { if (event.buttons) at(event); });
  }

  draw(now, k, part) {
    const { canvas } = this, width = canvas.clientWidth, height = canvas.clientHeight;
    if (!width) return;
    this.drawCurves(width, height);
    this.series.forEach(({ table }, i) => setText(this.outputs[i], short(rowAt(table, k, part, [0])[0])));
    const pen = canvas.getContext("2d"), ratio = canvas.width / width;
    pen.clearRect(0, 0, canvas.width, canvas.height);
    pen.drawImage(this.curves, 0, 0);
    pen.fillStyle = this.colour;
    pen.fillRect(now / this.end * canvas.width, 0, ratio, canvas.height);
  }

  // Draws the curves without the cursor into another canvas, again only if the size or the colours change.
  drawCurves(width, height) {
    const { canvas } = this, ratio = window.devicePixelRatio || 1, key = `${width} ${height} ${ratio} ${DARK.matches}`;
    if (this.key === key) return;
    Object.assign(canvas, { width: Math.round(width * ratio), height: Math.round(height * ratio) });
    this.curves = Object.assign(document.createElement("canvas"), { width: canvas.width, height: canvas.height });
    this.key = key;
    this.colour = getComputedStyle(canvas).color;
    const pen = this.curves.getContext("2d");
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    const y = value => 4 + (height - 8) * (this.high - value) / (this.high - this.low);
    this.series.forEach(({ table }, i) => {
      pen.strokeStyle = SERIES[i];
      pen.lineWidth = 1.4;
      pen.beginPath();
      for (let x = 0; x <= width; x++) pen.lineTo(x, y(rowAt(table, ...frameAt(this.act.time, x / width * this.end), [0])[0]));
      pen.stroke();
    });
    pen.fillStyle = this.colour;
    for (const { time } of this.act.events) pen.fillRect(time / this.end * width, 0, 0.5, height);
    pen.font = "10px system-ui, sans-serif";
    pen.fillText(short(this.high), 2, 10);
    pen.fillText(short(this.low), 2, height - 3);
  }
}

// Returns at most 2000 finite values of a table.
function sampled({ numbers }) {
  const step = Math.ceil(numbers.length / 2000), values = [];
  for (let i = 0; i < numbers.length; i += step) if (Number.isFinite(numbers[i])) values.push(numbers[i]);
  return values.length ? values : [0];
}
