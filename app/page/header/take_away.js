// The take-away menu. Texts and data come from the server on request; pictures are drawn here (`picture.js`).

import { pictureFile, pictureOf } from "./picture.js";
import { button, element, emit, listen, preferences } from "../shared/dom.js";

const LARGEST_FILE = 65_536; // bytes
const PARTS = /[^]{1,1900}/gu; // the server accepts no longer texts; `u`: no surrogate pair is cut

export function takeAwayMenu(model) {
  const box = element("details", "take-away");
  const head = element("summary", "", "Take away");
  head.title = "Figures, data, parameters, script, link, report (T)";
  const panel = element("div", "menu");
  const status = element("p", "status");
  status.setAttribute("role", "status");
  const copying = new Set(); // requested files that are to be copied, not saved; the last request counts
  const ask = (what) => { copying.delete(what); model.send_msg({ take: what }); };
  const copy = (what) => { ask(what); copying.add(what); };
  const copyOrSave = (title, what, name) => row(title,
    button("Copy", `Copy the ${name}`, () => copy(what)), button("Save", `Save the ${name}`, () => ask(what)));
  const ofFigures = element("div"); // empty while there are no figures
  panel.append(
    row("Link to this view", button("Copy", "Copy the link", () => copyText(location.href, status))),
    row("Parameters (TOML)", button("Save", "Save the parameters", () => ask("toml"))),
    row("Parameters from a file", loadButton(model, status)),
    copyOrSave("Python", "python", "Python script"),
    copyOrSave("Command line", "command", "commands"),
    row("Deck for", ...["OpenSees", "CalculiX", "Abaqus", "Ansys", "Modelica"]
      .map((code) => button(code, `Save a deck for ${code}`, () => ask(`deck:${code.toLowerCase()}`)))),
    ofFigures,
    status,
  );
  const ofAllFigures = [ // made once, so that a button is not replaced while it is clicked
    row("Report (HTML)", button("Save", "Save the report", () => ask("report"))),
    row("All data (JSON)", button("Save", "Save all data as JSON", () => ask("json"))),
  ];
  const size = sizeFields();
  ofAllFigures.push(size.element);
  const each = element("div");
  const rows = new Map(); // kept, so that a button keeps the focus while other figures come
  const figureRow = ([name, title, drawn, tabled]) => row(title,
    ...(drawn ? ["PNG", "SVG", "PDF"] : [])
      .map((kind) => button(kind, `${title} as ${kind}`, () => ask(`${kind.toLowerCase()}:${name}`))),
    ...(tabled ? [button("CSV", `${title}: data as CSV`, () => ask(`csv:${name}`))] : []),
    ...(drawn && tabled ? [button("Script", `${title}: Script (matplotlib) that draws the CSV`, () => ask(`plot:${name}`))] : []));
  listen("save-figure", ({ value }) => ask(`png:${value}`)); // from the figure's toolbar
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
    else await orShowError(file.name, async () => save(file.name, await contentOf(file, size)));
  });
  box.append(head, panel);
  document.addEventListener("keydown", (event) => { if (event.key === "Escape") box.open = false; });
  document.addEventListener("click", (event) => { if (!event.composedPath().includes(box)) box.open = false; });
  return { element: box, toggle: () => { box.open = !box.open; if (box.open) panel.querySelector("button").focus(); } };
}

// The file is read here; the server checks its content, and accepts all of it or nothing.
function loadButton(model, status) {
  const field = element("input");
  Object.assign(field, { type: "file", accept: ".toml", hidden: true });
  field.addEventListener("change", async () => {
    const [file] = field.files;
    field.value = "";
    if (!file) return;
    if (file.size > LARGEST_FILE) {
      status.textContent = `This file is larger than ${LARGEST_FILE} bytes, so it is no parameter file.`;
      return;
    }
    const text = await file.text();
    const parts = text.match(PARTS) ?? [];
    model.send_msg({ load: Object.fromEntries(parts.map((part, i) => [String(i), part])) });
    status.textContent = "";
  });
  const open = button("Load", "Load parameters from a TOML file", () => field.click());
  const both = element("span", "load");
  both.append(open, field);
  return both;
}

function row(name, ...buttons) {
  const line = element("div", "item");
  line.append(element("span", "", name), ...buttons);
  return line;
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

// Calls `act`; the page shows its error like any other.
async function orShowError(what, act) {
  emit("failed", { value: "" });
  try {
    await act();
  } catch (error) {
    emit("failed", { value: `${what} could not be made (${error.message}). Wait until the figures are drawn, then try again.` });
  }
}

// Fields for the size of the pictures: empty ones mean as on the page.
function sizeFields() {
  const box = element("div", "item sizes");
  const field = (name, words, [low, high], usual, unit) => {
    const label = element("label", "", `${words} `);
    const input = element("input");
    Object.assign(input, { type: "number", min: low, max: high, value: preferences.get(name) ?? usual, placeholder: "as shown" });
    input.setAttribute("aria-label", `${words} in ${unit}`);
    input.addEventListener("change", () => preferences.set(name, input.value));
    label.append(input, ` ${unit}`);
    box.append(label);
    return () => { // null if it is empty
      if (!input.checkValidity()) throw new Error(`${words.toLowerCase()} from ${low} to ${high} ${unit}`);
      return input.value ? Number(input.value) : null;
    };
  };
  box.append(element("span", "", "Pictures"));
  const width = field("picture-width", "Width", [20, 500], "", "mm");
  const height = field("picture-height", "Height", [20, 500], "", "mm");
  const dpi = field("picture-dpi", "PNG", [50, 1200], 300, "dpi");
  box.title = "A column of a journal is about 85 mm wide, a page 170 mm. Empty: as large as on the page.";
  return { element: box, read: () => ({ width: width(), height: height(), dpi: dpi() ?? 300 }) };
}

// The server sends most files whole. The pictures are drawn here: it sends what they are to say of themselves.
async function contentOf(file, size) {
  const [kind, name] = file.give.split(":");
  if (!["png", "svg", "pdf"].includes(kind)) return new Blob([await withFigures(file)], { type: file.type });
  const { title, description, address } = JSON.parse(file.text);
  const about = { title, description: `${description}\nThe page: ${new URL(address, location).href}` };
  const { width, height, dpi } = size.read();
  return pictureFile(await pictureOf(name, { width, height }), kind, about, dpi);
}

// The report comes without figures; they are drawn here.
async function withFigures({ give, text }) {
  if (give !== "report") return text;
  const page = new DOMParser().parseFromString(text, "text/html");
  for (const place of page.querySelectorAll("[data-figure]")) {
    place.append(page.importNode(await pictureOf(place.dataset.figure), true));
  }
  // The server knows only the query of its address.
  for (const link of page.querySelectorAll("[data-page]")) {
    link.href = new URL(link.textContent, location).href;
    link.textContent = link.href;
  }
  return `<!DOCTYPE html>\n${page.documentElement.outerHTML}`;
}
