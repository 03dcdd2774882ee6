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
  const made = element("tr", place ? `pin${place}` : "present");
  const name = element("th", "name", [element("span", "swatch"), place ? `pin ${place}` : "now"], { scope: "row" });
  const motion = element("td", "motion", row.motion || "computing …");
  if (row.other) motion.append(element("small", "", row.other));
  made.append(name, ...row.numbers.map(([label, name, text]) => number("", `${label} ${name}`, text)), motion, ...errors(row, parts));
  const acts = element("td", "acts");
  if (place) {
    acts.append(
      button("Use", `Set the sliders to pin ${place}`, () => emit("set", row.texts)),
      button("×", `Unpin ${place}`, () => emit("unpin", { value: place - 1 })),
    );
  }
  made.append(acts);
  return made;
}

// A number for each part of the difference that is known, or why there is none.
function errors({ explained, shown, measure, headline }, parts) {
  if (!explained || shown.total === undefined) {
    const cell = element("td", "words", explained ? headline : "computing …");
    cell.title = headline;
    cell.colSpan = parts.length;
    return [cell];
  }
  return parts.map(([part, label]) => {
    const cell = number(part, label, shown[part] ?? "–");
    cell.title = part in shown ? measure : "this difference has no such part";
    return cell;
  });
}

function number(name, label, text) {
  const cell = element("td", `number ${name}`, text);
  cell.dataset.label = label; // shown where the table has no heads
  return cell;
}
