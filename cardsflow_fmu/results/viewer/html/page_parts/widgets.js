// Slider, curves, help and download, for pages in which a user changes something.

// Adds a slider; returns { set(value), input }.
function addSlider(into, name, unit, low, high, value, changed) {
  const label = element("label", into), title = element("span", label, { textContent: name, title: name });
  const input = element("input", label, { type: "range", min: low, max: high, step: "any", value, ariaLabel: name });
  const output = element("output", label), show = () => { output.textContent = `${short(input.valueAsNumber)} ${unit}`; };
  input.addEventListener("input", () => { show(); changed(input.valueAsNumber); });
  show();
  return { input, title, set: number => { if (document.activeElement !== input) { input.value = number; show(); } } };
}

// Draws curves [{ x, y, colour, marks }] with common axes, and rings at zeros `marks`.
function drawCurves(canvas, curves, marker) {
  const context = canvas.getContext("2d"), ratio = devicePixelRatio || 1;
  const width = canvas.width = canvas.clientWidth * ratio, height = canvas.height = canvas.clientHeight * ratio;
  const all = name => curves.flatMap(curve => curve[name]).filter(Number.isFinite);
  const xs = all("x"), ys = all("y");
  if (!xs.length) return;
  const range = values => values.reduce(([a, b], v) => [Math.min(a, v), Math.max(b, v)], [Infinity, -Infinity]);
  const [left, right] = range(xs), [low, high] = range(ys), tall = high - low || Math.abs(high) || 1;
  const X = x => (x - left) / (right - left || 1) * width, Y = y => height - (0.1 + 0.8 * (y - low) / tall) * height;
  const line = (x, y, colour, thick) => {
    context.strokeStyle = colour;
    context.lineWidth = thick * ratio;
    context.beginPath();
    x.forEach((value, i) => context.lineTo(X(value), Y(y[i])));
    context.stroke();
  };
  if (low <= 0 && high >= 0) line([left, right], [0, 0], "#9aa5b1", 1);
  for (const { x, y, colour } of curves) line(x, y, colour, 1.5);
  if (marker !== undefined) line([marker, marker], [low, high], SERIES[1], 1);
  context.strokeStyle = SERIES[1];
  context.lineWidth = 2 * ratio;
  for (const x of curves.flatMap(curve => curve.marks || [])) {
    context.beginPath();
    context.arc(X(x), Y(0), 5 * ratio, 0, 2 * Math.PI);
    context.stroke();
  }
  context.fillStyle = getComputedStyle(canvas).color;
  context.font = `${11 * ratio}px system-ui, sans-serif`;
  context.textBaseline = "top";
  context.fillText(short(high), 2, 1);
  context.textBaseline = "bottom";
  context.fillText(short(low), 2, height - 1);
}

// Adds the overlay with keys and what they do.
function addHelp(shortcuts) {
  const help = element("div", document.body, { className: "help", hidden: true });
  for (const [keys, textContent] of shortcuts) {
    const row = element("div", help);
    element("kbd", row, { textContent: keys });
    element("span", row, { textContent });
  }
  help.addEventListener("click", () => { help.hidden = true; });
  return help;
}

function save(blob, download) {
  const link = element("a", document.body, { href: URL.createObjectURL(blob), download });
  link.click();
  link.remove();
}
