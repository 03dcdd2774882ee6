// The comparison: a table of the present setting and the pinned ones.

import { button, card, cueScroll, drawCard, element, emit } from "../shared/dom.js";

export function render({ model }) {
  const root = card("comparison-table", "Comparison of the pinned settings");
  const table = element("table");
  root.append(table);
  const draw = () => {
    const parts = Object.entries(model.parts);
    const heads = [["", ""], ...model.rows[0]?.numbers ?? [], ["penalty motion", ""], ...parts.map(([, label]) => [label, ""]), ["", ""]];
    const head = heads.map(([text, name]) => (text
      ? element("th", "", name ? [text, element("small", "", name)] : text, { scope: "col" }) : element("td")));
    table.replaceChildren(element("tr", "", head), ...model.rows.map((row, place) => line(row, place, parts)));
  };
  return cueScroll(drawCard(root, model, "rows", draw), true);
}

function line(row, place, parts) {
  const name = element("th", "name", [element("span", "swatch"), place ? `pin ${place}` : "now"], { scope: "row" });
  const motion = element("td", "motion", row.motion || "computing …");
  if (row.other) motion.append(element("small", "", row.other));
  const numbers = row.numbers.map(([label, name, text]) => number("", `${label} ${name}`, text));
  const acts = element("td", "acts", place && [
    button("Use", `Set the sliders to pin ${place}`, () => emit("set", row.texts)),
    button("×", `Unpin ${place}`, () => emit("unpin", { value: place - 1 })),
  ]);
  return element("tr", place ? `pin${place}` : "present", [name, ...numbers, motion, ...errors(row, parts), acts]);
}

// A number for each part of the difference that is known, or why there is none.
function errors({ explained, shown, measure, headline }, parts) {
  if (!explained || shown.total === undefined) {
    return [element("td", "words", explained ? headline : "computing …", { title: headline, colspan: parts.length })];
  }
  const why = (part) => (part in shown ? measure : "this difference has no such part");
  return parts.map(([part, label]) => number(part, label, shown[part] ?? "–", { title: why(part) }));
}

// Its label is shown where the table has no heads.
const number = (name, label, text, more = {}) => element("td", `number ${name}`, text, { "data-label": label, ...more });
