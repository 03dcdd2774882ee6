// The take-away menu. All files come from the server, on request.

import { button, closeFromElsewhere, element, fileField, inPage, labelled, listen, preferences } from "../shared/dom.js";
import { sendFile } from "../shared/upload.js";

const LARGEST_FILE = 65_536; // bytes

export function takeAwayMenu(model) {
  const box = element("details", "take-away");
  const head = element("summary", "", "Take away", { title: "Figures, data, parameters, script, link, report (T)" });
  const panel = element("div", "menu");
  const status = element("p", "status", "", { role: "status" });
  const copying = new Set(); // requested files that are to be copied, not saved; the last request counts
  const ask = (what) => { copying.delete(what); model.send_msg({ take: what }); };
  const askDrawn = (what) => ask(`${what}?${size.read()}`);
  const copy = (what) => { ask(what); copying.add(what); };
  const copyOrSave = (title, what, name) => row(title,
    button("Copy", `Copy the ${name}`, () => copy(what)), button("Save", `Save the ${name}`, () => ask(what)));
  const ofFigures = element("div"); // empty while there are no figures
  panel.append(
    row("Link to this view", button("Copy", "Copy the link", () => copyText(location.href, status))),
    row("Parameters (TOML)", button("Save", "Save the parameters", () => ask("toml"))),
    row("Parameters from a file", loadButton(model)),
    copyOrSave("Python", "python", "Python script"),
    copyOrSave("Command line", "command", "commands"),
    row("Deck for", ...["OpenSees", "CalculiX", "Abaqus", "Ansys", "Modelica"]
      .map((code) => button(code, `Save a deck for ${code}`, () => ask(`deck:${code.toLowerCase()}`)))),
    ofFigures,
    status,
  );
  const ofAllFigures = [ // made once, so that a button is not replaced while it is clicked
    row("Report (HTML)", button("Save", "Save the report", () => askDrawn("report"))),
    row("All data (JSON)", button("Save", "Save all data as JSON", () => ask("json"))),
  ];
  const size = sizeFields();
  ofAllFigures.push(size.element);
  const each = element("div");
  const rows = new Map(); // kept, so that a button keeps the focus while other figures come
  const figureRow = ([name, title, drawn, tabled]) => row(title,
    ...(drawn ? ["PNG", "SVG", "PDF"] : [])
      .map((kind) => button(kind, `${title} as ${kind}`, () => askDrawn(`${kind.toLowerCase()}:${name}`))),
    ...(tabled ? [button("CSV", `${title}: data as CSV`, () => ask(`csv:${name}`))] : []),
    ...(drawn ? [button("Script", `${title}: Script (matplotlib) that draws it`, () => askDrawn(`plot:${name}`))] : []));
  listen("save-figure", ({ value }) => askDrawn(`png:${value}`)); // from the figure's toolbar
  const rowOf = (offer) => {
    const key = JSON.stringify(offer);
    if (!rows.has(key)) rows.set(key, figureRow(offer));
    return rows.get(key);
  };
  const draw = () => {
    if (!model.offers.length) ofFigures.replaceChildren();
    else if (!ofFigures.childElementCount) ofFigures.replaceChildren(...ofAllFigures, each);
    const wanted = model.offers.map(rowOf);
    for (const old of [...each.children]) if (!wanted.includes(old)) old.remove();
    wanted.forEach((one, at) => { if (each.children[at] !== one) each.insertBefore(one, each.children[at] ?? null); });
  };
  model.on("awaited", () => { status.textContent = model.awaited; });
  model.on("offers", draw);
  draw();
  model.on("msg:custom", async (message) => {
    const file = message.data ?? message;
    if (copying.delete(file.give)) await copyText(file.text, status);
    else save(file.name, new Blob([file.text ?? Uint8Array.from(atob(file.bytes), (letter) => letter.charCodeAt(0))], { type: file.type }));
  });
  box.append(head, panel);
  closeFromElsewhere(box);
  return { element: box, toggle: () => { box.open = !box.open; if (box.open) panel.querySelector("button").focus(); } };
}

function loadButton(model) {
  const load = (file) => sendFile(model, file, LARGEST_FILE);
  const field = fileField(load, ".toml");
  listen("load-parameters", ({ file }) => load(file)); // that is dropped on the page
  const open = button("Load", "Load parameters from a TOML file", () => field.click());
  return element("span", "load", [open, field]);
}

function row(name, ...buttons) {
  return element("div", "item", [element("span", "", name), ...buttons]);
}

function save(name, blob) {
  const link = element("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

async function copyText(text, status) {
  try {
    await navigator.clipboard.writeText(text);
    status.textContent = "Copied.";
  } catch {
    status.textContent = "This browser does not let the page copy: save it instead, or take the link from the address bar.";
  }
}

// Fields for the size of the pictures: empty ones mean as on the page.
function sizeFields() {
  const title = "A column of a journal is about 85 mm wide, a page 170 mm. Empty: as large as on the page.";
  const box = element("div", "item sizes", [element("span", "", "Pictures")], { title });
  const field = (name, words, [low, high], usual, unit) => {
    const numbers = { type: "number", min: low, max: high, value: preferences.get(name) ?? usual, placeholder: "as shown" };
    const [input, label] = labelled(`${words} `, numbers, { "aria-label": `${words} in ${unit}` });
    input.addEventListener("change", () => preferences.set(name, input.value));
    label.append(` ${unit}`);
    box.append(label);
    return input;
  };
  const width = field("picture-width", "Width", [20, 500], "", "mm");
  const height = field("picture-height", "Height", [20, 500], "", "mm");
  const dpi = field("picture-dpi", "PNG", [50, 1200], 300, "dpi");
  const read = () => new URLSearchParams({ // empty ones mean as on the page; the server checks them
    width: width.value, height: height.value, dpi: dpi.value, page: location.origin + location.pathname,
    dark: Number(document.documentElement.dataset.theme === "dark"), bodies: inPage("svg.moving")?.outlines() ?? "",
  });
  return { element: box, read };
}
