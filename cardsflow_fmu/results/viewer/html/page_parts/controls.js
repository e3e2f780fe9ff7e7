// Titles, switches, legend, and the control bar with play button, time slider and speed.

function element(tag, into, properties = {}) {
  const created = Object.assign(document.createElement(tag), properties);
  into?.append(created);
  return created;
}

const DARK = matchMedia("(prefers-color-scheme: dark)");

// Sets a text only if it differs, since each change costs a new layout.
function setText(into, text) {
  if (into.shown !== text) into.textContent = into.shown = text;
}

const short = x => Number.isFinite(x) ? Number(x.toPrecision(4)).toString() : "-";

function addTitle(act, into) {
  const title = element("div", into, { className: "title" });
  element("b", title, { textContent: act.title });
  for (const note of act.notes) {
    const line = element("span", title, { textContent: note, title: note });
    line.addEventListener("click", () => line.classList.toggle("open"));
  }
}

// Adds the panel of a page, which is closed at first in a narrow window.
function addPanel(title) {
  const panel = element("details", document.body, { className: "panel", open: innerWidth > 700 });
  element("summary", panel, { textContent: title });
  return panel;
}

// Adds one switch for each group with shapes, and the legends; returns the set of visible groups.
function addSwitches(motion, panel, changed) {
  const used = new Set(motion.acts.flatMap(act => act.shapes.map(shape => shape.group))), shown = new Set();
  motion.groups.forEach((name, group) => {
    if (!used.has(group)) return;
    const checked = !motion.hidden.includes(name);
    if (checked) shown.add(group);
    const label = element("label", panel), box = element("input", label, { type: "checkbox", checked, name });
    label.append(` ${name}`);
    box.addEventListener("change", () => { shown[box.checked ? "add" : "delete"](group); changed(); });
  });
  addLegend(motion, panel);
  addArrowLegend(motion, panel);
  return shown;
}

function addLegend(motion, panel) {
  const ranges = new Map(motion.acts.flatMap(act => act.tensions).map(range => [range.join(), range]));
  if (!ranges.size) return;
  const legend = element("div", panel, { className: "legend", textContent: "tension" });
  const colours = motion.ramp.map(colour => `rgb(${colour})`).join();
  element("i", legend).style.background = `linear-gradient(90deg, ${colours})`;
  for (const [low, high] of [...ranges.values()].slice(0, 6)) {
    const row = element("span", legend);
    element("span", row, { textContent: `${short(low)} N` });
    element("span", row, { textContent: `${short(high)} N` });
  }
}

// Adds the meaning of arrows, and the value of the longest arrow of each kind.
function addArrowLegend(motion, panel) {
  motion.acts.forEach((act, i) => {
    for (const { name, colour, longest, unit } of act.arrows) {
      const row = element("div", panel, { className: "arrow" });
      element("i", row).style.background = `rgb(${colour})`;
      row.append(`${name}${motion.acts.length > 1 ? ` ${i + 1}` : ""}: longest arrow ${short(longest)} ${unit}`);
    }
  });
}

// Adds buttons for views of the scene, which also have keys.
function addViews(camera, panel, changed) {
  const row = element("div", null, { className: "views" });
  panel.querySelector("summary").after(row);
  for (const [name, key] of [["front", "f"], ["side", "s"], ["top", "t"], ["fit", "0"]]) {
    const show = () => { camera.show(name); changed(); };
    element("button", row, { textContent: name, title: `key ${key}`, name: `view-${name}` }).addEventListener("click", show);
    addEventListener("keydown", event => { if (event.key === key && event.target === document.body && !event.ctrlKey && !event.metaKey) show(); });
  }
}

// Returns a function that shows marks of events [{ time, text }] above a slider between two times; a click goes there.
function addMarks(slider, seek) {
  const line = element("div", null, { className: "line" });
  slider.before(line);
  line.append(slider);
  let shown = "", marks = [];
  return (events, low, high) => {
    const key = events.map(({ text }) => text).join("\n");
    if (key !== shown) {
      for (const mark of marks) mark.remove();
      marks = events.map(({ time, text }) => {
        const mark = element("button", line, { className: "mark", title: text, ariaLabel: text });
        mark.addEventListener("click", () => { seek(time); mark.blur(); });
        return mark;
      });
      shown = key;
    }
    events.forEach(({ time }, i) => {
      marks[i].hidden = !(time >= low && time <= high && high > low);
      marks[i].style.left = `${100 * (time - low) / (high - low)}%`;
    });
  };
}

// Returns the clock { now, playing }, which `tick(seconds)` advances. A motion also has a control bar.
function addClock(end, changed, events = []) {
  const clock = { now: 0, playing: false, speed: 1, tick() {} };
  if (!(end > 0)) return clock;
  const bar = element("div", document.body, { className: "bar" });
  const button = element("button", bar, { ariaLabel: "play" });
  const slider = element("input", bar, { type: "range", min: 0, max: end, step: "any", ariaLabel: "time" });
  const output = element("output", bar);
  const speed = element("select", bar, { ariaLabel: "speed" });
  clock.status = element("div", bar, { className: "status" });
  for (const factor of [0.1, 0.25, 0.5, 1, 2, 4]) element("option", speed, { value: factor, textContent: `${factor} x`, selected: factor === 1 });
  const show = () => {
    button.textContent = clock.playing ? "❚❚" : "▶";
    slider.value = clock.now;
    output.textContent = `${clock.now.toFixed(2)} of ${end.toFixed(2)} s`;
    changed();
  };
  const play = () => {
    clock.playing = !clock.playing;
    if (clock.playing && clock.now >= end) clock.now = 0;
    show();
  };
  const seek = time => { clock.now = Math.max(0, Math.min(end, time)); show(); };
  Object.assign(clock, { end, seek });
  addMarks(slider, seek)(events, 0, end);
  clock.tick = seconds => {
    if (!clock.playing) return;
    clock.playing = clock.now + clock.speed * seconds < end;
    seek(clock.now + clock.speed * seconds);
  };
  button.addEventListener("click", play);
  slider.addEventListener("input", () => { clock.playing = false; seek(slider.valueAsNumber); });
  speed.addEventListener("change", () => { clock.speed = Number(speed.value); });
  addEventListener("keydown", event => {
    if (event.target !== document.body) return;
    if (event.key === " ") play();
    if (event.key === "ArrowRight") seek(clock.now + end / 100);
    if (event.key === "ArrowLeft") seek(clock.now - end / 100);
  });
  seek(Number(new URLSearchParams(location.hash.slice(1)).get("t")) || 0);
  return clock;
}

const SLOW_SECONDS = 1 / 40; // between frames

// Measures the time between frames that move; `tick(seconds, isMoving)` returns a text if it is long.
class FrameRate {
  constructor() { this.mean = 0; }

  tick(seconds, isMoving) {
    this.mean = isMoving ? this.mean + 0.05 * (Math.min(seconds, 0.5) - this.mean) : 0;
    return this.mean > SLOW_SECONDS ? `drawing cannot keep up: ${Math.round(1 / this.mean)} frames per second` : "";
  }
}
