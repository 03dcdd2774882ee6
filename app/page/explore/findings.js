// The findings: the answer, bars for the parts of the difference, both motions; folded: the numbers, the evidence and the
// cost. It sets textContent only.

import { button, cueScroll, drawCard, element, emit, listen, say, setText } from "../shared/dom.js";

// Ends of the bars, on a logarithmic scale. At the right end the difference is as large as the motion itself.
const LARGEST = 1;
const SMALLEST = 1e-4;

// The verdict of the setting before stays for so long (ms), greyed once there are new figures: most are known by then, and
// the text does not flicker.
const STALE_AFTER = 500;

export function render({ model }) {
  const root = element("div", "lines");
  const further = furtherDetails(model);
  const lines = [
    shippedMark(root),
    verdict(root, further),
    bar(root),
    line(root, further, "reference", "Reference (exact impacts)"),
    line(root, further, "penalty", "Penalty (Newmark)"),
    chips(further),
  ];
  root.append(further);
  const draw = () => {
    const { content } = model;
    pending = content.pending === true || content.headline === undefined;
    root.dataset.pending = String(pending);
    markStale();
    lines.forEach((show) => show(content));
    emit("findings", content);
  };
  // Counted from the first move without an answer, or result without a verdict: while a slider moves, there is a new one
  // with each frame.
  let pending = true;
  let moving = false;
  let timer = 0;
  const markStale = () => {
    if (pending || moving) timer ||= setTimeout(() => { root.dataset.stale = "true"; }, STALE_AFTER);
    else {
      clearTimeout(timer);
      timer = 0;
      root.dataset.stale = "false";
    }
  };
  listen("moving", ({ value }) => {
    moving = value;
    markStale();
  });
  listen("report-findings", () => emit("findings", model.content));
  return cueScroll(drawCard(root, model, "content", draw));
}

function shippedMark(root) {
  const title = "Computed when this version was made; this machine's own result replaces it as soon as its solvers are compiled";
  const mark = element("p", "shipped", "Shipped result", { title });
  root.append(mark);
  return ({ shipped }) => { mark.hidden = !shipped; };
}

// A head that says so while what stands below it is hidden, since it is that of another setting.
function stampedHead(title) {
  return element("h2", "", [title, element("span", "stale-mark", "computing …", { role: "status" })]);
}

// Words of a first sentence that say what kind of motion it is; another one is named beside it.
const SAID = { periodic: "epeats", artefact: "blurred", chaotic: "chaotic", "quasi-periodic": "quasi-periodic", diverged: "No result" };

// Folds what is asked for less often: here, and on the rest of Explore (`explore.css`).
function furtherDetails(model) {
  const box = element("details", "line further", [element("summary", "", "More: evidence, options, other motions, measurement")]);
  box.addEventListener("toggle", () => {
    const grid = box.getRootNode().host.getRootNode().host;
    grid.toggleAttribute("data-further", box.open);
    if (box.open) model.send_msg({ further: true });
  });
  return box;
}

// One solution: how it repeats itself, coloured by the kind of its motion once that is known. Folded: its impacts and
// contact, and the evidence for the kind.
function line(root, further, name, title) {
  const kind = element("span", "kind");
  const rest = element("p", "rest");
  const evidence = element("p", "evidence");
  const text = element("p", "", [kind]);
  const heads = [element("h2", "", title), element("h3", "", title)];
  const box = element("section", `line ${name}`, [heads[0], text]);
  root.append(box);
  further.append(heads[1], rest, evidence);
  return (content) => {
    const said = content[name] ?? "computing …";
    const [first, others] = said.startsWith("No result") ? [said, ""] : halves(said); // why there is none is not folded
    const [code, words, reason] = content.kinds?.[name] ?? ["", "", ""];
    box.dataset.kind = code;
    if (name === "penalty" && content.solver) for (const head of heads) setText(head, `Penalty (${content.solver})`);
    kind.textContent = !code || first.includes(SAID[code]) ? first : `${first}: ${words}.`.replace(".:", ":");
    rest.textContent = others;
    say(evidence, reason);
  };
}

// The first sentence, and the others.
function halves(text) {
  const end = text.indexOf(". ");
  return end < 0 ? [text, ""] : [text.slice(0, end + 1), text.slice(end + 2)];
}

// Whether the solutions agree and why not, and a button for the first thing to change. Folded: what else is said, how the
// difference is measured, and the numbers.
function verdict(root, further) {
  const text = element("p");
  const change = button("", "", () => emit("set", change.texts));
  const head = element("h3", "", "Numbers");
  const list = element("ul");
  further.append(head, list);
  const box = element("section", "line verdict", [stampedHead("Do they agree?"), text, change]);
  root.append(box);
  return (content) => {
    const [first, rest] = halves(content.headline ?? "computing …");
    const [second, others] = halves(rest);
    text.textContent = [first, second].join(" ").trim();
    box.dataset.agree = content.agree ?? "";
    change.texts = content.change ?? {};
    change.hidden = !content.offer;
    change.textContent = `Try ${content.offer}`;
    const measured = content.measure ? `How far apart: ${content.measure}.` : "";
    const said = [others, measured, ...(content.details ?? [])].filter(Boolean);
    head.hidden = !said.length;
    list.replaceChildren(...said.map((each) => element("li", "", each)));
  };
}

// The difference and its parts, below each other; their names and texts are those of the verdict.
function bar(root) {
  const head = element("h2", "", "How far apart");
  const rows = element("div");
  const ends = element("div", "ends", ["0.01 %", "1 %", "100 %"].map((text) => element("span", "", text)));
  const scale = element("div", "part scale", [element("span", "name", "log scale"), ends, element("span")]);
  const note = element("p", "none");
  const box = element("section", "line parts", [head, rows, scale, note]);
  root.append(box);
  return ({ bars = [], note: text, headline }) => {
    rows.replaceChildren(...bars.map((each) => barRow(...each)));
    scale.hidden = !bars.length;
    say(note, headline === undefined ? "computing …" : text);
  };
}

function barRow(name, title, meaning, value, text) {
  const fill = element("div", "fill");
  const share = Math.log10(Math.max(value, SMALLEST) / SMALLEST) / Math.log10(LARGEST / SMALLEST);
  fill.style.width = `${100 * Math.min(1, share)}%`;
  const parts = [element("span", "name", title), element("div", "track", [fill]), element("span", "number", text)];
  return element("div", `part ${name}`, parts, { title: meaning });
}

function chips(further) {
  const list = element("dl", "chips", "", { "aria-label": "Cost" });
  further.append(list);
  return ({ cost = [] }) => {
    list.replaceChildren(...cost.map(([label, value, meaning]) =>
      element("div", "chip", [element("dt", "", label), element("dd", "", value)], { title: meaning })));
  };
}
