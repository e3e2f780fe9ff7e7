// Fields of the edit panel. Each returns a function that shows the current value, except in the field that has the focus.

// Returns a field set with a title.
function addSection(into, title) {
  const field = element("fieldset", into), legend = element("legend", field, { textContent: title });
  return { field, legend, body: element("div", field) };
}

function addButton(into, textContent, act, title = "") {
  const button = element("button", into, { type: "button", textContent, title });
  button.addEventListener("click", () => { act(); button.blur(); });
  return button;
}

// Adds a field for a number; `empty` is its value without text. set(value) is called while the user types.
function addNumber(into, { name, unit = "", title = "", get, set, done = () => {}, empty, valid = () => "" }) {
  const label = element("label", into, { className: "number", title });
  if (name) element("span", label, { textContent: name });
  const input = element("input", label, { type: "text", inputMode: "decimal", ariaLabel: title || name });
  if (unit) element("small", label, { textContent: unit });
  const show = () => {
    if (document.activeElement === input) return;
    const value = get();
    input.value = value === null || value === undefined ? "" : String(value);
    input.placeholder = empty === undefined ? "" : "none";
    input.setCustomValidity("");
  };
  input.addEventListener("input", () => {
    const text = input.value.trim(), value = text ? Number(text.replace(",", ".")) : empty;
    const problem = value === undefined || Number.isNaN(value) ? "must be a number" : valid(value);
    input.setCustomValidity(problem);
    if (!problem) set(value);
  });
  input.addEventListener("change", () => { done(); input.blur(); show(); });
  input.addEventListener("keydown", event => { if (event.key === "Escape") input.blur(); });
  input.addEventListener("blur", show);
  show();
  return show;
}

// Adds three numbers of a vector.
function addVector(into, names, { unit, title, get, set, done }) {
  const row = element("div", into, { className: "vector" });
  const shows = names.map((name, i) => addNumber(row, { name, unit: i === names.length - 1 ? unit : "", title: `${title} ${name}`, done,
    get: () => get()[i], set: value => set(get().map((old, k) => k === i ? value : old)) }));
  return () => shows.forEach(show => show());
}

// Adds a list of options, which are texts or [value, text].
function addChoice(into, { name, title, options, get, set }) {
  const label = element("label", into, { className: "choice-field" });
  if (name) element("span", label, { textContent: name });
  const select = element("select", label, { ariaLabel: title || name, title: title || name });
  const show = () => {
    const wanted = options().map(option => Array.isArray(option) ? option : [option, option]), text = JSON.stringify(wanted);
    if (text !== select.dataset.options) {
      select.replaceChildren();
      for (const [value, textContent] of wanted) element("option", select, { value, textContent });
      select.dataset.options = text;
    }
    select.value = String(get());
  };
  select.addEventListener("change", () => { set(select.value); show(); select.blur(); });
  show();
  return show;
}

// Adds a field for a name; set(name) returns why it is invalid, or an empty text.
function addName(into, { title, get, set, fail }) {
  const input = element("input", into, { type: "text", className: "name", ariaLabel: title, title, spellcheck: false, maxLength: 200 });
  const show = () => { if (document.activeElement !== input) input.value = get(); };
  input.addEventListener("change", () => {
    if (input.value !== get()) fail(set(input.value.trim()));
    input.blur();
    show();
  });
  input.addEventListener("keydown", event => { if (event.key === "Escape") { input.value = get(); input.blur(); } });
  show();
  return show;
}
