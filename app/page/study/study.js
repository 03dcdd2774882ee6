// The panel of a study. Only textContent is ever set; what is chosen goes to the server, which answers with what holds.

import {
  LOCAL, adaptToTouch, alignFrames, asObject, button, card, choose, cueScroll, drawCard, element, emit, labelled, modelOf,
  options, say, setText, viewOf, whenever,
} from "../shared/dom.js";
import { chooser } from "../shared/upload.js";

export function render({ model }) {
  const root = card("study", model.spec.title);
  root.dataset.figures = model.spec.figures.join(" ");
  const send = (message) => model.send_msg(message);
  const shows = [
    ...model.spec.switches.map((spec) => switcher(root, spec, send)),
    ...(model.spec.file ? [fileRow(root, model)] : []),
    ...numbers(root, model.spec.numbers, send),
    progress(root, send),
    key(root),
    statements(root),
  ];
  if (model.spec.hint) root.append(element("p", "hint", model.spec.hint));
  const draw = () => shows.forEach((show) => show(model));
  cueScroll(drawCard(root, model, ["chosen", "away", "fields", "refused", "status", "key", "statements", "file"], draw));
  whenever(() => model.spec.figures.every((name) => viewOf(name)?.frame), () => {
    if (model.spec.cursor) dragged(model);
    if (model.spec.aligned) alignFrames(model.spec.aligned.map(viewOf));
    adaptToTouch(model.spec.figures.map(modelOf));
  });
  return root;
}

function switcher(root, { name, label, choices }, send) {
  const select = element("select", "", options(Object.entries(choices)));
  select.addEventListener("change", () => send({ choose: { [name]: select.value } }));
  const row = element("label", "row", [element("span", "", label), select]);
  root.append(row);
  return ({ chosen, away }) => {
    for (const option of select.options) option.hidden = option.disabled = Boolean(away[name]?.includes(option.value));
    choose(select, chosen[name]);
  };
}

function fileRow(root, model) {
  const { root: row } = chooser(model, button(model.spec.file.label, "", () => {}), model.spec.file);
  const name = element("output");
  row.append(name);
  root.append(row);
  return ({ away, file }) => {
    row.hidden = "file" in away;
    name.textContent = file;
  };
}

// Whether a row has an effect: if the other choices have the values that it needs.
const applies = (when, chosen) => Object.entries(when).every(([other, value]) => chosen[other] === value);

// Typed numbers go to the server when Enter is pressed or the field is left; what is refused stays, with the reason.
function numbers(root, specs, send) {
  if (!specs.length) return [];
  const grid = element("div", "numbers");
  const refused = element("p", "refused", "", { role: "alert" });
  const shows = specs.map(({ name, label, when, mode }) => {
    const symbol = element("span", "", label);
    const words = element("small");
    const [input, row] = labelled(element("span", "", [symbol, " ", words]),
      { type: "text", inputMode: mode, autocomplete: "off", name });
    let shown = "";
    let typing = false; // an answer that comes meanwhile must not overwrite it
    input.addEventListener("input", () => { typing = true; });
    input.addEventListener("change", () => {
      typing = false;
      if (input.value !== shown) send({ choose: { [name]: input.value } });
    });
    grid.append(row);
    return (model) => {
      row.hidden = name in model.away || !applies(when, model.chosen);
      const value = model.chosen[name] ?? ""; // the ends of a range come with the first picture
      const field = model.fields[name] ?? { label, name: "", factor: 1 };
      const digits = field.factor === 1 ? 8 : 6;
      const text = typeof value === "string" ? value : String(Number((field.factor * value).toPrecision(digits)));
      setText(symbol, field.label);
      setText(words, field.name);
      input.placeholder = field.empty ?? "";
      row.classList.toggle("wide", field.label.length + field.name.length > 10);
      if (typing || (text === shown && model.refused)) return;
      shown = text;
      input.value = text;
    };
  });
  root.append(grid, refused);
  shows.push((model) => {
    grid.hidden = [...grid.children].every((row) => row.hidden);
    say(refused, model.refused);
  });
  return shows;
}

function progress(root, send) {
  const bar = element("progress", "", "", { "aria-label": "Cells computed", max: 1 });
  const text = element("span");
  const stop = button("Cancel", "", () => send({ stop: stop.dataset.stop === "true" }));
  const row = element("div", "progress", [bar, text, stop]);
  root.append(row);
  return ({ status }) => {
    row.hidden = !status.text;
    bar.value = status.share ?? 0;
    text.textContent = status.text ?? "";
    root.dataset.running = String(status.running ?? false);
    root.dataset.share = String(status.share ?? 0);
    stop.dataset.stop = String(status.running ?? false);
    stop.hidden = !status.running && (status.share ?? 0) >= 1;
    stop.textContent = status.running ? "Cancel" : "Go on";
  };
}

function key(root) {
  const head = element("h2", "key-title");
  const list = element("ul", "key", "", { "aria-label": "Colours" });
  root.append(head, list);
  return (model) => {
    head.textContent = model.key_title;
    head.hidden = !model.key.length;
    list.replaceChildren(...model.key.map(([colour, text, pattern]) => {
      const patch = element("span", `patch ${pattern}`, "", { "aria-hidden": "true" });
      if (colour) patch.style.backgroundColor = colour;
      return element("li", "", [patch, element("span", "", text)]);
    }));
  };
}

function statements(root) {
  const box = element("div", "statements");
  root.append(box);
  return (model) => {
    box.replaceChildren(...model.statements.flatMap(([head, text]) => [element("h2", "", head), element("p", "", text)]));
  };
}

// A line over a figure, moved here while it is dragged; only where it is let go is sent.
const NEAR = { mouse: 9, pen: 9, touch: 22 }; // px to either side in which the line is taken

function dragged(model) {
  const spec = model.spec.cursor;
  const swept = () => spec.swept[model.chosen[spec.by]];
  const view = viewOf(spec.figure);
  const span = modelOf(spec.span);
  const label = modelOf(spec.label);
  const at = (event) => event.clientX - view.canvas_view.el.getBoundingClientRect().left;
  const near = (event) => Math.abs(at(event) - view.frame.x_scale.compute(span.location)) < NEAR[event.pointerType];
  let held = false;
  let before = 0;
  // The number in the units of the axis, which belongs to a second range where they are others than those of the data.
  const words = (symbol, location) => {
    const { below: [axis], x_range, extra_x_ranges } = view.model;
    if (axis.x_range_name === "default") return `${symbol} = ${location}`;
    const [shown, , unit] = axis.axis_label.split(" ").slice(-3);
    const factor = asObject(extra_x_ranges).units.end / x_range.end;
    return `${shown} = ${Number((location * factor).toPrecision(5))} ${unit.replace(/[()]/g, "")}`;
  };
  // The words stand on the side of the line where there is room, and not at all where the line is out of view.
  const placeWords = () => {
    const { left, right } = view.frame.bbox;
    const x = view.frame.x_scale.compute(span.location);
    const turned = x > (left + right) / 2;
    label?.setv({ visible: x >= left && x <= right, text_align: turned ? "right" : "left", x_offset: turned ? -6 : 6 }, LOCAL);
  };
  const { x_range } = view.model;
  for (const property of [span.properties.location, x_range.properties.start, x_range.properties.end]) {
    property.change.connect(placeWords);
  }
  placeWords();
  const moveTo = (value) => {
    const { bounds: [low, high], symbol, parts } = swept();
    const location = Math.round(Math.min(Math.max(value, low), high) * parts) / parts;
    span.setv({ location }, LOCAL);
    label?.setv({ x: location, text: words(symbol, location) }, LOCAL);
  };
  const listen = (type, act) => view.el.addEventListener(type, act, { capture: true });
  listen("pointerdown", (event) => {
    if (!near(event)) return;
    held = true;
    before = span.location;
    view.el.setPointerCapture(event.pointerId);
    event.stopPropagation();
    event.preventDefault();
  });
  listen("pointermove", (event) => {
    view.el.style.cursor = held || near(event) ? "ew-resize" : "";
    if (!held) return;
    event.stopPropagation();
    moveTo(view.frame.x_scale.invert(at(event)));
  });
  listen("pointerup", (event) => {
    if (!held) return;
    held = false;
    event.stopPropagation();
    emit("set", { [swept().name]: String(span.location) });
  });
  listen("pointercancel", () => {
    if (held) moveTo(before);
    held = false;
  });
  // A finger on the line does not scroll the page.
  view.el.addEventListener("touchstart", (event) => { if (held) event.preventDefault(); }, { passive: false });
}
