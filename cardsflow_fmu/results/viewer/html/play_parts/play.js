// Starts the simulation in the page and draws its frames.

class Play {
  constructor(motion, data, client, drawing) {
    const [act] = motion.acts, numbers = new Map(client.setup.links.map((link, i) => [link, i]));
    Object.assign(this, { motion, data, client, act, shapes: act.shapes, ramp: motion.ramp });
    this.stiffness = Math.max(10, 40 * client.setup.mass / act.reach);
    this.targetRadius = 0.02 * act.reach;
    this.muscles = new Map(client.setup.muscles.map(({ name }, i) => [`muscles/${name}`, i]));
    for (const shape of act.shapes) {
      const link = data.links[shape.name];
      if (link !== undefined) fixShape(shape, numbers.get(link), this.pose(numbers.get(link)));
      if (shape.kind === "Label") shape.coordinate = client.setup.coordinates.findIndex(c => shape.name.endsWith(`/${c.name}`));
    }
    const group = motion.groups.indexOf("muscles"), forces = motion.groups.indexOf("forces");
    const still = (kind, name, colour, radius, where) => ({ kind, name, group: where, radius,
      points: { rows: 1, columns: 6, numbers: new Float32Array(6) }, colours: { rows: 1, columns: 3, numbers: Float32Array.from(colour) } });
    this.extra = {
      spring: still("Line", "spring", [235, 140, 20], 0.004 * act.reach, group),
      force: still("Arrow", "force", [235, 140, 20], 0.006 * act.reach, forces),
      target: still("Sphere", "target", [30, 150, 90], this.targetRadius, group),
    };
    this.played = playAct({ ...act, time: [0] }, 0, 1, drawing);
    this.force = element("div", this.played.box, { className: "label", hidden: true });
    element("span", this.played.box.firstChild, { className: "hint", textContent: client.setup.modes.length > 1 ? "Drag a link to pull it. The ? button lists the keys." :
      "Move the sliders. Click a muscle and a joint to plot the moment arm." });
  }

  pose(link, poses = this.client.frame.poses) { return poses.subarray(12 * link, 12 * link + 12); }

  inLink(link, place) { return toLink(this.pose(link), place); }

  // Moves all shapes to a frame of the simulation.
  update(frame) {
    let at = 0;
    if (this.panel.scale) this.panel.scale.include(frame.tensions);
    const paths = Array.from(frame.pathSizes, size => frame.paths.subarray(3 * at, 3 * (at += size)));
    for (const shape of this.shapes) {
      if (shape.link !== undefined) moveShape(shape, this.pose(shape.link, frame.poses));
      if (shape.coordinate >= 0) shape.values.numbers[0] = frame.q[shape.coordinate];
      const muscle = this.muscles.get(shape.name);
      if (muscle === undefined) continue;
      if (frame.broken[muscle]) setPoints(shape, stumpOf(paths[muscle]), BROKEN);
      else setPoints(shape, paths[muscle], this.panel.scale && this.colour(frame.tensions[muscle]));
    }
    this.updateExtras(frame);
  }

  // Returns the colour of a tension, between f_min and the largest tension up to now.
  colour(tension) {
    const { low, high } = this.panel.scale, last = this.ramp.length - 1;
    const part = high > low ? Math.max(0, Math.min(1, (tension - low) / (high - low))) : 0;
    return this.ramp[Math.round(part * last)];
  }

  updateExtras({ pull, mode }) {
    const shapes = [], { spring, force, target } = this.extra;
    if (pull && this.spring) {
      const size = Math.hypot(...pull.force), end = sum(pull.point, pull.force, 0.15 * this.act.reach / Math.max(size, 1e-9));
      setPoints(spring, Float32Array.from([...pull.point, ...this.spring]));
      setPoints(force, Float32Array.from([...pull.point, ...end]));
      shapes.push(spring, force);
    }
    const point = mode === "task" && this.targetPoint();
    if (point) {
      setPoints(target, Float32Array.from(point));
      shapes.push(target);
    }
    this.played.act.shapes = [...this.shapes, ...shapes];
  }

  // Returns the indices of x, y, z of the first end-effector point among the tasks; -1 if it is not a task.
  axes() {
    const [first] = this.client.setup.tasks, name = first && first.name.replace(/\.[xyz]$/, "");
    return ["x", "y", "z"].map(axis => this.client.setup.tasks.findIndex(task => task.name === `${name}.${axis}`));
  }

  // Returns the target in the scene: the tasks, and the current place along other axes.
  targetPoint() {
    const { frame } = this.client;
    if (frame.mode !== "task" || !frame.target) return null;
    const axes = this.axes(), now = this.data.hand ? this.handNow() : [0, 0, 0];
    return axes.some(k => k >= 0) ? axes.map((k, i) => k >= 0 ? frame.target[k] : now[i]) : null;
  }

  handNow() {
    return toWorld(this.pose(this.data.hand.link), this.data.hand.position);
  }

  moveTarget(place) {
    const goal = Array.from(this.client.frame.target);
    this.axes().forEach((k, i) => { if (k >= 0) goal[k] = place[i]; });
    this.panel.do(this.client.setTarget(goal));
  }

  // Shows the newtons of the spring next to the pulled point.
  showForce({ pull }, camera, canvas) {
    this.force.hidden = !pull;
    if (!pull) return;
    const { view } = camera.uniforms(canvas.clientWidth / Math.max(canvas.clientHeight, 1)), place = project(view, pull.point);
    if (!place) return;
    this.force.textContent = `${short(Math.hypot(...pull.force))} N`;
    this.force.style.transform = `translate(${place[0] * canvas.clientWidth + 12}px, ${place[1] * canvas.clientHeight - 24}px)`;
  }
}

// Returns the value of a signal, such as `tension.NAME`, in a frame.
function signalOf(play, name) {
  const { frame } = play.client, { muscles, joints } = play.act, index = (list, key) => list.findIndex(one => one[key] === name);
  const muscle = index(muscles, "tension"), joint = index(joints, "actual");
  if (muscle >= 0) return play.panel.isStill ? undefined : frame.tensions[muscle];
  return joint >= 0 ? frame.q[joint] : frame.values[play.panel.analysis.columns.get(`plant.${name}`)];
}

async function startPlay() {
  const text = id => document.getElementById(id).textContent;
  const scene = element("div", document.body, { className: "scene" });
  const canvas = element("canvas", scene), drawing = new Drawing(canvas);
  const motion = await unpack(text("motion"));
  const client = await EngineClient.open(text("engine"), text("engine-script"));
  const play = new Play(motion, JSON.parse(text("play")), client, drawing);
  let stale = true, stalePanel = true, shownAt = 0, before = performance.now();
  const changed = () => { stale = true; };
  const box = addPanel(client.setup.modes.length > 1 ? "Play" : "Robot");
  box.classList.add("wide");
  const panel = play.panel = new PlayPanel(client, play.data, motion, box);
  play.shown = addSwitches({ ...motion, acts: [play.act] }, panel.shown, changed);
  const { clientWidth, clientHeight } = play.played.box;
  const camera = new Camera(play.played.world, clientWidth / clientHeight || 1), showTip = addTooltip();
  addViews(camera, box, changed);
  handlePulling(canvas, camera, play);
  camera.handleInput(canvas, changed);
  const pointer = trackPointer(canvas, changed);
  addEventListener("resize", changed);
  box.addEventListener("toggle", changed);
  drawing.dark.addEventListener("change", changed);
  const showBar = panel.isStill ? () => {} : addPlayBar(client, panel);
  if (panel.isStill) box.append(panel.status);
  client.onframe = changed;
  client.onfailure = message => { panel.failure = `${message}; step back or reset`; panel.showStatus(); };
  const rate = new FrameRate();
  const draw = now => {
    panel.slow = rate.tick((now - before) / 1000, client.frame.playing);
    before = now;
    if (stale) {
      stale = false;
      stalePanel = true;
      const { frame } = client;
      panel.events.update(frame);
      play.update(frame);
      showBar(frame);
      panel.showStatus(frame);
      drawing.begin();
      drawAct(play.played, 0, 1, drawing, camera, play.shown, 0, pointer);
      play.showForce(frame, camera, canvas);
      showTip(frame.pull ? "" : textAt(pointer, [play.played], camera, play.shown, (act, name) => signalOf(play, name)), pointer);
      document.body.dataset.drawn = frame.time;
    }
    if (stalePanel && now - shownAt > PANEL_MILLISECONDS) {
      [stalePanel, shownAt] = [false, now];
      panel.show(client.frame);
    }
    requestAnimationFrame(draw);
  };
  requestAnimationFrame(draw);
  window.play = Object.assign(play, { camera });
}

startPlay().catch(error => { element("div", document.body, { className: "message", textContent: `The simulation cannot start: ${error.message}.` }); });
