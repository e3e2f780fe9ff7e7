// Live changes of a running simulation, by the keys of `cardsflow run --set`.
//
// Gains and force limits are tunable variables. Gravity, masses, tensions, cable friction, breaks of cables and
// sensor noise are fields of a model's file: the model is opened again with its state.

class Changes {
  constructor(engine, part) {
    this.engine = engine;
    this.all = {};
    this.files = engine.header.models.map(entry => part(entry.file));
    this.inertias = new Float64Array(part(engine.header.inertias).slice().buffer);
    this.opened = engine.header.models.map(() => "{}");
  }

  // Sets a change; null removes it.
  set(key, value) {
    const all = { ...this.all, [key]: value };
    if (value === null) delete all[key];
    this.replace(all);
  }

  replace(all) {
    const before = this.all;
    this.all = all;
    try {
      this.check();
      this.openModels();
      this.write();
    } catch (error) {
      this.all = before;
      this.openModels();
      this.write();
      throw error;
    }
  }

  check() {
    const { muscles, drawing } = this.engine.header, names = muscles.map(muscle => muscle.name);
    for (const [key, value] of Object.entries(this.all)) {
      const [kind, name] = this.parse(key);
      const allowed = { mass: drawing.links, friction: names, tension: names, break: names, f_max: names }[kind];
      if (allowed && !allowed.includes(name)) throw new Error(`${key}: ${JSON.stringify(name)} does not exist`);
      for (const number of [value].flat())
        if (!Number.isFinite(number)) throw new Error(`${key}: must be a number, not ${value}`);
    }
  }

  // Returns kind and name of a key.
  parse(key) {
    const forms = [
      [/^robot\.gravity()$/, "gravity"], [/^plant\.mass_scale\.(.+)$/, "mass"],
      [/^plant\.friction_scale\.(.+)$/, "friction"], [/^plant\.tension_scale\.(.+)$/, "tension"],
      [/^plant\.break_time\.(.+)$/, "break"],
      [/^muscles\.(.+)\.f_max$/, "f_max"], [/^controller\.((?:kp|kd)\..+)$/, "gain"],
      [/^noise()$/, "noise"],
    ];
    for (const [form, kind] of forms) {
      const match = form.exec(key);
      if (match) return [kind, match[1]];
    }
    throw new Error(`${key} cannot be changed while the simulation runs`);
  }

  // Returns the values of a kind by name.
  of(kind) {
    const values = new Map();
    for (const [key, value] of Object.entries(this.all)) {
      const [keyKind, name] = this.parse(key);
      if (keyKind === kind) values.set(name, value);
    }
    return values;
  }

  // ------------------------------------------------------------------- variables

  write() {
    const { engine } = this, { muscles } = engine.header;
    if (!engine.controller) return;
    const at = engine.loop.models.indexOf(engine.controller), { controller } = engine;
    const original = new Float64Array(engine.loop.values[at].buffer), limits = this.of("f_max");
    for (const name of ["kp", "kd", "f_max"]) {
      const [first, count] = controller.entry.groups[name];
      controller.group(name).set(original.subarray(first, first + count));
    }
    muscles.forEach(({ name }, i) => { if (limits.has(name)) controller.group("f_max")[i] = limits.get(name); });
    for (const [name, value] of this.of("gain")) {
      const port = controller.entry.names.indexOf(name);
      if (port >= 0) controller.values[port] = value; // the controller of another mode may have this gain
    }
  }

  // ------------------------------------------------------------------- fields of files

  openModels() {
    let isNew = false;
    this.engine.models.forEach((model, i) => {
      const changes = this.fieldsOf(i), key = JSON.stringify(changes);
      if (this.opened[i] === key) return;
      model.load(this.fileWith(i, changes));
      this.opened[i] = key;
      isNew = true;
    });
    if (isNew) for (const loop of Object.values(this.engine.loops)) loop.connect();
  }

  // Returns the changes that concern the file of a model.
  fieldsOf(i) {
    const { role, fields } = this.engine.header.models[i], changes = {};
    const take = (kind, of) => { if (fields[of] && this.of(kind).size) changes[kind] = [...this.of(kind)]; };
    take("gravity", "gravity");
    if (role === "plant")
      for (const [kind, of] of Object.entries({ mass: "mass", friction: "bend_friction", tension: "tension_scale", break: "break_time" }))
        take(kind, of);
    if (role !== "sensors") return changes;
    take("noise", "noise");
    take("break", "stuck");
    // the time of a model is 0 when the model begins
    if (changes.break) changes.break = changes.break.map(([name, time]) => [name, time - this.engine.models[i].begin]);
    return changes;
  }

  fileWith(i, changes) {
    const file = this.files[i].slice(), { fields } = this.engine.header.models[i];
    const view = new DataView(file.buffer);
    const numbers = name => {
      const [at, count] = fields[name];
      return {
        count,
        get: k => view.getFloat64(at + 8 * k, true),
        set: (k, value) => view.setFloat64(at + 8 * k, value, true),
      };
    };
    if (changes.gravity) changes.gravity[0][1].forEach((value, k) => numbers("gravity").set(k, value));
    if (changes.mass) this.scaleMasses(new Map(changes.mass), numbers);
    if (changes.friction) this.scaleFriction(new Map(changes.friction), numbers("bend_friction"), view, fields);
    for (const [kind, name] of [["tension", "tension_scale"], ["break", fields.stuck ? "stuck" : "break_time"]])
      for (const [muscle, value] of changes[kind] || [])
        numbers(name).set(this.engine.header.muscles.findIndex(one => one.name === muscle), value);
    if (changes.noise) {
      const noise = numbers("noise");
      for (let k = 0; k < noise.count; k++) noise.set(k, changes.noise[0][1] * noise.get(k));
    }
    view.setUint32(16, crc32(file.subarray(20)), true);
    return file;
  }

  // Writes mass, centre and inertia of every moving frame with a scaled link.
  scaleMasses(scales, numbers) {
    const { links } = this.engine.header.drawing, { frames } = this.engine.drawing;
    const changed = new Set(links.flatMap((link, i) => scales.has(link) && frames[i] >= 0 ? [frames[i]] : []));
    for (const frame of changed) {
      const sum = new Float64Array(10);
      links.forEach((link, i) => {
        const scale = scales.has(link) ? scales.get(link) : 1;
        if (frames[i] === frame) for (let k = 0; k < 10; k++) sum[k] += scale * this.inertias[10 * i + k];
      });
      const [m, x, y, z] = [sum[0], ...[1, 2, 3].map(k => sum[0] ? sum[k] / sum[0] : 0)];
      const shift = [y * y + z * z, x * x + z * z, x * x + y * y, -x * y, -x * z, -y * z];
      numbers("mass").set(frame, m);
      [x, y, z].forEach((value, k) => numbers("mass_centre").set(3 * frame + k, value));
      shift.forEach((value, k) => numbers("inertia").set(6 * frame + k, sum[4 + k] - m * value));
    }
  }

  scaleFriction(scales, friction, view, fields) {
    let bend = 0;
    this.engine.header.muscles.forEach(({ name }, i) => {
      const count = view.getInt32(fields.muscle_bends[0] + 4 * i, true);
      for (const end = bend + count; bend < end; bend++)
        if (scales.has(name)) friction.set(bend, scales.get(name) * friction.get(bend));
    });
  }
}
