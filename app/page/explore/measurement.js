// A measurement: the verdict on it, its numbers beside both solutions, and the fit of constants to it.

import { button, card, drawCard, element, emit, labelled, options, progressRow } from "../shared/dom.js";

export function render({ model }) {
  const root = card("measurement-card", "Measurement");
  const name = element("span", "name");
  const head = element("h2", "", [element("span", "swatch"), name]);
  const facts = element("p", "facts");
  const words = element("p", "words", "", { role: "status" });
  const setEta = button("", "Set the excitation frequency of the measurement", () => emit("set", { eta: setEta.value }));
  const table = element("table");
  const note = "The points are placed by the phase of the reference (of the penalty solution, where the reference does "
    + "not repeat itself), all periods over each other. Their velocities are slopes over a fiftieth of a period.";
  const numbers = element("details", "numbers", [element("summary", "", "Numbers"), table, element("p", "note", note)]);
  const fit = fitBox(model);
  const picker = columnPicker(model);
  const close = button("×", "Remove the measurement", () => model.send_msg({ remove: true }), "close");
  const text = element("div", "text", [head, facts, words, picker.element, setEta, numbers]);
  root.append(text, fit.element, close);
  const draw = () => {
    const { content } = model;
    root.dataset.phase = content.phase;
    root.dataset.pending = String(content.pending === true);
    name.textContent = `Measurement: ${content.name ?? ""}`;
    const done = content.phase === "done";
    facts.textContent = done ? content.headline : "";
    words.textContent = { reading: "reading …", columns: content.error, failed: content.error, done: content.words }[content.phase] ?? "";
    setEta.value = content.eta ?? "";
    setEta.hidden = !content.eta;
    setEta.textContent = `Set ${content.offer}`;
    numbers.hidden = !done;
    if (done) table.replaceChildren(...content.rows.map(tableRow));
    fit.draw(content);
    picker.draw(content);
  };
  return drawCard(root, model, "content", draw);
}

function tableRow(cells, place) {
  return element("tr", "", cells.map((text, column) => (text && (place === 0 || column === 0)
    ? element("th", "", text, { scope: place === 0 ? "col" : "row" }) : element("td", "", text))));
}

// Which column of the file is what, where its header does not say so.
const LENGTHS = ["mm", "m", "cm", "µm", "in"];
const COLUMNS = [
  ["time", "time", ["s", "ms", "µs", "min"]],
  ["1", "displacement of body 1", LENGTHS],
  ["2", "displacement of body 2", LENGTHS],
  ["a1", "acceleration of body 1, in place of displacements", ["m/s²", "mm/s²", "g"]],
  ["a2", "acceleration of body 2", ["m/s²", "mm/s²", "g"]],
  ["force", "contact force", ["N", "kN", "mN", "lbf"]],
];

function columnPicker(model) {
  const box = element("fieldset", "columns", [element("legend", "", "Which column is what?")]);
  const rows = COLUMNS.map(([name, words, units]) => {
    const column = element("select");
    const kinds = [["", "unit of the header, or none"], ["-", "without dimension"], ...units.map((each) => [each, each])];
    const unit = element("select", "", options(kinds), { "aria-label": `Unit: ${words}` });
    box.append(element("div", "", [element("label", "", [`${words} `, column]), unit]));
    return { name, column, unit };
  });
  const frames = [["xi", "relative to the base"], ["x", "as a fixed sensor sees them (absolute)"]];
  const frame = element("select", "", options(frames));
  const read = button("Read", "Read the file with these columns", () => {
    const chosen = rows.filter(({ column }) => column.value).map(({ name, column, unit }) => [
      /^\d/.test(name) ? frame.value + name : name, unit.value ? `${column.value} [${unit.value}]` : column.value,
    ]);
    model.send_msg({ columns: Object.fromEntries(chosen) });
  });
  box.append(element("label", "", ["displacements ", frame]), read);
  let drawn = "";
  return {
    element: box,
    draw: ({ phase, header = [] }) => {
      box.hidden = phase !== "columns";
      if (box.hidden || String(header) === drawn) return; // what was chosen stays
      drawn = String(header);
      const cells = header.map((cell, place) => [String(place + 1), `${place + 1}: ${cell || "(no name)"}`]);
      rows.forEach(({ column }, place) => {
        column.replaceChildren(...options([["", "none"], ...cells]));
        column.value = place < 2 ? String(place + 1) : "";
      });
    },
  };
}

// Constants of the system, fitted to the measurement.
function fitBox(model) {
  const box = element("fieldset", "fit", [element("legend", "", "Fit to the measurement")]);
  const choices = element("div", "choices");
  const boxes = Object.entries(model.names).map(([name, [symbol, words]]) => {
    const [check, label] = labelled(`${symbol} ${words}`, { type: "checkbox", checked: true, value: name });
    choices.append(label);
    return check;
  });
  const wanted = () => boxes.filter((check) => check.checked && !check.disabled).map((check) => check.value).join(" ");
  const go = button("Fit", "Fit these constants to the measurement", () => model.send_msg({ fit: wanted() }));
  choices.append(go);
  const cancel = button("Cancel", "Cancel the fit", () => model.send_msg({ cancel: true }));
  const running = progressRow("The fit is being computed", cancel);
  const list = element("ul");
  const use = button("Use these values", "Set the fitted constants", () => emit("set", use.texts));
  box.append(choices, running.element, list, use);
  return {
    element: box,
    draw: ({ phase, names = [], fit = {} }) => {
      box.hidden = phase !== "done";
      for (const check of boxes) check.parentElement.hidden = check.disabled = !names.includes(check.value);
      go.disabled = fit.phase === "running";
      running.show(fit.phase === "running");
      const lines = [...(fit.rows ?? []).map(([name, value]) => `${name}: ${value}`), ...(fit.remarks ?? [])];
      list.replaceChildren(...(fit.error ? [fit.error] : lines).map((line) => element("li", "", line)));
      use.texts = fit.use;
      use.hidden = !fit.use;
    },
  };
}
