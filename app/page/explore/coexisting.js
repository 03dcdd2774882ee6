// The motions that coexist at the setting: a button that searches, the progress, and a list. A click on a motion sets
// the start of the run to one that leads to it. The server searches; nothing is sent until the button is pressed.

import { button, card, drawCard, element, emit, progressRow } from "../shared/dom.js";

export function render({ model }) {
  const root = card("coexisting", "Coexisting motions");
  const find = button("Coexisting motions", "Search for the motions that exist at these numbers, from many starts",
    () => model.send_msg({ find: true }), "find");
  const follow = button("Follow this motion", "Follow this motion and others over η, stable or not, in the bifurcation diagram",
    () => model.send_msg({ follow: true }), "find");
  const peaks = button("Peaks", "Largest values and spectra of both", () => model.send_msg({ peaks: true }), "find");
  const row = element("div", "row", [find, follow, peaks]);
  const status = element("p", "status", "", { role: "status" });
  const stop = button("Stop", "Stop the search; what it has found stays", () => model.send_msg({ stop: true }));
  const running = progressRow("Share of the starts that are done", stop);
  const close = button("×", "Close the list of motions", () => model.send_msg({ close: true }), "close");
  const list = element("div", "list");
  const box = element("div", "box", [close, status, running.element, list]);
  root.append(box, row);
  const draw = () => {
    const { phase, head, share, error, solvers = [] } = model.content;
    root.dataset.phase = phase;
    box.hidden = phase === "idle";
    find.hidden = !box.hidden;
    running.show(phase === "running", share ?? 0);
    const found = head ? `${head}${phase === "stopped" ? " (stopped)" : ""}.` : "searching …";
    status.textContent = phase === "failed" ? error : found;
    fill(list, solvers);
  };
  return drawCard(root, model, "content", draw);
}

// Draws the list again, and keeps the focus on the motion that has it.
function fill(list, solvers) {
  const focused = list.getRootNode().activeElement?.dataset?.start;
  list.replaceChildren(...solvers.flatMap(([title, motions]) => [element("h3", "", title), ...motions.map(motionRow)]));
  if (focused) list.querySelector(`[data-start="${focused}"]`)?.focus();
}

function motionRow({ name, share, text, why, starts, use, shown }) {
  const words = [element("strong", "", name), element("span", "share", `${share} of starts`), element("small", "", text)];
  const made = button(words, "", () => emit("set", use), "motion");
  made.setAttribute("aria-pressed", String(shown));
  const { zero_start, ...numbers } = use;
  made.dataset.start = Object.values(numbers).join(",");
  made.title = `Run from ${starts}, which leads to this motion. ${why}`;
  return made;
}
