// Pointer in the edit page: a drag of a handle moves it, a click places points and surfaces or selects; other drags turn the view.

const CLICK = 5; // in pixels: maximum movement of a click

class EditPointer {
  constructor(editor) {
    this.editor = editor;
    const { canvas } = editor;
    canvas.addEventListener("pointerdown", event => this.press(event), true);
    canvas.addEventListener("pointermove", event => this.move(event), true);
    canvas.addEventListener("pointerup", event => this.release(event), true);
    canvas.addEventListener("pointercancel", () => this.stop(), true);
    canvas.addEventListener("pointerleave", () => editor.setHint(null));
  }

  press(event) {
    if (event.button !== 0 || event.shiftKey || this.drag) return;
    const at = [event.offsetX, event.offsetY];
    this.pressed = { at, id: event.pointerId };
    const handle = handleAt(this.editor, at, event.pointerType === "touch");
    if (!handle || !this.editor.mayDrag(handle)) return;
    event.stopImmediatePropagation();
    this.editor.canvas.setPointerCapture(event.pointerId);
    this.editor.select(handle.kind === "point" ? { muscle: handle.muscle, point: handle.index } : { wrap: handle.wrap });
    this.drag = handle;
  }

  move(event) {
    const at = [event.offsetX, event.offsetY], isMoved = this.pressed && Math.hypot(at[0] - this.pressed.at[0], at[1] - this.pressed.at[1]) > CLICK;
    if (isMoved) this.isMoved = true;
    if (this.drag) {
      event.stopImmediatePropagation();
      if (this.isMoved) this.dragTo(at, !event.altKey);
    } else if (!event.buttons) this.editor.hover(at, !event.altKey);
  }

  release(event) {
    const { pressed, drag, isMoved } = this;
    this.stop();
    if (drag) event.stopImmediatePropagation();
    else if (pressed && pressed.id === event.pointerId && !isMoved) this.editor.click([event.offsetX, event.offsetY], !event.altKey);
  }

  stop() {
    if (this.drag) this.editor.endDrag();
    this.drag = this.pressed = null;
    this.isMoved = false;
  }

  dragTo(at, snaps) {
    if (this.drag.kind === "point") this.dragPoint(at, snaps);
    else this.dragWrap(at, snaps);
  }

  // Moves a via point over the surface of its link, or parallel to the screen where its link is not under the pointer.
  dragPoint(at, snaps) {
    const { editor, drag } = this, muscle = editor.document.muscle(drag.muscle), point = muscle && muscle.points[drag.index];
    if (!point) return;
    const target = placeAt(editor, at, snaps), isOnLink = target && (target.link === point.link || target.axis);
    const place = isOnLink ? target.place : onPlane(rayAt(editor.camera, editor.canvas, ...at), editor.camera, editor.worldOf(point));
    editor.setHint(isOnLink ? target : { place, text: `${point.link}: not on its surface` });
    editor.change(() => { point.position = editor.localOf(point.link, place); }, "drag");
  }

  dragWrap(at, snaps) {
    const { editor, drag } = this, wrap = editor.document.wrap(drag.wrap);
    if (!wrap) return;
    const { centre, axes } = editor.frameOf(wrap), ray = rayAt(editor.camera, editor.canvas, ...at);
    const free = onPlane(ray, editor.camera, drag.part === "centre" ? centre : drag.place), least = 1e-3 * editor.act.reach;
    if (drag.part === "centre") this.dragCentre(wrap, free, at, snaps);
    else if (drag.part === "axis") this.dragAxis(wrap, sum(free, centre, -1), snaps);
    else {
      const isRound = wrap.shape !== "ellipsoid", i = "xyz".indexOf(drag.part), away = sum(free, centre, -1);
      const across = wrap.shape === "cylinder" ? sum(away, axes[2], -dot(away, axes[2])) : away;
      const radius = tidy([Math.max(least, isRound ? Math.hypot(...across) : Math.abs(alongAxis({ place: centre, direction: axes[i] }, ray)))])[0];
      editor.change(() => { if (i === 0) wrap.radius = radius; else wrap.half_axes[i - 1] = radius; }, "drag");
    }
  }

  // Moves the centre parallel to the screen, or to the axis of a joint.
  dragCentre(wrap, free, at, snaps) {
    const { editor } = this, ray = rayAt(editor.camera, editor.canvas, ...at), snapped = snaps && snapToAxis(editor, ray, at, null);
    editor.setHint(snapped || null);
    editor.change(() => { wrap.position = editor.localOf(wrap.link, snapped ? snapped.place : free); }, "drag");
  }

  dragAxis(wrap, away, snaps) {
    const { editor } = this, free = unit(away), snapped = snaps ? snapDirection(editor, wrap, free) : { direction: free, text: "" };
    editor.setHint(snapped.text ? { place: editor.frameOf(wrap).centre, text: snapped.text } : null);
    editor.change(() => { wrap.rpy = turnedTo(wrap.rpy, directionToLink(editor.poses[wrap.link], snapped.direction)); }, "drag");
  }
}
