// The C models of an experiment as WebAssembly: memory, calls and messages; see runtime/csrc/loop.

// Returns a number of a header, in which null is infinite or missing, or another value instead.
const finiteOr = (value, other) => value === null || !Number.isFinite(value) ? other : value;

class Module {
  static async open(code) {
    const self = new Module();
    const clock_time_get = (id, precision, into) => {
      const now = BigInt(Math.round(1e6 * performance.now()));
      new DataView(self.calls.memory.buffer).setBigUint64(into, now, true);
      return 0;
    };
    const { instance } = await WebAssembly.instantiate(code, { wasi_snapshot_preview1: { clock_time_get } });
    self.calls = instance.exports;
    self.calls._initialize();
    return self;
  }

  // Copies bytes or numbers to new memory; returns its address.
  put(values) {
    const bytes = new Uint8Array(values.buffer, values.byteOffset, values.byteLength);
    const at = this.room(bytes.length);
    new Uint8Array(this.calls.memory.buffer, at, bytes.length).set(bytes);
    return at;
  }

  room(size) {
    const at = this.calls.malloc(Math.max(size, 8));
    if (!at) throw new Error("not enough memory for the simulation");
    return at;
  }

  free(at) { this.calls.free(at); }

  // Views are valid until memory grows, so they are created for each use.
  doubles(at, count) { return new Float64Array(this.calls.memory.buffer, at, count); }
  words(at, count) { return new Uint32Array(this.calls.memory.buffer, at, count); }
  bytes(at, size) { return new Uint8Array(this.calls.memory.buffer, at, size); }

  text(at) {
    const bytes = new Uint8Array(this.calls.memory.buffer, at);
    return new TextDecoder().decode(bytes.slice(0, bytes.indexOf(0)));
  }

  // Calls a function with copies of some bytes, which are then freed.
  withCopies(parts, call) {
    const places = parts.map(part => this.put(part));
    try {
      return call(...places);
    } finally {
      for (const at of places) this.free(at);
    }
  }
}

// A model: its variables `values`, and its internal state.
class Model {
  constructor(module, entry, file, ports) {
    this.module = module;
    this.ports = ports;
    this.entry = entry;
    this.role = entry.role;
    this.count = entry.names.length;
    this.at = module.room(8 * this.count);
    this.handle = this.begin = this.line = this.room = 0;
    this.load(file);
  }

  get values() { return this.module.doubles(this.at, this.count); }

  group(name) {
    const [first, count] = this.entry.groups[name] || [0, 0];
    return this.module.doubles(this.at + 8 * first, count);
  }

  // Opens the model, or opens it again with another file: variables and state stay the same.
  load(file) {
    const { module } = this, { calls } = module, capacity = 512, message = module.room(capacity);
    const before = this.handle && { values: this.values.slice(), state: this.state() };
    const opened = module.withCopies([file, this.ports], (a, b) =>
      calls.native_model_open(a, file.length, b, this.ports.length, this.at, message, capacity));
    const text = opened ? "" : module.text(message);
    module.free(message);
    if (before) this.values.set(before.values);
    if (!opened) throw new Error(text);
    if (this.handle) calls.native_model_close(this.handle);
    this.handle = opened;
    this.arrays = new Map();
    if (before) this.setState(before.state);
    if (before) this.values.set(before.values);
  }

  check(failed) {
    if (failed) throw new Error(this.message);
  }

  get message() { return this.module.text(this.module.calls.native_model_message(this.handle)); }

  initialize(time) {
    this.begin = time;
    this.check(this.module.calls.native_model_initialize(this.handle, time));
  }

  state() {
    const { module } = this, out = module.room(8);
    this.check(module.calls.native_model_get_state(this.handle, out, out + 4));
    const [at, size] = module.words(out, 2);
    const state = module.bytes(at, size).slice();
    module.free(out);
    return state;
  }

  setState(state) {
    this.module.withCopies([state], at =>
      this.check(this.module.calls.native_model_set_state(this.handle, at, state.length)));
  }

  // Returns an array of the C core or of a controller by name; see core.h and control_loop.h.
  array(name) {
    const { module } = this;
    if (!this.arrays.has(name)) {
      const length = module.room(8), key = module.put(new TextEncoder().encode(name + "\0"));
      const at = module.calls.native_model_array(this.handle, key, length);
      this.arrays.set(name, [at, at ? module.words(length, 1)[0] : 0]);
      module.free(key);
      module.free(length);
    }
    return module.doubles(...this.arrays.get(name));
  }

  // Returns the polylines of all muscles, one after the other, and their numbers of points.
  lines() {
    const { module } = this, { calls } = module, muscles = this.array("lengths").length;
    const sizes = module.room(4 * muscles), draw = () => calls.native_model_lines(this.handle, sizes, this.line, this.room);
    const total = draw();
    if (total > this.room) {
      if (this.line) module.free(this.line);
      this.room = 2 * total;
      this.line = module.room(24 * this.room);
      draw();
    }
    const result = { points: new Float32Array(module.doubles(this.line, 3 * total)), sizes: module.words(sizes, muscles).slice() };
    module.free(sizes);
    return result;
  }
}

// Models that step together, with the tables of one drive mode; see native_loop.h.
class Loop {
  constructor(module, models, entry, part) {
    Object.assign(this, { module, models });
    this.tables = ["turns", "copies", "changes"].map(name => module.put(part(entry[name])));
    this.values = entry.values.map(place => part(place).slice());
    this.sizes = entry.sizes;
    this.handle = 0;
    this.done = module.room(8);
    this.connect();
  }

  // Connects the models again after one of them has been opened again.
  connect() {
    const { calls } = this.module, [turns, copies] = this.sizes, [turnsAt, copiesAt, changesAt] = this.tables;
    if (this.handle) calls.native_loop_close(this.handle);
    const handles = new Uint32Array(this.models.map(model => model.handle));
    this.handle = this.module.withCopies([handles], at => calls.native_loop_open(handles.length, at));
    if (!this.handle || calls.native_loop_plan(this.handle, turns, turnsAt, copies, copiesAt, changesAt))
      throw new Error("the page is damaged: the tables of its simulation do not match its models");
  }

  // Runs some steps, at most MAX_STEPS; returns the number of completed steps.
  run(step, first, count) {
    const { module, done } = this;
    const failed = module.calls.native_loop_run(this.handle, step, BigInt(first), BigInt(count), done);
    this.failure = failed ? this.models[failed - 1].message : "";
    return Number(new BigInt64Array(module.calls.memory.buffer, done, 1)[0]);
  }
}
Loop.MAX_STEPS = 64; // NATIVE_LOOP_STEPS
