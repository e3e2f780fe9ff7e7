// Starts the replay and draws the shapes at the current time in each animation frame.

async function start() {
  const scene = element("div", document.body, { className: "scene" });
  const canvas = element("canvas", scene), drawing = new Drawing(canvas);
  const motion = await unpack(document.getElementById("motion").textContent);
  let stale = true, stalePanel = true, shownAt = 0, before = performance.now();
  const changed = () => { stale = true; };
  const played = motion.acts.map((act, i) => playAct(act, i, motion.acts.length, drawing));
  const pointer = trackPointer(canvas, changed);
  const panel = addPanel("Show"), shown = addSwitches(motion, panel, changed), clock = addClock(Math.max(...played.map(act => act.end)), changed, motion.acts.flatMap(act => act.events));
  const panels = document.getElementById("follows") ? [] : played.map(({ act }) => new ActPanel(panel, act, clock, changed));
  panel.classList.toggle("wide", panels.length > 0);
  const { clientWidth, clientHeight } = played[0].box;
  const camera = new Camera(played[0].world, clientWidth / clientHeight || 1), showTip = addTooltip();
  addViews(camera, panel, changed);
  camera.handleInput(canvas, changed);
  if (document.getElementById("follows")) followRun(played[0].act, changed);
  addEventListener("resize", changed);
  panel.addEventListener("toggle", changed);
  drawing.dark.addEventListener("change", changed);
  window.camera = camera;
  const rate = new FrameRate();
  const drawFrame = now => {
    const seconds = (now - before) / 1000;
    clock.tick(seconds);
    before = now;
    if (clock.status) setText(clock.status, rate.tick(seconds, clock.playing));
    if (stale) {
      stale = false;
      stalePanel = true;
      drawing.begin();
      played.forEach((act, i) => drawAct(act, i, played.length, drawing, camera, shown, clock.now, pointer));
      showTip(textAt(pointer, played, camera, shown, (act, name) => valueAt(act, name, ...frameAt(act.time, clock.now))), pointer);
      document.body.dataset.drawn = clock.now;
    }
    if (stalePanel && now - shownAt > PANEL_MILLISECONDS) {
      [stalePanel, shownAt] = [false, now];
      for (const one of panels) one.show(clock.now);
    }
    requestAnimationFrame(drawFrame);
  };
  requestAnimationFrame(drawFrame);
}

start().catch(error => { element("div", document.body, { className: "message", textContent: `The replay cannot be shown: ${error.message}.` }); });
