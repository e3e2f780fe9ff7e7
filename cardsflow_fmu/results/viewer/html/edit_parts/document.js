// The edited document: muscles and wrap surfaces, with undo and redo. Each function changes the data of a document.

class EditDocument {
  constructor(data) {
    this.data = data;
    this.markSaved();
    this.past = [];
    this.future = [];
    this.key = null;
    this.onchange = () => {};
  }

  // Considers the current data as saved.
  markSaved() { this.saved = JSON.stringify(this.data); }

  get isChanged() { return JSON.stringify(this.data) !== this.saved; }

  muscle(name) { return this.data.muscles.find(muscle => muscle.name === name); }
  wrap(name) { return this.data.wraps.find(wrap => wrap.name === name); }

  // Changes the data; successive changes with the same key, such as those of a drag, are a single step.
  change(edit, key = null) {
    const before = JSON.stringify(this.data), result = edit(this.data);
    if (JSON.stringify(this.data) === before) return result;
    if (key === null || key !== this.key) this.past.push(before);
    this.key = key;
    this.future = [];
    this.onchange();
    return result;
  }

  endStep() { this.key = null; }
  undo() { this.swap(this.past, this.future); }
  redo() { this.swap(this.future, this.past); }

  swap(from, to) {
    if (!from.length) return;
    to.push(JSON.stringify(this.data));
    this.data = JSON.parse(from.pop());
    this.key = null;
    this.onchange();
  }
}

// Returns the first name such as `muscle_2` that no item has.
function freeName(items, stem) {
  for (let i = 1; ; i++) if (!items.some(item => item.name === `${stem}_${i}`)) return `${stem}_${i}`;
}

// Inserts a via point before point i; a wrap between the neighbours stays before the new point.
function insertPoint(muscle, i, point) {
  muscle.points.splice(i, 0, point);
  for (const wrap of muscle.wraps) if (wrap.segment >= i) wrap.segment += 1;
}

function deletePoint(muscle, i) {
  muscle.points.splice(i, 1);
  for (const wrap of muscle.wraps) if (wrap.segment >= i) wrap.segment -= 1;
  dropLooseWraps(muscle);
}

// Removes wraps without a via point before or after them.
function dropLooseWraps(muscle) {
  muscle.wraps = muscle.wraps.filter(wrap => wrap.segment >= 0 && wrap.segment < muscle.points.length - 1);
}

function swapPoints(muscle, i, j) {
  [muscle.points[i], muscle.points[j]] = [muscle.points[j], muscle.points[i]];
}

// Adds a wrap behind the wraps of the same and of earlier segments.
function addRoute(muscle, surface, segment) {
  const at = muscle.wraps.findIndex(wrap => wrap.segment > segment);
  muscle.wraps.splice(at < 0 ? muscle.wraps.length : at, 0, { surface, segment, side: 0 });
}

function deleteWrap(data, name) {
  data.wraps = data.wraps.filter(wrap => wrap.name !== name);
  for (const muscle of data.muscles) muscle.wraps = muscle.wraps.filter(wrap => wrap.surface !== name);
}

function renameWrap(data, name, other) {
  data.wraps.find(wrap => wrap.name === name).name = other;
  for (const muscle of data.muscles) for (const wrap of muscle.wraps) if (wrap.surface === name) wrap.surface = other;
}

// Returns why a name cannot be given to an item of a list, or an empty text.
function nameProblem(items, item, name) {
  if (!name) return "a name must not be empty";
  return items.some(other => other !== item && other.name === name) ? `${name} exists already; choose another name` : "";
}
