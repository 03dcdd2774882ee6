// The panel System: which bodies, their numbers in the units that are chosen, and a drawing to scale that follows what is typed.

import { numberRow, opensItself, switchRow } from "./parts.js";
import { FLOOR, HIGH, MIDDLE, SIDES, SystemDrawing, WIDE, clamp } from "../shared/bodies.js";
import { choose, element, options, say, setText, svgElement } from "../shared/dom.js";

const DRAWN = { // fields that the drawing follows while they are typed, and what of it they are
  clearance: "clearance", clearance_mm: "clearance", clearance2: "clearance2", clearance2_mm: "clearance2", mass_ratio: "mass", base: "base", base_amplitude_mm: "base",
  mass1_kg: "mass1", mass2_kg: "mass2",
};
const ARROW = 5; // px
const NAME = 70; // px, half of a name

export function systemDetails(spec, link, model) {
  const box = element("details", "more system");
  const head = element("summary");
  const picture = new RestDrawing();
  const kinds = spec.system.map((kind) => switchRow(kind, link));
  const elsewhere = element("p", "refusal", "", { role: "alert" });
  const groups = spec.groups.map((group) => numberGroup(group, link));
  box.append(head, ...kinds.map((part) => part.element), elsewhere, picture.element, ...groups.map((part) => part.element));
  const rows = groups.flatMap((group) => group.rows);
  box.addEventListener("input", () => picture.show(typedLengths(rows, held)));
  let known = null;
  let held = "displacement"; // of the base: another amplitude is no length of the drawing
  const names = rows.map((row) => row.name);
  const draw = (shown) => {
    held = shown.texts.held;
    head.textContent = `System: ${model.system.title}`;
    const away = ["bodies", "stops", ...names].includes(shown.refused.name) && !shown.fields[shown.refused.name];
    say(elsewhere, away && shown.refused.text);
    const own = !known && ["bodies", "stops", ...names].some((name) => name in spec.defaults && shown.texts[name] !== spec.defaults[name]);
    if (opensItself(own, away || names.includes(shown.refused.name))) box.open = true;
    if (known === model.system) return;
    known = model.system;
    picture.follow(known);
  };
  return { element: box, parts: [...kinds, ...groups, { draw }] };
}

// Numbers as they stand in the fields, which the server has not seen yet; only those that are plain.
function typedLengths(rows, held) {
  const found = {};
  for (const { name, element: row, field } of rows) {
    const value = Number(field.value.trim().replace(",", "."));
    if (DRAWN[name] === "base" && held !== "displacement") continue;
    if (DRAWN[name] && !row.hidden && field.value.trim() && Number.isFinite(value)) found[DRAWN[name]] = value;
  }
  const { mass1, mass2, ...rest } = found;
  return mass1 > 0 && mass2 > 0 ? { ...rest, mass: mass2 / mass1 } : rest;
}

// Rows under a title; hidden while none applies.
function numberGroup({ title, numbers }, link) {
  const box = element("fieldset", "numbers", [element("legend", "", title)]);
  const rows = numbers.map((number) => systemRow(number, link));
  box.append(...rows.map((row) => row.element));
  const draw = (shown, isLatest) => {
    const left = rows.find((row) => row.form === row.element.getRootNode().activeElement && !shown.fields[row.name]);
    for (const row of rows) row.draw(shown, isLatest);
    if (left?.form) rows.find((row) => !row.element.hidden && sameForms(row, left))?.form.focus(); // the row in its place
    box.hidden = rows.every((row) => row.element.hidden);
  };
  return { element: box, rows, draw };
}

const sameForms = (one, other) => JSON.stringify(one.forms) === JSON.stringify(other.forms);

// A number; one that has several forms has a choice of the unit, which the server keeps: it then shows the row of that form.
function systemRow(number, link) {
  const row = numberRow(number, link);
  const about = element("small", "about", "", { id: `vibroscope-${number.name}-about` });
  row.element.append(about);
  const field = row.element.querySelector("input");
  const made = { ...row, name: number.name, forms: number.forms, field };
  if (number.forms.length) {
    const units = options(number.forms.map(({ name }) => [name, name]));
    made.form = element("select", "form", units, { "aria-label": `${number.hint}: its unit` });
    made.form.addEventListener("change", () => link.set(number.forms.find(({ name }) => name === made.form.value).set));
    row.element.querySelector("label").after(made.form);
    row.element.classList.add(number.name === "base" ? "worded-forms" : "two-forms");
  }
  const draw = (shown, isLatest) => {
    row.draw(shown, isLatest);
    if (row.element.hidden) return;
    setText(about, shown.fields[number.name].about);
    field.setAttribute("aria-describedby", [field.getAttribute("aria-describedby"), about.id].filter(Boolean).join(" "));
    if (made.form && isLatest) {
      const isSet = ({ set }) => Object.entries(set).every(([field, choice]) => shown.texts[field] === choice);
      choose(made.form, number.forms.find(isSet).name);
      const units = shown.fields[number.name].forms;
      if (units) for (const option of made.form.options) setText(option, units[option.value]);
    }
  };
  return { ...made, draw };
}

// The system at rest: bodies where their springs hold them, the clearance with its length, and how far the base moves.
class RestDrawing extends SystemDrawing {
  constructor() {
    super(["rest"]);
    this.element.setAttribute("class", "at-rest");
    this.dimension = svgElement("g");
    this.below = 34;
    this.element.append(this.dimension);
  }

  follow({ drawing, words, length }) {
    this.drawing = drawing;
    this.length = length;
    this.element.setAttribute("aria-label", words);
    this.show({});
  }

  // `typed`: lengths as the fields have them, and the mass ratio.
  show(typed) {
    const { factor } = this.length;
    const system = { ...this.drawing };
    for (const name of ["clearance", "clearance2", "base"]) if (name in typed) system[name] = typed[name] / factor;
    if (typed.mass > 0) system.mass = typed.mass;
    this.set(system);
    this.fit(0);
    super.show(0, { rest: this.rest });
    this.measure(system);
  }

  measure({ kind, clearance, base }) {
    const { half, right } = this.place;
    const middle = kind === "wall" ? right - half : MIDDLE;
    const hung = kind === "pendulums";
    const y = hung ? HIGH - 4 : FLOOR - SIDES[1] - 14;
    const written = (value) => `${Number((value * this.length.factor).toPrecision(4))} ${this.length.unit}`.trim();
    const faces = [middle - half, middle + half];
    const shapes = [];
    const loaded = Math.abs(this.gap - Math.max(clearance, 0)) > 1e-9 * Math.abs(clearance);
    const atRest = this.gap > 0 ? `gap at rest ${written(this.gap)}` : "pressed together by a load";
    const unloaded = clearance < 0 ? "preload: " : "";
    const size = clearance ? `g₀ = ${written(clearance)}` : "touch at rest";
    const name = loaded ? `${atRest}, g₀ = ${written(clearance)}` : unloaded + size;
    const x = clamp((faces[0] + faces[1]) / 2, NAME, WIDE - NAME);
    shapes.push(...(this.gap > 0 ? [between(faces, y, hung ? -18 : 14)] : []), svgElement("text", { class: "length-name", x, y: hung ? y + 13 : y - 5 }, name));
    if (base) {
      const out = Math.abs(base) * this.scale;
      const low = hung ? HIGH + 18 : FLOOR + 24;
      const words = svgElement("text", { class: "length-name", x: MIDDLE, y: low + 14 }, `base ±${written(Math.abs(base))}`);
      shapes.push(between([MIDDLE - out, MIDDLE + out], low, 0), words);
    }
    this.dimension.replaceChildren(...shapes);
  }
}

// A length with arrows at its ends, and lines to what it measures.
function between([from, to], y, reach) {
  const tips = `M${from} ${y} l${ARROW} -${ARROW / 2} M${from} ${y} l${ARROW} ${ARROW / 2} M${to} ${y} l-${ARROW} -${ARROW / 2} M${to} ${y} l-${ARROW} ${ARROW / 2}`;
  const lines = reach ? `M${from} ${y} v${reach} M${to} ${y} v${reach}` : `M${from} ${y - 4} v8 M${to} ${y - 4} v8`;
  return svgElement("path", { class: "length", d: `M${from} ${y} H${to} ${tips} ${lines}` });
}
