// Suggest K, D, Δτ: the tolerance, the progress of the search, and its result. The server searches and sets the sliders.

import { button, card, cueScroll, drawCard, element, emit, follow, labelled, listen, onPress, progressRow, svgElement } from "../shared/dom.js";

const WIDE = 284;
const HIGH = 112;
const TYPED = { type: "text", inputMode: "decimal", autocomplete: "off", maxLength: 24 };
const OF_FORM = { form: "vibroscope-ask" };
const FRAME = { left: 40, right: 10, top: 10, bottom: 28 };

export function render({ model }) {
  const root = card("suggest", "Suggest K, D, Δτ");
  const limits = searchLimits(model);
  const form = ask(model, limits);
  const status = element("p", "status", "", { role: "status" });
  const running = progressRow("Share of the search that is done", button("Cancel", "Cancel the search", () => model.send_msg({ cancel: true })));
  const found = result();
  const close = button("×", "Close the result of the search", () => model.send_msg({ cancel: true }), "close");
  const more = element("div", "more", [close, status, running.element, found.element, limits.element]);
  root.append(form, more);
  const draw = () => {
    const { content } = model;
    const { phase } = content;
    root.dataset.phase = phase;
    more.hidden = phase === "idle" && !limits.open;
    close.hidden = phase === "running" || phase === "idle";
    status.hidden = phase === "idle";
    status.textContent = { running: "searching …", failed: content.error, done: content.head }[phase] ?? "";
    running.show(phase === "running", content.share ?? 0);
    found.draw(content);
    fitAbove(more);
    emit("suggestion", content);
  };
  addEventListener("resize", () => fitAbove(more));
  limits.onToggle = draw;
  cueScroll(more, true);
  return drawCard(root, model, "content", draw);
}

const LEAST_HIGH = 200; // px, of the box with the result

// A box that lies over the page ends at the lower edge of the window, and scrolls.
function fitAbove(box) {
  const over = box.isConnected && getComputedStyle(box).position === "absolute";
  box.style.maxHeight = over ? `${Math.max(LEAST_HIGH, innerHeight - box.getBoundingClientRect().top - 12)}px` : "";
}

// What is asked and what may be tried: a range of η, what is held, limits, and the tolerances of the contacts; the code
// that is chosen under Your code, unless it is switched off. The fields lie below the result, so that a
// search that met a limit can be run again with another.
function searchLimits(model) {
  const row = element("div", "limits");
  const fields = [["K", "stiffness K up to", "Largest K that the search may try"],
    ["steps", "steps a period up to", "Most steps per period that the search may try"],
    ["restitution", "restitution within", "How far the restitution that the contacts deliver may be off; off: not asked for"],
    ["force", "peak force within", "How far the peak force may be from that without a time step, in per cent; off: not asked for"],
  ].map(([name, text, hint]) => {
    return [name, ...labelled(text, { ...TYPED, title: hint }, OF_FORM)];
  });
  const unit = element("span");
  fields[0][2].append(unit);
  fields[3][2].append(element("span", "", "%"));
  const ends = [["from", "lowest"], ["to", "highest"]].map(([name, which]) => {
    const title = `One K, D and Δτ for a range: its ${which} excitation frequency; empty: the present one alone`;
    return [name, ...labelled(name, { ...TYPED, title }, OF_FORM)];
  });
  const symbol = element("span");
  const etaUnit = element("span");
  ends[1][2].append(etaUnit);
  const held = [["K", "stiffness K"], ["D", "damping D"]].map(([name, words]) =>
    labelled(words, { type: "checkbox", value: name, title: `Keep the present ${name}` }));
  const codeName = element("span");
  const [codeCheck, ofCode] = labelled(codeName, { type: "checkbox", checked: true,
    title: "Search over the integrators, contact status and law of this code, in place of what is set" });
  const forCode = element("div", "group", [element("span", "", "For"), ofCode]);
  follow(model, "code", () => {
    forCode.hidden = !model.code;
    codeName.textContent = `what ${model.code} has`;
  });
  follow(model, "limits", () => {
    for (const [name, field] of fields) {
      field.value = model.limits[name];
      field.style.minWidth = `calc(${field.value.length}ch + 16px)`;
    }
    unit.textContent = model.limits.unit;
    symbol.textContent = model.limits.eta;
    if (etaUnit.textContent !== model.limits.eta_unit) for (const [, field] of ends) field.value = ""; // of other units
    etaUnit.textContent = model.limits.eta_unit;
  });
  const group = (head, labels, name = "") => element("div", `group ${name}`, [head, ...labels]);
  row.append(
    group(symbol, ends.map(([, , label]) => label), "range"),
    group(element("span", "", "Hold"), held.map(([, label]) => label)),
    group(element("span", "", "Allow"), fields.slice(0, 2).map(([, , label]) => label)),
    group(element("span", "", "Also"), fields.slice(2).map(([, , label]) => label), "tolerances"),
    forCode,
  );
  const made = { element: row, open: false, onToggle: () => {} };
  made.toggle = (open) => {
    made.open = open;
    made.onToggle();
  };
  made.typed = () => ({
    ...Object.fromEntries([...fields, ...ends].map(([name, field]) => [name, field.value.trim()])),
    code: codeCheck.checked && model.code ? "yes" : "",
    hold: held.filter(([check]) => check.checked).map(([check]) => check.value).join(""),
  });
  return made;
}

function ask(model, limits) {
  const form = element("form", "ask");
  const [field, label] = labelled("Error ≤", { ...TYPED, maxLength: 12 }, { "aria-label": "Tolerance: relative rms error in per cent" });
  const go = button("Suggest K, D, Δτ", "Search for the fewest steps with at most this error, and set them", () => {});
  go.type = "submit";
  label.append(element("span", "", "%"));
  const more = button("Options", "Options of the search: a range of η, K or D held, the largest K, the most steps, tolerances of restitution and peak force, your code", () => limits.toggle(!limits.open), "quiet");
  form.id = "vibroscope-ask";
  let typed = false; // from then on, no other tolerance is offered
  field.addEventListener("input", () => { typed = true; });
  follow(model, "offer", () => { if (!typed) field.value = model.offer; });
  form.append(label, go, more);
  listen("suggest", () => form.requestSubmit());
  listen("cancel-suggestion", () => model.send_msg({ cancel: true }));
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    model.send_msg({ suggest: { tolerance: field.value.trim(), ...limits.typed() } });
  });
  return form;
}

function result() {
  const list = element("ul");
  const use = button("", "Set K, D and Δτ to the best setting found", () => emit("set", use.texts));
  const place = element("div", "front");
  const box = element("div", "found", [use, list, place]);
  return {
    element: box,
    draw: (content) => {
      box.hidden = !content.lines; // also what a search has found so far
      if (box.hidden) return;
      const { lines, moved, met } = content;
      const all = moved ? [...lines, "K, D or Δτ has been moved since: nothing was set."] : lines;
      list.replaceChildren(...all.map((line) => element("li", "", line)));
      use.texts = content.use;
      use.hidden = (met && !moved) || !Object.keys(content.use).length;
      use.textContent = met ? "Set it" : `Accept ${content.possible} and use it`;
      place.replaceChildren(...(content.front.length > 1 ? [front(content)] : []));
    },
  };
}

// The front: error over steps, both logarithmic. Each point is a setting, and a click sets it.
function front({ front: points, tolerance, use }) {
  const x = scale(points.map(([steps]) => steps), FRAME.left, WIDE - FRAME.right);
  const y = scale([...points.map(([, error]) => error), tolerance], HIGH - FRAME.bottom, FRAME.top);
  const root = svgElement("svg", { viewBox: `0 0 ${WIDE} ${HIGH}`, role: "group" });
  root.setAttribute("aria-label", "Error against steps per period of the settings found; each can be set");
  root.append(
    svgElement("line", { class: "limit", x1: FRAME.left, x2: WIDE - FRAME.right, y1: y(tolerance), y2: y(tolerance) }),
    svgElement("text", { x: WIDE / 2, y: HIGH - 2, "text-anchor": "middle" }, "error over steps per period; click to set"),
    ...ends(points.map(([steps]) => steps)).map((steps) =>
      svgElement("text", { x: x(steps), y: HIGH - FRAME.bottom + 14, "text-anchor": x(steps) > WIDE / 2 ? "end" : "start" },
        String(steps))),
    ...[...new Map(extremes(points)).entries()].map(([error, text]) =>
      svgElement("text", { x: FRAME.left - 8, y: y(error) + 4, "text-anchor": "end" }, text)),
    svgElement("polyline", { points: points.map(([steps, error]) => `${x(steps)},${y(error)}`).join(" ") }),
    ...points.map(([steps, error, texts, text, words]) =>
      point(x(steps), y(error), texts, `${steps} steps, error ${text}: ${words}`, same(texts, use))),
  );
  return root;
}

const ends = (values) => [...new Set([Math.min(...values), Math.max(...values)])];
// The smallest and the largest error, each with its text.
function extremes(points) {
  const sorted = points.map(([, error, , text]) => [error, text]).sort(([a], [b]) => a - b);
  return [sorted[0], sorted.at(-1)];
}
const same = (a, b) => ["K", "D", "steps"].every((name) => a[name] === b[name]);

function scale(values, from, to) {
  const [low, high] = [Math.log(Math.min(...values)), Math.log(Math.max(...values))];
  return (value) => from + ((to - from) * (Math.log(value) - low)) / (high - low || 1);
}

function point(cx, cy, texts, name, best) {
  const look = { cx, cy, r: best ? 6 : 4.5, class: best ? "best" : "" };
  const how = { tabindex: 0, role: "button", "aria-label": `Set ${name}` };
  const dot = svgElement("circle", { ...look, ...how }, [svgElement("title", {}, name)]);
  onPress(dot, () => emit("set", texts));
  return dot;
}
