// The findings: texts, bars for the parts of the difference, and the cost. It sets textContent only.

import { button, cueScroll, element, emit, explainTerms, listen, setText } from "../shared/dom.js";

// Ends of the bars, on a logarithmic scale. At the right end the difference is as large as the motion itself.
const LARGEST = 1;
const SMALLEST = 1e-4;

// The verdict of the setting before stays for so long (ms), greyed once there are new figures: most are known by then, and
// the text does not flicker.
const STALE_AFTER = 500;

export function render({ model }) {
  const root = element("div", "lines");
  const lines = [
    shippedMark(root),
    verdict(root),
    bar(root),
    line(root, "reference", "Reference (exact impacts)"),
    line(root, "penalty", "Penalty (Newmark)"),
    chips(root),
  ];
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
  model.on("content", draw);
  draw();
  explainTerms(root);
  cueScroll(root);
  return root;
}

function shippedMark(root) {
  const mark = element("p", "shipped", "Shipped result");
  mark.title = "Computed when this version was made; this machine's own result replaces it as soon as its solvers are compiled";
  root.append(mark);
  return ({ shipped }) => { mark.hidden = !shipped; };
}

// A head that says so while what stands below it is hidden, since it is that of another setting.
function stampedHead(title) {
  const head = element("h2", "", title);
  const mark = element("span", "stale-mark", "computing …");
  mark.setAttribute("role", "status");
  head.append(mark);
  return head;
}

// Words of a first sentence that say what kind of motion it is; another one is named beside it.
const SAID = { periodic: "epeats", artefact: "blurred", chaotic: "chaotic", "quasi-periodic": "quasi-periodic", diverged: "No result" };

// One solution: how it repeats itself, coloured by the kind of its motion once that is known; its impacts and contact; and
// behind a button, the evidence for the kind.
function line(root, name, title) {
  const box = element("section", `line ${name}`);
  const text = element("p");
  const kind = element("span", "kind");
  const rest = element("span");
  const evidence = element("div", "evidence");
  evidence.hidden = true;
  const why = button("Evidence", `Evidence for the kind of motion: ${title}`, () => {
    evidence.hidden = !evidence.hidden;
    why.setAttribute("aria-expanded", String(!evidence.hidden));
  }, "why");
  why.setAttribute("aria-expanded", "false");
  text.append(kind, rest);
  const head = element("h2", "", title);
  box.append(head, text, why, evidence);
  root.append(box);
  return (content) => {
    const [first, others] = halves(content[name] ?? "computing …");
    const [code, words, reason] = content.kinds?.[name] ?? ["", "", ""];
    box.dataset.kind = code;
    if (name === "penalty" && content.solver) setText(head, `Penalty (${content.solver})`);
    kind.textContent = !code || first.includes(SAID[code]) ? first : `${first}: ${words}.`.replace(".:", ":");
    rest.textContent = ` ${others} `;
    evidence.textContent = reason;
    why.hidden = !reason;
    if (!reason) evidence.hidden = true;
  };
}

// The first sentence, and the others.
function halves(text) {
  const end = text.indexOf(". ");
  return end < 0 ? [text, ""] : [text.slice(0, end + 1), text.slice(end + 2)];
}

// Whether the solutions agree, a button for the first thing to change, and the numbers behind both.
function verdict(root) {
  const box = element("section", "line verdict");
  const text = element("p");
  const change = button("", "", () => emit("set", change.texts));
  const more = element("details");
  const list = element("ul");
  more.append(element("summary", "", "Numbers"), list);
  const foot = element("div", "foot");
  foot.append(change, more);
  box.append(stampedHead("Do they agree?"), text, foot);
  root.append(box);
  return (content) => {
    text.textContent = content.headline ?? "computing …";
    box.dataset.agree = content.agree ?? "";
    change.texts = content.change ?? {};
    change.hidden = !content.offer;
    change.textContent = `Try ${content.offer}`;
    more.hidden = !content.details?.length;
    list.replaceChildren(...(content.details ?? []).map((detail) => element("li", "", detail)));
  };
}

// The difference and its parts, below each other; their names and texts are those of the verdict.
function bar(root) {
  const box = element("section", "line parts");
  const head = element("h2");
  const rows = element("div");
  const scale = element("div", "part scale");
  const ends = element("div", "ends");
  ends.append(...["0.01 %", "1 %", "100 %"].map((text) => element("span", "", text)));
  scale.append(element("span", "name", "log scale"), ends, element("span"));
  const note = element("p", "none");
  box.append(head, rows, scale, note);
  root.append(box);
  return ({ bars = [], measure, note: text, headline }) => {
    head.textContent = measure ? `How far apart (${measure})` : "How far apart";
    rows.replaceChildren(...bars.map((each) => barRow(...each)));
    scale.hidden = !bars.length;
    note.textContent = headline === undefined ? "computing …" : text;
    note.hidden = !note.textContent;
  };
}

function barRow(name, title, meaning, value, text) {
  const row = element("div", `part ${name}`);
  const fill = element("div", "fill");
  const track = element("div", "track");
  const share = Math.log10(Math.max(value, SMALLEST) / SMALLEST) / Math.log10(LARGEST / SMALLEST);
  fill.style.width = `${100 * Math.min(1, share)}%`;
  track.append(fill);
  row.title = meaning;
  row.append(element("span", "name", title), track, element("span", "number", text));
  return row;
}

function chips(root) {
  const list = element("dl", "chips");
  list.setAttribute("aria-label", "Cost");
  root.append(list);
  return ({ cost = [] }) => {
    list.replaceChildren(...cost.map(([label, value, meaning]) => {
      const chip = element("div", "chip");
      chip.title = meaning;
      chip.append(element("dt", "", label), element("dd", "", value));
      return chip;
    }));
  };
}
