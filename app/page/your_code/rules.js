// The input of the code that is chosen, and the rules of thumb with small phase plots. Only textContent is ever set.

import { button, card, cueScroll, drawCard, element, follow, say, svgElement } from "../shared/dom.js";

const HOLDS = { yes: "✓ holds", no: "✗ fails", "": "– not known" };

export function render({ model }) {
  const root = card("codes", "Rules of thumb");
  const own = element("div", "own");
  const heads = ["Rule of thumb", "gives", "the motion then", "off by", ""].map((name) => element("th", "", name, { scope: "col" }));
  const body = element("tbody");
  const top = element("thead", "", [element("tr", "", heads)]);
  const table = element("table", "", [element("caption", "", "Rules of thumb: what each gives here, and whether it holds"), top, body]);
  root.append(own, table);
  const drawCode = () => {
    drawOwn(own, model.code);
    root.getRootNode().host?.scrollTo?.(0, 0); // else the input of another code comes out of sight, above the table
  };
  const drawRows = () => {
    model.rows.forEach((row, place) => {
      const text = JSON.stringify([row, model.reference]);
      const before = body.children[place];
      if (before?.dataset.text === text) return;
      const made = rowOf(row, model.reference, model);
      made.dataset.text = text;
      const focus = before?.contains(root.getRootNode().activeElement); // no element contains null
      if (before) before.replaceWith(made);
      else body.append(made);
      if (focus) made.querySelector("button")?.focus();
    });
    while (body.children.length > model.rows.length) body.lastChild.remove();
    table.hidden = !model.rows.length;
  };
  follow(model, "code", drawCode);
  return cueScroll(drawCard(root, model, ["rows", "reference"], drawRows));
}

function drawOwn(box, code) {
  box.hidden = !code.name;
  if (box.hidden) return;
  const words = element("pre", "", code.lines.join("\n"), { "aria-label": `What to set in ${code.name}`, tabindex: 0 });
  const sources = element("ul", "sources", code.sources.map(({ figure, text, url }) => element("li", "", [`${figure}: `, linked(text, url)])));
  const details = element("details", "", [element("summary", "", "Sources"), sources]);
  const units = element("p", "units");
  say(units, code.units);
  box.replaceChildren(element("h2", "", `What to set in ${code.name}`), words, units,
    element("h2", "", "What Vibroscope does not compute"), element("p", "", code.leaves_out), details);
}

function linked(text, url) {
  if (!/^https?:\/\//.test(url ?? "")) return element("span", "", text);
  return element("a", "", text, { href: url, target: "_blank", rel: "noopener noreferrer" });
}

function rowOf(row, reference, model) {
  const from = element("small", "source", row.source && [linked(row.source, row.url)]);
  const words = [element("span", "", row.title), element("small", "", row.claim), from];
  const name = element("th", "", words, { scope: "row" });
  if (row.own) name.prepend(element("small", "mark", "of this code"));
  const gives = element("td", "gives", row.numbers.map((text) => element("span", "", text)));
  if (row.settable) gives.append(button("Set", `Set what “${row.title}” gives`, () => model.send_msg({ set: row.key })));
  const shown = row.path ? [picture(row, reference)] : [];
  const motion = element("td", "motion", [...shown, element("span", "", row.motion)]);
  const mark = element("strong", "", HOLDS[row.holds], { "data-holds": row.holds });
  const holds = element("td", "holds", [mark, element("small", "", row.why)]);
  return element("tr", row.own ? "marked" : "", [name, gives, motion, element("td", "off", row.total), holds]);
}

function picture(row, reference) {
  const paths = [["reference", reference], ["penalty", row.path]].map(([name, d]) => svgElement("path", { d, class: name }));
  return svgElement("svg", { viewBox: "0 0 96 64", role: "img", "aria-label": `Phase plot: ${row.motion}` }, paths);
}
