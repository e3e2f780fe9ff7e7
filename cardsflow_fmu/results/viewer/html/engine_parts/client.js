// Simulation in a worker, for a page: calls, frames, failures.

// Returns a number of the setup, in which null is infinite or missing, or another value instead.
const finiteOr = (value, other) => value === null || !Number.isFinite(value) ? other : value;

class EngineClient {
  // Opens the packed experiment `text`, see models/browser/pack.py, with the scripts of the worker.
  static async open(text, script) {
    const packed = Uint8Array.from(atob(text), c => c.charCodeAt(0));
    const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
    const bytes = new Uint8Array(await new Response(stream).arrayBuffer());
    const self = new EngineClient();
    const url = URL.createObjectURL(new Blob(["'use strict';\n" + script], { type: "text/javascript" }));
    self.worker = new Worker(url);
    self.waiting = new Map();
    self.number = 0;
    self.live = {};
    self.onframe = self.onfailure = () => {};
    self.worker.onmessage = ({ data }) => self.receive(data);
    self.worker.onerror = event => self.fail(event.message || "the simulation cannot start in this page");
    self.setup = await self.call("open", bytes);
    URL.revokeObjectURL(url); // not earlier: a frame of a notebook loads the worker later
    return self;
  }

  receive({ id, frame, failure, error, result }) {
    if (frame) {
      this.frame = frame;
      this.onframe(frame);
    }
    if (failure) this.onfailure(failure);
    const waiting = this.waiting.get(id);
    if (!waiting) return;
    this.waiting.delete(id);
    if (error === undefined) waiting.resolve(result);
    else waiting.reject(new Error(error));
  }

  fail(message) {
    for (const { reject } of this.waiting.values()) reject(new Error(message));
    this.waiting.clear();
    this.onfailure(message);
  }

  call(name, ...values) {
    return new Promise((resolve, reject) => {
      this.waiting.set(++this.number, { resolve, reject });
      this.worker.postMessage({ id: this.number, call: name, values });
    });
  }

  pull(link, point, target, stiffness = 100) { return this.call("pull", link, point, { target, stiffness }); }

  // Changes a number of the running simulation, by the key of `cardsflow run --set`; null: as in the experiment.
  async set(key, value) {
    const inEffect = await this.call("set", key, value);
    if (value === null) delete this.live[key];
    else this.live[key] = inEffect;
  }

  changes() { return { ...this.live }; }

  // Returns the options of `cardsflow run` that reproduce the live changes: `--set`, `key=value`, ...
  options(changes = this.live) {
    const quoted = name => /^[^\s."'=]+$/.test(name) ? name : JSON.stringify(name);
    const form = /^(plant\.\w+|controller\.k[pd]|muscles)\.(.+?)(\.f_max)?$/;
    return Object.entries(changes).filter(([key]) => key !== "noise").flatMap(([key, value]) => {
      const match = form.exec(key);
      const full = match ? `${match[1]}.${quoted(match[2])}${match[3] || ""}` : key;
      return ["--set", `${full}=${JSON.stringify(value)}`];
    });
  }

  close() { this.worker.terminate(); }
}

// Calls of the worker with the same names and values; see worker.js.
for (const name of ["play", "pause", "stepOnce", "reset", "setSpeed", "goTo", "setMode", "setTarget", "setMuscles", "setPose",
  "release", "getState", "setState", "run"])
  EngineClient.prototype[name] = function (...values) { return this.call(name, ...values); };
