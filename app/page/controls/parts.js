// The parts of the panel around the sliders: scenes, actions, system and solver, switches, key. Each has an element, and
// a function that draws the accepted values.

import { refusalOf, typedField } from "./field.js";
import { button, choose, element, emit, labelled, listen, options, setText } from "../shared/dom.js";

const NARROW = matchMedia("(max-width: 1000px)");

// Numbers of one's own are shown, but not where they would push the figures some screens down; a refusal always is.
export const opensItself = (own, refused) => refused || (own && !NARROW.matches);

export function folded(title, ...content) {
  return element("details", "more", [element("summary", "", title), ...content]);
}

// The scenes of the paper and, below them, published systems of others.
export function scenes({ scenes: list, shelf }, link) {
  const box = element("fieldset", "scenes");
  const first = element("div", "tiles");
  const others = element("div", "tiles");
  const published = element("div", "tiles wide");
  const folds = [["More scenes", others], ["Other systems", published]].map(([name, tiles]) => {
    return element("details", "others", [element("summary", "", name), tiles]);
  });
  const origin = element("small", "origin"); // of the published system that is shown
  published.after(origin);
  const make = (scene, place) => {
    const made = button([scene.title, element("small", "", scene.figure)], "", () => link.act({ scene: scene.key }));
    made.title = scene.tooltip;
    made.dataset.scene = scene.key;
    place.append(made);
    return made;
  };
  const buttons = [
    ...list.map((scene) => make(scene, scene.first ? first : others)),
    ...shelf.map((system) => make(system, published)),
  ];
  const row = element("div", "folds of-scenes", folds);
  box.append(element("legend", "", "Scenes"), first, row);
  const draw = (shown) => {
    for (const made of buttons) made.setAttribute("aria-pressed", String(made.dataset.scene === shown.scene));
    if (others.querySelector("[aria-pressed=true]")) folds[0].open = true;
    // Eight systems and a source would push the sliders out of view: the folded box names the one that is shown.
    const pressed = published.querySelector("[aria-pressed=true]");
    setText(folds[1].firstChild, pressed ? `Other systems: ${pressed.firstChild.data}` : "Other systems");
    setText(origin, pressed?.title ?? "");
  };
  return { element: box, draw };
}

export function actions({ opening }, link) {
  const row = element("div", "row actions");
  const undo = button("↶ Undo", "Undo the last move (Ctrl+Z)", () => link.act({ undo: true }));
  const redo = button("↷ Redo", "Redo (Ctrl+Shift+Z)", () => link.act({ redo: true }));
  const reset = button("Reset", "Back to the opening scene, its ranges, no pins and no code (R)", () => link.act({ reset: true }));
  const pin = button("Pin", "Keep this result, to compare others with it in curves and a table (P)",
    () => link.act({ pin: pin.getAttribute("aria-pressed") !== "true" }));
  listen("toggle-pin", () => pin.click());
  row.append(pin, reset, undo, redo); // what has nothing to do is not seen
  const draw = (shown) => {
    undo.disabled = !shown.undo;
    redo.disabled = !shown.redo;
    reset.disabled = undo.disabled && redo.disabled && shown.scene === opening;
    pin.setAttribute("aria-pressed", String(shown.pinned));
  };
  return { element: row, draw };
}

// Where both runs start: folded while that is rest.
export function startDetails(spec, link) {
  const head = element("summary");
  const parts = spec.starts.map((number) => numberRow(number, link));
  const names = spec.starts.map(({ name }) => name);
  const rest = button("From rest", "Start both runs from rest, as a scene does",
    () => link.set({ zero_start: "rest", ...Object.fromEntries(names.map((name) => [name, "0"])) }), "rest");
  const grid = element("div", "numbers starts", parts.map((part) => part.element));
  const box = element("details", "more", [head, grid, rest]);
  let own = false;
  const draw = (shown) => {
    const was = own;
    own = shown.texts.zero_start === "zero" || names.some((name) => shown.texts[name] !== "0");
    head.textContent = `Start: ${own ? "own" : "rest"}`;
    head.title = `Both runs start from ${own ? "an own start" : "rest"}`;
    rest.disabled = !own;
    if (opensItself(own && !was, names.includes(shown.refused.name))) box.open = true;
  };
  return { element: box, parts: [...parts, { draw }] };
}

// The solver: folded, since it is seldom changed; open if one number is not the default, or is refused.
export function solverDetails(spec, link) {
  const head = element("summary");
  const parts = spec.solver.map((row) => (row.listed ? selectRow : numberRow)(row, link));
  const switches = spec.solverSwitches.map((choice) => switchRow(choice, link));
  const grid = element("div", "numbers", parts.map((part) => part.element));
  const box = element("details", "more solver", [head, grid, ...switches.map((part) => part.element)]);
  const names = [...spec.solver, ...spec.solverSwitches].map(({ name }) => name);
  let opened = false;
  const draw = (shown) => {
    const changed = names.some((name) => shown.texts[name] !== spec.defaults[name]);
    setText(head, changed ? "Solver: own" : "Solver");
    if (opensItself(changed && !opened, names.includes(shown.refused.name))) box.open = opened = true;
    for (const { name, element } of switches) {
      if (name === "without_solution") element.hidden = shown.texts.status !== "end";
      if (name === "damper") element.hidden = !spec.dampedByRestitution.includes(shown.texts.law);
    }
  };
  return { element: box, parts: [...parts, ...switches, { draw }] };
}

// A choice of many, with the reason where it was refused.
function selectRow(choice, link) {
  const refusal = refusalOf(choice.name);
  const [select, box] = chooserOf(choice, Object.entries(choice.choices), (value) => link.set({ [choice.name]: value }));
  box.append(refusal.element);
  const draw = (shown, isLatest) => {
    refusal.draw(shown, select);
    if (isLatest) choose(select, shown.texts[choice.name]);
  };
  return { name: choice.name, element: box, draw };
}

// A list with its name, which calls `act` with what is chosen.
function chooserOf({ name, label: words, doc = "" }, choices, act) {
  const label = element("label", "", words, { title: doc, for: `vibroscope-${name}` });
  const select = element("select", "", options(choices), { name: label.htmlFor, id: label.htmlFor });
  select.addEventListener("change", () => act(select.value));
  return [select, element("div", "choice", [label, select])];
}

// A number; it is hidden where the setting has none of that name.
export function numberRow(number, link) {
  const symbol = element("span");
  const hint = element("small");
  const label = element("label", "", [symbol, " ", hint], { for: `vibroscope-${number.name}-typed` });
  const under = element("div", "under");
  const field = typedField(number, link, under);
  const box = element("div", "number", [label, field.typed, under]);
  const draw = (shown, isLatest) => {
    box.hidden = !shown.fields[number.name];
    if (box.hidden) return;
    const { label: name, name: words } = shown.fields[number.name];
    setText(symbol, name);
    setText(hint, words);
    field.draw(shown, isLatest);
  };
  return { element: box, draw };
}

export function switchRow(choice, link) {
  const box = element("fieldset", "switch", [element("legend", "", choice.label, { title: choice.doc })]);
  const row = element("div", "row");
  const inputs = new Map();
  for (const [value, text] of Object.entries(choice.choices)) {
    const [radio, label] = labelled(element("span", "", text), { type: "radio", name: `vibroscope-${choice.name}`, value });
    radio.addEventListener("change", () => link.set({ [choice.name]: value }));
    row.append(label);
    inputs.set(value, radio);
  }
  const refusal = refusalOf(choice.name);
  box.append(row, refusal.element);
  const draw = (shown, isLatest) => {
    refusal.draw(shown, box);
    if (isLatest) inputs.get(shown.texts[choice.name]).checked = true;
  };
  return { name: choice.name, element: box, draw };
}

const SPEEDS = [0.05, 0.1, 0.25, 0.5, 1];

// How fast the bodies move; it concerns this browser alone.
export function speedRow() {
  const choices = SPEEDS.map((value) => [value, `${value} period${value < 1 ? "s" : ""}/s`]);
  const choice = { name: "speed", label: "Speed of the motion" };
  const [select, box] = chooserOf(choice, choices, (value) => emit("speed", { value: Number(value) }));
  select.value = "0.1";
  return { element: box, draw: () => {} };
}

export function key() {
  const list = element("dl", "key", "", { "aria-label": "Key" });
  const section = element("dt", "section", ["●", element("span", "", "◇")]);
  list.append(
    element("dt", "reference"), element("dd", "", "reference: exact, impact law"),
    element("dt", "penalty"), element("dd", "", "penalty: spring, damper, time step"),
    section, element("dd", "", "state once a period"),
  );
  return { element: list, draw: () => {} };
}
