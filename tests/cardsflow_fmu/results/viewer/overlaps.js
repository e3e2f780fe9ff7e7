// Returns pairs of texts that overlap in the window, and texts that leave it.
(() => {
  const texts = [], walk = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (walk.nextNode()) {
    const node = walk.currentNode, parent = node.parentElement;
    if (!node.data.trim() || /^(SCRIPT|STYLE|NOSCRIPT|OPTION|SELECT)$/.test(parent.tagName) || !parent.checkVisibility()) continue;
    const range = document.createRange();
    range.selectNodeContents(node);
    for (const r of range.getClientRects()) {
      let [left, top, right, bottom] = [r.left, r.top, r.right, r.bottom];
      for (let e = parent; e; e = e.parentElement) {
        if (getComputedStyle(e).overflow === "visible") continue;
        const c = e.getBoundingClientRect();
        [left, top, right, bottom] = [Math.max(left, c.left), Math.max(top, c.top), Math.min(right, c.right), Math.min(bottom, c.bottom)];
      }
      if (right - left > 1 && bottom - top > 1) texts.push({ text: node.data.trim(), parent, left, top, right, bottom });
    }
  }
  const found = [];
  for (let i = 0; i < texts.length; i++) for (let j = 0; j < i; j++) {
    const a = texts[i], b = texts[j];
    if (a.parent !== b.parent && Math.min(a.right, b.right) - Math.max(a.left, b.left) > 1 && Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 2) found.push([a.text, b.text]);
  }
  for (const t of texts) if (t.right > innerWidth + 1 || t.left < -1) found.push([t.text, "window"]);
  return found;
})()
