// The head of the page.

import { takeAwayMenu } from "./take_away.js";
import { tour } from "./tour.js";
import {
  adaptToTouch, button, element, emit, follow, inPage, labelled, listen, preferences, setText, whenever,
} from "../shared/dom.js";
import { fitFigure } from "../shared/fit.js";
import { darken, themeButton } from "../shared/theme.js";

const ONLY_TOUCH = matchMedia("(hover: none) and (pointer: coarse)"); // no keys to list

export function render({ model }) {
  const root = element("header", "head");
  const title = element("h1", "", "Vibroscope");
  const keys = keyDialog(() => tour(root, true), themeButton(model));
  const takeAway = takeAwayMenu(model);
  const tools = element("div", "tools", [takeAway.element, button("?", "Tour, keys and help (?)", () => keys.open())]);
  const { tabs, views } = navigation(model);
  const bar = element("div", "bar", [title, tabs, tools]);
  const messages = [compilationLine(model), messageLine(model, "error", "alert"), messageLine(model, "note", "status")];
  root.append(skipLink(), bar, question(model, views), ...messages, summary(model), keys.element, glossaryNote());
  shortcuts(root, keys, takeAway);
  const adaptFigures = () => { darken(); adaptToTouch(allFigures()); fitFigures(); };
  for (const name of ["view", "offers"]) model.on(name, () => whenDrawn(root, adaptFigures)); // there are other figures
  model.on("view", () => whenDrawn(root, () => markPanel(model)));
  whenDrawn(root, () => { adaptFigures(); markMain(); markPanel(model); tour(root, false); watchModels(() => whenDrawn(root, adaptFigures)); });
  return root;
}

// The first stop of the keyboard leads past tabs and controls to what the open view has found.
function skipLink() {
  return button("Skip to the results", "", () => {
    const found = [".line.verdict", "section.study", ".tab-area"].map((each) => inPage(each)).find((each) => each?.checkVisibility());
    found.tabIndex = Math.max(found.tabIndex, -1);
    found.setAttribute("tabindex", found.tabIndex);
    found.focus();
  }, "skip");
}

// Marks the area of the tabs as the main landmark. It scrolls, so the keyboard must be able to focus it.
function markMain() {
  const area = inPage(".tab-area");
  area?.setAttribute("role", "main");
  if (area) area.tabIndex = 0;
}

// Marks the open view as the panel of its tab; it lies in another shadow root, so it has the name, not a reference.
function markPanel(model) {
  const places = inPage(".tab-area")?.shadowRoot?.querySelectorAll(".place") ?? [];
  const open = [...places].find((place) => place.checkVisibility());
  const title = model.tabs.flatMap(([, views]) => views).find(([key]) => key === model.view)[1];
  if (!open || (open.ariaLabel && open.ariaLabel !== title)) return setTimeout(() => markPanel(model), 50); // it comes
  open.role = "tabpanel";
  open.ariaLabel = title;
}

// A figure of a view that has just been opened is in the document some time before it is on the page.
const fitFigures = () => whenever(() => allFigures().map(fitFigure).every(Boolean), () => {});

// Calls `act` when the figures are drawn and `root` is in the page; either may be first.
function whenDrawn(root, act) {
  setTimeout(() => whenever(() => root.isConnected && window.Bokeh?.documents[0]?.is_idle, act));
}

// Curves of pins, of a measurement or of a search come when the server has made them, before or after their words.
function watchModels(act) {
  const isModel = (value) => Boolean(value?.properties);
  Bokeh.documents[0].on_change(({ value }) => { if (isModel(value) || (Array.isArray(value) && isModel(value.at(-1)))) act(); });
}

// Two lists of the same kind: the tabs, and the views of the open one where it has several. A tab opens the view that was
// open last in it.
function navigation(model) {
  let last = model.view; // that was asked for, here or elsewhere on the page, or that the server has opened
  let awaited = false;
  listen("view", ({ value }) => {
    last = value;
    awaited = value !== model.view;
  });
  const open = (key) => { if (key !== last) emit("view", { value: key }); };
  const shown = model.tabs.map(([, [[first]]]) => first); // the view that each tab opens
  const tabs = tabList("Parts of the page", model.tabs.map(([title]) => title), (at) => open(shown[at]));
  tabs.buttons.forEach((tab, at) => { tab.title = `${tab.textContent} (Shift+${at + 1})`; });
  const lists = model.tabs.filter(([, entries]) => entries.length > 1).map(([title, entries]) => {
    const keys = entries.map(([key]) => key);
    return { keys, ...tabList(`Views of ${title}`, entries.map((entry) => entry[1]), (at) => open(keys[at])) };
  });
  const views = element("div", "views", lists.map((list) => list.element));
  listen("tab-number", ({ value }) => tabs.buttons[value]?.click());
  const draw = () => {
    if (model.view === last) awaited = false;
    if (!awaited) last = model.view;
    const at = model.tabs.findIndex(([, entries]) => entries.some(([key]) => key === model.view));
    shown[at] = model.view;
    tabs.select(at);
    for (const { keys, element: list, select } of lists) {
      select(keys.indexOf(model.view));
      list.hidden = !keys.includes(model.view);
    }
  };
  follow(model, "view", draw);
  return { tabs: tabs.element, views };
}

function tabList(label, titles, open) {
  const buttons = titles.map((title, at) => button(title, "", () => open(at)));
  for (const each of buttons) each.setAttribute("role", "tab");
  const list = element("div", "tabs", buttons, { role: "tablist", "aria-label": label });
  list.addEventListener("keydown", (event) => {
    const step = { ArrowRight: 1, ArrowLeft: -1, Home: -Infinity, End: Infinity }[event.key];
    if (!step) return;
    event.preventDefault();
    const count = buttons.length;
    const now = buttons.indexOf(event.target); // the open tab lags behind quick presses
    const next = Number.isFinite(step) ? (now + step + count) % count : step < 0 ? 0 : count - 1;
    buttons[next].focus();
    buttons[next].click();
  });
  const select = (chosen) => buttons.forEach((each, at) => {
    each.setAttribute("aria-selected", String(at === chosen));
    each.tabIndex = at === chosen ? 0 : -1;
  });
  return { element: list, buttons, select };
}

function question(model, views) {
  const box = element("div", "question");
  const caption = element("p", "caption");
  const draw = () => {
    caption.textContent = model.caption;
    const cells = inPage(".explore-grid")?.shadowRoot?.querySelectorAll(".cell") ?? [];
    for (const cell of cells) cell.toggleAttribute("data-look", cell.classList.contains(model.look));
  };
  whenDrawn(box, draw);
  follow(model, ["caption", "look", "view"], draw);
  box.append(element("p", "asked", model.question), views, caption);
  return box;
}

// On a first start the solvers are compiled, which takes some minutes. Moves wait until those of their setting are ready.
const COMPILING = {
  false: "First start: the solvers are being compiled for this machine. Until then the page shows what was shipped with it; "
    + "the figures follow your moves as soon as those of this page are ready.",
  true: "First start: Explore follows your moves now. Its verdicts, the other tabs, and what is set under System and Solver, "
    + "may wait: the rest is being compiled.",
};

function compilationLine(model) {
  const text = element("p", "", "", { role: "status" });
  const bar = element("progress", "", "", { "aria-label": "Solvers compiled" });
  const line = element("div", "compiling", [text, bar, element("span", "what")]);
  follow(model, "compiling", () => {
    const { share, what, compiled } = model.compiling;
    line.hidden = share === undefined;
    if (line.hidden) return;
    setText(text, COMPILING[compiled > 0]);
    bar.value = share;
    line.lastChild.textContent = what;
  });
  return line;
}

// What was refused or has failed, or what a file that was loaded leaves out.
function messageLine(model, name, role) {
  const text = element("span");
  const close = button("Close", "Close this message", () => { model[name] = ""; });
  const line = element("div", `message ${name}`, [text, close], { role });
  follow(model, name, () => {
    text.textContent = model[name];
    line.hidden = !model[name];
  });
  return line;
}

function summary(model) {
  const text = element("p", "screen-reader summary", "", { "aria-live": "polite" });
  follow(model, "summary", () => { text.textContent = model.summary; });
  return text;
}

function glossaryNote() {
  const note = element("div", "entry", "", { role: "dialog" });
  note.popover = "auto"; // Escape and a click elsewhere close it
  const head = element("strong");
  const text = element("p");
  const help = button("All terms", "All terms, in Help", () => { note.hidePopover(); emit("view", { value: "help" }); });
  const close = button("Close", "", () => note.hidePopover());
  const more = Object.assign(element("a"), { textContent: "Documentation", target: "_blank" });
  const row = element("div", "row", [more, help, close]);
  note.append(head, text, row);
  let from = null;
  listen("explain", ({ entry: [title, meaning, , read], term }) => {
    from = term;
    more.href = `docs/${read}`;
    head.textContent = title;
    text.textContent = meaning;
    note.setAttribute("aria-label", `${title}: ${meaning}`);
    note.showPopover();
    const at = term.getBoundingClientRect();
    const below = at.bottom + 6 + note.offsetHeight < innerHeight;
    note.style.left = `${Math.max(8, Math.min(at.left, innerWidth - note.offsetWidth - 8))}px`;
    note.style.top = `${below ? at.bottom + 6 : Math.max(8, at.top - 6 - note.offsetHeight)}px`;
    close.focus();
  });
  note.addEventListener("toggle", ({ newState }) => { if (newState === "closed" && from?.isConnected) from.focus({ preventScroll: true }); });
  return note;
}

const KEYS = [
  ["1 2 3 4", "scenes [A] to [D]"],
  ["Shift + 1 2 3 …", "tabs"],
  ["← →", "move the slider that has the focus"],
  ["Space", "play or pause the motion"],
  [", .", "one step back or forth in time"],
  ["P", "pin this result, or unpin it"],
  ["R", "reset"],
  ["Ctrl + Z, Ctrl + Shift + Z", "undo, redo"],
  ["T", "take away"],
  ["L", "light or dark"],
  ["Escape", "close; in a field: back to the last good value"],
  ["?", "this list"],
];

function keyDialog(startTour, theme) {
  const dialog = element("dialog", "keys", "", { "aria-label": "Tour, keys and help" });
  const list = element("dl");
  for (const [key, what] of KEYS) list.append(element("dt", "", key), element("dd", "", what));
  const words = element("span", "", "single keys work (switch off if you use speech input or a switch)");
  const [box, single] = labelled(words, { type: "checkbox", checked: singleKeys() });
  single.className = "single";
  box.addEventListener("change", () => preferences.set("keys", box.checked ? "on" : "off"));
  const then = (act) => () => { dialog.close(); act(); };
  const row = element("div", "row", [
    button("Tour", "From the problem to a suggestion, in six steps", then(startTour)),
    theme,
    button("Open Help", "", then(() => emit("view", { value: "help" }))),
    button("Close", "", then(() => {})),
  ]);
  if (!ONLY_TOUCH.matches) dialog.append(element("h2", "", "Keys"), list, single);
  dialog.append(row);
  return { element: dialog, open: () => dialog.showModal() };
}

const singleKeys = () => preferences.get("keys") !== "off";

function shortcuts(root, keys, takeAway) {
  document.addEventListener("keydown", (event) => {
    const target = event.composedPath()[0];
    if (root.querySelector("dialog:modal")) return; // the keys are those of the dialog
    const typing = target.matches?.("input[type=text], textarea, select, [contenteditable]");
    if ((event.ctrlKey || event.metaKey) && event.key.toLowerCase() === "z" && !event.altKey && !typing) {
      event.preventDefault();
      emit(event.shiftKey ? "redo" : "undo");
      return;
    }
    if (typing || event.ctrlKey || event.metaKey || event.altKey || !singleKeys()) return;
    const digit = /^Digit([1-9])$/.exec(event.code)?.[1];
    const act = digit ? (event.shiftKey ? () => emit("tab-number", { value: digit - 1 })
                                        : () => "ABCD"[digit - 1] && emit("scene", { value: "ABCD"[digit - 1] }))
      : singleKey(event, target, { keys, takeAway });
    if (!act) return;
    event.preventDefault();
    act();
  });
}

function singleKey(event, target, { keys, takeAway }) {
  if (event.key === " ") return target.matches?.("button, summary, input, a") ? null : () => emit("play");
  return {
    "?": () => keys.open(),
    ",": () => emit("step", { value: -1 }),
    ".": () => emit("step", { value: 1 }),
    p: () => emit("toggle-pin"),
    r: () => emit("reset"),
    t: () => takeAway.toggle(),
    l: () => emit("theme"),
  }[event.key.toLowerCase()];
}

const allFigures = () => [...Bokeh.documents[0].all_models].filter((model) => model.type === "Figure");
