// Pointer in a page that simulates: drag a link to pull it, drag the target to move it.

// Handles pointer events before the camera does. `play` has `client`, `shapes`, `shown`, `targetPoint`, `moveTarget`.
function handlePulling(canvas, camera, play) {
  let drag = null;
  const move = event => onPlane(rayAt(camera, canvas, event.offsetX, event.offsetY), camera, drag.place);
  canvas.addEventListener("pointerdown", event => {
    if (event.button !== 0 || event.shiftKey || drag || play.client.frame.mode === "pose") return;
    const ray = rayAt(camera, canvas, event.offsetX, event.offsetY), target = play.targetPoint();
    if (target && hitBall(ray, target, 2 * play.targetRadius) < Infinity) drag = { place: target, isTarget: true };
    else {
      const hit = pick(ray, play.shapes, play.shown, 1.5);
      if (!hit) return;
      const place = onRay(ray, hit.t);
      drag = { place, link: hit.shape.link, point: play.inLink(hit.shape.link, place) };
    }
    event.stopImmediatePropagation();
    canvas.setPointerCapture(event.pointerId);
  }, true);
  canvas.addEventListener("pointermove", event => {
    if (!drag) return;
    event.stopImmediatePropagation();
    if (drag.isTarget) play.moveTarget(move(event));
    else {
      play.spring = move(event);
      play.panel.do(play.client.pull(drag.link, drag.point, play.spring, play.stiffness));
    }
  }, true);
  for (const end of ["pointerup", "pointercancel"])
    canvas.addEventListener(end, event => {
      if (!drag) return;
      event.stopImmediatePropagation();
      if (!drag.isTarget) play.client.release();
      play.spring = null;
      drag = null;
    }, true);
}
