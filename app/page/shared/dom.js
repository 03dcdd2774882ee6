// Shared by the components of the page. They write texts only, so that no text can become markup.

// An element with a text, or with an array of texts and elements, in it.
export function element(tag, className = "", content = "", attributes = {}) {
  const made = filled(document.createElement(tag), content, attributes);
  if (className) made.className = className;
  return made;
}

export function svgElement(tag, attributes = {}, content = "") {
  return filled(document.createElementNS("http://www.w3.org/2000/svg", tag), content, attributes);
}

function filled(made, content, attributes) {
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  if (content) made.append(...[content].flat());
  return made;
}

// A card: a section with a name for screen readers.
export function card(className, name) {
  return element("section", className, "", { "aria-label": name });
}

// Draws now, and whenever a parameter of these names changes.
export function follow(model, names, draw) {
  model.on(names, draw);
  draw();
}

// Draws a card so, and explains its terms.
export function drawCard(root, model, names, draw) {
  follow(model, names, draw);
  explainTerms(root);
  return root;
}

// Writes a text where it has changed; terms that are marked in it stay otherwise.
export function setText(node, text) {
  if (node.textContent !== text) node.textContent = text;
}

// Writes a text, and shows its node while there is one.
export function say(node, text) {
  setText(node, text || "");
  node.hidden = !text;
}

// Chooses an entry of a list where another one is chosen: Chromium examines all fields of a page whenever a script chooses
// one, also the same: 14 % more of the main thread for a key press.
export function choose(select, value) {
  if (select.value !== value) select.value = value;
}

export function button(text, name, act, className = "") {
  const made = element("button", className, text);
  made.type = "button";
  if (name) {
    made.title = name;
    // Users of voice control say the text on the button, so the accessible name must contain it.
    made.setAttribute("aria-label", name.includes(text) ? name : `${text}: ${name}`);
  }
  made.addEventListener("click", act);
  return made;
}

// An input in its label: the words, or an element with them, before it, or behind what is ticked. Its title is its name.
export function labelled(words, properties, attributes = {}) {
  const field = Object.assign(element("input", "", "", attributes), properties);
  if (field.title) field.setAttribute("aria-label", field.title);
  const label = element("label", "", ["checkbox", "radio"].includes(field.type) ? [field, words] : [words, field]);
  return [field, label];
}

// A hidden field that chooses a file, for which a button stands.
export function fileField(take, accept = "") {
  const field = Object.assign(element("input"), { type: "file", accept, hidden: true });
  field.addEventListener("change", () => {
    const [file] = field.files;
    field.value = ""; // so that the same file can be chosen again
    if (file) take(file);
  });
  return field;
}

// Acts at a click and at the keys that press a button, of an element that is none.
export function onPress(node, act) {
  const pressed = (event) => {
    event.preventDefault(); // a label would hand the click on to its field
    event.stopPropagation();
    act();
  };
  node.addEventListener("click", pressed);
  node.addEventListener("keydown", (event) => { if (event.key === "Enter" || event.key === " ") pressed(event); });
}

// Escape and a click elsewhere close an open menu, a `details`: also a click whose target lets nobody else have it.
export function closeFromElsewhere(menu) {
  const first = { capture: true };
  document.addEventListener("keydown", (event) => { if (event.key === "Escape") menu.open = false; }, first);
  document.addEventListener("click", (event) => { if (!event.composedPath().includes(menu)) menu.open = false; }, first);
}

// Entries of a list, from pairs of value and text.
export const options = (pairs) => pairs.map(([value, text]) => Object.assign(element("option", "", text), { value }));

// How far something is, from 0 to 1, and the button that ends it; without `share` that is not known.
export function progressRow(name, stop) {
  const bar = Object.assign(element("progress", "", "", { "aria-label": name }), { max: 1 });
  const row = element("div", "running", [bar, stop]);
  const show = (on, share) => {
    row.hidden = !on;
    if (share !== undefined) bar.value = share;
  };
  return { element: row, show };
}

// Each component lies in a shadow root of its own, so components exchange events through the document.
export const emit = (name, detail = {}) => document.dispatchEvent(new CustomEvent(`vibroscope:${name}`, { detail }));
export const listen = (name, act) => document.addEventListener(`vibroscope:${name}`, (event) => act(event.detail));

// Like `listen`, until the function that it returns is called.
export const listenUntil = (name, act) => {
  const heard = (event) => act(event.detail);
  document.addEventListener(`vibroscope:${name}`, heard);
  return () => document.removeEventListener(`vibroscope:${name}`, heard);
};

// Preferences that this browser keeps; a browser may forbid storage, and then they are not kept.
export const preferences = {
  get: (name) => {
    try { return localStorage.getItem(`vibroscope-${name}`); } catch { return null; }
  },
  set: (name, value) => {
    try { localStorage.setItem(`vibroscope-${name}`, value); } catch { /* not kept */ }
  },
};

// A function that calls `act` once for all its calls in the present task, or before the next frame.
export const oncePer = (schedule, act) => {
  let due = false;
  return () => {
    if (!due) schedule(() => { due = false; act(); });
    due = true;
  };
};

// Calls `act` once `ready` holds: what a component needs comes a moment after it, on a loaded machine a long time.
export function whenever(ready, act) {
  if (ready()) act();
  else setTimeout(() => whenever(ready, act), 25);
}

// Shows a cue at the lower edge of a box that scrolls, as long as there is more below (`scroll_cue.css`). The box is
// ``content`` itself, or else the host of its component.
export function cueScroll(content, itself = false) {
  const cue = element("div", "cue", "▾ more");
  cue.ariaHidden = "true";
  content.append(cue);
  let box = null;
  const draw = () => box.toggleAttribute("data-more", box.scrollHeight - box.scrollTop - box.clientHeight > 12);
  const sizes = new ResizeObserver(() => {
    if (!box) {
      box = itself ? content : content.getRootNode().host;
      box.addEventListener("scroll", draw, { passive: true });
      sizes.observe(box);
    }
    draw();
  });
  for (const each of [content, ...content.children]) sizes.observe(each);
  return content;
}

// Models and views of Bokeh by name; null while there are none. Bokeh itself searches all models at each call.
const modelCache = new Map();
export const modelOf = (name) => {
  const doc = window.Bokeh?.documents[0];
  if (modelCache.get(name)?.document !== doc || !doc) {
    const model = doc?.get_model_by_name(name);
    if (!model) return null;
    modelCache.set(name, model);
  }
  return modelCache.get(name);
};
export const viewOf = (name) => {
  const model = modelOf(name);
  return model ? Bokeh.index.find_one_by_id(model.id) : null;
};
// Option of changes that are not sent to the server.
export const LOCAL = { sync: false };

// On a touch screen a drag over a figure scrolls the page; a tap still shows values, and sets what a click does.
export function adaptToTouch(figures) {
  if (!matchMedia("(pointer: coarse)").matches) return;
  for (const tool of figures.flatMap((figure) => figure.toolbar.tools)) {
    if (["BoxZoomTool", "PanTool", "WheelZoomTool"].includes(tool.type)) tool.setv({ active: false }, LOCAL);
  }
}

// Gives figures below each other the same margins, the widest that any of them needs now, so that their common axis is
// aligned.
export function alignFrames(views) {
  const least = (side) => Math.max(...views.map(({ model }) => model[`min_border_${side}`]));
  const [left, right] = [least("left"), least("right")];
  const fit = () => {
    const needed = (least, side) => Math.ceil(Math.max(least, ...views.map((view) => widthOfAxes(view, side))));
    const min_border_left = needed(left, "left");
    const min_border_right = needed(right, "right");
    for (const { model } of views) model.setv({ min_border_left, min_border_right }, LOCAL);
  };
  const fitSoon = oncePer(requestAnimationFrame, fit);
  for (const { model } of views) {
    model.properties.inner_width.change.connect(fitSoon);
    const ranges = [model.y_range, ...Object.values(asObject(model.extra_y_ranges))];
    for (const range of ranges) for (const end of ["start", "end"]) range.properties[end]?.change.connect(fitSoon);
    for (const axis of [...model.left, ...model.right]) axis.properties.axis_label?.change.connect(fitSoon);
  }
  fit();
}
// Columns of a source; Bokeh keeps them as a Map or as an object.
export const asObject = (data) => (data instanceof Map ? Object.fromEntries(data) : data);
export const columnsOf = (name) => asObject(modelOf(name)?.data ?? {});

// ---- terms of the glossary ----

const glossary = JSON.parse(document.getElementById("glossary")?.textContent ?? "[]"); // head, text, words that open it, documentation
const entryOf = new Map(glossary.flatMap((entry) => entry[2].map((word) => [word.toLowerCase(), entry])));
const TERM = new RegExp(`(?<![\\p{L}\\p{N}-])(?:${[...entryOf.keys()].sort((a, b) => b.length - a.length).join("|")})(?![\\p{L}\\p{N}-])`, "iu");
// Headings stand before the texts come, which would decide by chance where a first mention is.
const NOT_MARKED = "h2, pre, code, button, a, summary, select, output, svg, strong, [role], [aria-hidden]";
const termStyle = new CSSStyleSheet();
termStyle.replaceSync(`.term { text-decoration: underline dotted; text-decoration-color: var(--line); text-underline-offset: 3px; cursor: help; }
.term:hover { text-decoration-style: solid; }
.term:focus-visible { outline: 2px solid var(--focus); outline-offset: 1px; }`);

// Makes the first mention of each term in a box a button that opens its entry, also when the texts change.
export function explainTerms(box) {
  if (!entryOf.size) return;
  let styled = false;
  const mark = () => {
    if (!styled && box.isConnected) {
      const root = box.getRootNode();
      root.adoptedStyleSheets = [...root.adoptedStyleSheets, termStyle];
      styled = true;
    }
    const texts = document.createTreeWalker(box, NodeFilter.SHOW_TEXT);
    const found = [];
    while (texts.nextNode()) found.push(texts.currentNode);
    const known = new Set();
    for (const text of found) {
      const parent = text.parentElement;
      if (!text.data.trim() || parent.closest("[hidden]")) continue;
      if (parent.className === "term") keepTerm(parent, known);
      else if (hasTerm(text.data) && !parent.closest(NOT_MARKED)) markTerm(text, known);
    }
    changes.takeRecords();
  };
  const changes = new MutationObserver(mark);
  changes.observe(box, { childList: true, subtree: true, characterData: true, attributeFilter: ["hidden"] });
  setTimeout(mark);
}

// Most texts stay from one change to the next.
const withTerm = new Map();
function hasTerm(text) {
  if (!withTerm.has(text)) {
    if (withTerm.size > 1000) withTerm.clear();
    withTerm.set(text, TERM.test(text));
  }
  return withTerm.get(text);
}

// A term that another text before it mentions now is one no longer.
function keepTerm(term, known) {
  const entry = entryOf.get(term.dataset.term);
  if (known.has(entry)) term.replaceWith(...term.childNodes);
  else known.add(entry);
}

function markTerm(text, known) {
  let rest = text;
  for (let match = TERM.exec(rest.data); match; match = TERM.exec(rest.data)) {
    const word = rest.splitText(match.index);
    rest = word.splitText(match[0].length);
    const entry = entryOf.get(match[0].toLowerCase());
    if (known.has(entry)) continue;
    known.add(entry);
    const term = element("span", "term");
    term.dataset.term = match[0].toLowerCase();
    Object.assign(term, { role: "button", tabIndex: 0, ariaHasPopup: "dialog" });
    word.replaceWith(term);
    term.append(word);
    onPress(term, () => emit("explain", { entry, term }));
  }
}

// The first element that matches a selector, in any shadow root.
export function inPage(selector, root = document) {
  const found = root.querySelector(selector);
  if (found) return found;
  for (const host of root.querySelectorAll("*")) {
    const deeper = host.shadowRoot && inPage(selector, host.shadowRoot);
    if (deeper) return deeper;
  }
  return null;
}
