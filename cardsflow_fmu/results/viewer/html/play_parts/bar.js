// Bar of a page that simulates: status, play, steps, reset, history, speed, help.

const SHORTCUTS = [
  ["Space", "play or pause"], [". and ,", "one step forward or back"], ["Backspace", "reset"],
  ["← and →", "0.1 s back or forward"], ["+ and -", "faster or slower"], ["1 to 5", "drive mode"],
  ["f, s, t, 0", "view from the front, the side, the top; fit"],
  ["drag a link", "pull it with a spring"], ["drag the green ball", "move the end effector's target"],
  ["drag elsewhere", "turn the view; with Shift: move it"], ["?", "this help"],
];

// Adds play, step, reset, history and speed; returns a function that shows a frame.
function addPlayBar(client, panel) {
  const bar = element("div", document.body, { className: "bar playing" }), help = addHelp(SHORTCUTS);
  bar.append(panel.status);
  const button = (textContent, ariaLabel, act) => {
    const added = element("button", bar, { textContent, ariaLabel, title: ariaLabel });
    added.addEventListener("click", () => { act(); added.blur(); });
    return added;
  };
  const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 5, 10];
  const at = step => Math.max(client.frame.first, Math.min(client.frame.last, step));
  const goTo = step => panel.do(client.goTo(at(step)));
  const toggle = () => panel.do(client.frame.playing ? client.pause() : client.play());
  const next = () => panel.do(client.stepOnce()), back = () => goTo(client.frame.step - 1);
  const reset = () => panel.do(client.reset());
  const play = button("▶", "play", toggle);
  button("❘◀", "one step back", back);
  button("▶❘", "one step", next);
  button("↺", "reset", reset);
  const slider = element("input", bar, { type: "range", min: 0, max: 0, step: 1, ariaLabel: "history" });
  slider.addEventListener("input", () => goTo(slider.valueAsNumber));
  const mark = addMarks(slider, time => goTo(Math.round(time / client.setup.step)));
  const output = element("output", bar), speed = element("select", bar, { ariaLabel: "speed" });
  for (const factor of SPEEDS) element("option", speed, { value: factor, textContent: `${factor} x`, selected: factor === 1 });
  const setSpeed = factor => { speed.value = factor; panel.do(client.setSpeed(factor)); };
  speed.addEventListener("change", () => setSpeed(Number(speed.value)));
  button("?", "help", () => { help.hidden = !help.hidden; });
  const tenth = Math.max(1, Math.round(0.1 / client.setup.step));
  const faster = by => setSpeed(SPEEDS[Math.max(0, Math.min(SPEEDS.length - 1, SPEEDS.indexOf(Number(speed.value)) + by))]);
  const keys = {
    " ": toggle, ".": next, ",": back, Backspace: reset, "+": () => faster(1), "-": () => faster(-1),
    ArrowLeft: () => goTo(client.frame.step - tenth), ArrowRight: () => goTo(client.frame.step + tenth),
    "?": () => { help.hidden = !help.hidden; }, Escape: () => { help.hidden = true; },
  };
  Object.keys(MODE_NAMES).forEach((mode, i) => { keys[i + 1] = () => panel.do(client.setMode(mode)); });
  addEventListener("keydown", event => {
    if (event.target !== document.body || event.ctrlKey || event.metaKey || !keys[event.key]) return;
    event.preventDefault();
    keys[event.key]();
  });
  return frame => {
    play.textContent = frame.playing ? "❚❚" : "▶";
    Object.assign(slider, { min: frame.first, max: frame.last, value: frame.step });
    mark(panel.events.all, frame.first * client.setup.step, frame.last * client.setup.step);
    output.textContent = `${frame.time.toFixed(3)} s`;
  };
}
