// The branches of the diagram: what the search has found, the motions at the value that is set, and all points. A button
// in a row opens its motion in Explore. Only textContent is ever set.

import { button, card, choose, cueScroll, drawCard, element, options, setText } from "../shared/dom.js";

export function render({ model }) {
  const root = card("branches-list", model.label);
  const status = element("p", "status", "", { role: "status" });
  const notes = element("div", "notes");
  const near = part("near");
  const points = part("points");
  const filter = element("select", "", "", { "aria-label": "Kind of points" });
  filter.addEventListener("change", () => show());
  points.head.append(filter);
  const stop = button("Stop", "", () => model.send_msg({ stop: stop.dataset.stop === "true" }), "stop");
  const line = element("div", "status-line", [status, stop]);
  root.append(line, notes, near.box, points.box);
  const open = (name) => model.send_msg({ open: name });
  const show = () => {
    for (const row of points.table.querySelectorAll("tr[data-kind]")) row.hidden = Boolean(filter.value) && row.dataset.kind !== filter.value;
  };
  const draw = () => {
    const { text, running = false, stopped = false, notes: said = [] } = model.status;
    setText(status, text ?? "");
    root.dataset.running = String(running);
    stop.hidden = !running && !stopped;
    stop.dataset.stop = String(running);
    setText(stop, running ? "Stop" : "Go on");
    notes.replaceChildren(...said.map((each) => element("p", "", each)));
    near.fill(model.near, open);
    points.fill(model.points, open);
    const kinds = ["", ...new Set((model.points.rows ?? []).map(({ kind }) => kind))];
    if ([...filter.options].map(({ value }) => value).join() !== kinds.join()) {
      const { value } = filter;
      filter.replaceChildren(...options(kinds.map((kind) => [kind, kind || "all kinds"])));
      choose(filter, kinds.includes(value) ? value : "");
    }
    show();
  };
  return cueScroll(drawCard(root, model, ["status", "near", "points"], draw), true);
}

// A title and a table that is written again only where its rows have changed; the focus stays on its row.
function part(name) {
  const title = element("h2");
  const table = element("table");
  const head = element("div", "part-head", [title]);
  const box = element("div", `part ${name}`, [head, table]);
  let drawn = null;
  const fill = (content, open) => {
    if (content === drawn) return;
    drawn = content;
    box.hidden = !content.rows?.length;
    setText(title, content.title ?? "");
    const focused = table.getRootNode().activeElement?.dataset?.open;
    const heads = element("tr", "", (content.heads ?? []).map((each) => element("th", "", each, { scope: "col" })));
    table.replaceChildren(heads, ...(content.rows ?? []).map((row) => line(row, content.heads, open)));
    if (focused) table.querySelector(`[data-open="${focused}"]`)?.focus();
  };
  return { box, head, table, fill };
}

function line({ mark, kind, cells }, heads, open) {
  return element("tr", "", cells.map(({ text, open: name, title }, k) => {
    const cell = element("td", k ? "number" : "name", "", { "data-label": heads[k] });
    if (!k) cell.append(element("span", "mark", mark, { "aria-hidden": "true" }));
    if (name) {
      const made = Object.assign(button(text, "", () => open(name)), { title: title ?? "Open this motion in Explore" });
      made.dataset.open = name;
      made.setAttribute("aria-label", [...cells.map((each) => each.text).filter(Boolean), made.title].join(", "));
      cell.append(made);
    } else cell.append(text);
    return cell;
  }), { "data-kind": kind });
}
