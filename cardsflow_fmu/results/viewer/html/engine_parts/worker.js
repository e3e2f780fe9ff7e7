// The worker of a page that simulates: it steps in real time and posts frames to client.js.

const FRAME_SECONDS = 1 / 60;
let engine = null, isPlaying = false, speed = 1, due = 0, last = 0, behind = 0, timer = 0;

function post(reply) {
  const frame = { ...engine.frame(), playing: isPlaying, speed, behind };
  const owned = [frame.values, frame.q, frame.poses, frame.paths, frame.pathSizes, frame.tensions, frame.commands, frame.torques];
  self.postMessage({ frame, ...reply }, owned.map(array => array.buffer));
}

// Runs what is due since the last call. `behind` is the share of time that could not be computed.
function tick() {
  const now = performance.now() / 1000, elapsed = Math.min(now - last, 0.1);
  last = now;
  due += elapsed * speed;
  const asked = Math.floor(due / engine.step);
  let done = 0;
  try {
    while (done < asked && performance.now() / 1000 - now < 0.8 * FRAME_SECONDS) {
      const count = Math.min(asked - done, 8);
      engine.run(count);
      done += count;
    }
  } catch (error) {
    isPlaying = false;
    self.postMessage({ failure: error.message });
  }
  due -= done * engine.step;
  const missing = asked > 0 ? 1 - done / asked : 0;
  behind += 0.1 * (missing - behind);
  if (behind < 0.001) behind = 0;
  if (due > 2 * FRAME_SECONDS * speed) due = 0; // does not catch up
  post({});
  if (isPlaying) timer = setTimeout(tick, Math.max(0, 1000 * (FRAME_SECONDS - (performance.now() / 1000 - now))));
}

const CALLS = {
  play() {
    if (isPlaying) return;
    engine.requireDynamics();
    isPlaying = true;
    last = performance.now() / 1000;
    due = 0;
    timer = setTimeout(tick, 0);
  },
  pause() {
    isPlaying = false;
    clearTimeout(timer);
  },
  stepOnce(count = 1) { CALLS.pause(); engine.run(count); },
  reset() { engine.reset(); },
  setSpeed(value) { speed = Math.min(10, Math.max(0.1, value)); },
  goTo(step) { CALLS.pause(); engine.goTo(step); },
  setMode(mode) { engine.setMode(mode); },
  setTarget(values) { engine.setTarget(values); },
  setMuscles(values, torques) { engine.setMuscles(values, torques); },
  setPose(q) {
    CALLS.pause();
    engine.setPose(q);
  },
  pull(link, point, how) { engine.pull(link, point, how); },
  release() { engine.release(); },
  set(key, value) { return engine.change(key, value); },
  momentArms(muscle, joint) { return engine.analysis.momentArms(muscle, joint); },
  getState() { return engine.saved(); },
  setState(state) { engine.load(state); },
  run(count) {
    const begin = performance.now();
    engine.run(count);
    return (performance.now() - begin) / 1000;
  },
};

self.onmessage = async ({ data: { id, call, values } }) => {
  try {
    if (call === "open") {
      engine = await Engine.open(values[0]);
      const { module, models, loops, ...header } = engine.header;
      const columns = engine.columns.map(({ name, unit }) => ({ name, unit }));
      const setup = { ...header, links: header.drawing.links, columns, modes: engine.modes };
      post({ id, result: setup });
      return;
    }
    const result = CALLS[call](...values);
    post({ id, result });
  } catch (error) {
    if (engine) post({ id, error: error.message });
    else self.postMessage({ id, error: error.message });
  }
};
