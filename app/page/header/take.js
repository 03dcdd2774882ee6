// The menu of what can be taken away. Texts and data come from the server when asked for; pictures are made here.

const LARGEST_FILE = 65_536; // bytes
const PARTS = /[^]{1,1900}/gu; // longer texts are not let through; no character of two units is cut

function takeMenu(model) {
  const box = element("details", "take");
  const head = element("summary", "", "Take away");
  head.title = "Figures, data, parameters, script, link, report (T)";
  const panel = element("div", "menu");
  const told = element("p", "told");
  told.setAttribute("role", "status");
  const copying = new Set(); // what is to be copied, not saved, when it comes; the last wish counts
  const ask = (what) => { copying.delete(what); model.send_msg({ take: what }); };
  const copy = (what) => { ask(what); copying.add(what); };
  const both = (title, what, name) => row(title,
    button("Copy", `Copy the ${name}`, () => copy(what)), button("Save", `Save the ${name}`, () => ask(what)));
  const shown = element("div"); // what follows from the figures: only once there are any
  panel.append(
    row("Link to this view", button("Copy", "Copy the link", () => copied(location.href, told))),
    row("Parameters (TOML)", button("Save", "Save the parameters", () => ask("toml"))),
    row("Parameters from a file", loadButton(model, told)),
    both("Python", "python", "Python script"),
    both("Command line", "command", "commands"),
    shown,
    told,
  );
  const whole = [ // made once: what is being clicked must not go while more figures come
    row("Report (HTML)", button("Save", "Save the report", () => ask("report"))),
    row("All data (JSON)", button("Save", "Save all data as JSON", () => ask("json"))),
  ];
  const each = element("div");
  const rows = new Map(); // what is being clicked, or has the focus, stays while other offers come
  const figureRow = ([name, title, drawn, tabled]) => row(title,
    ...(drawn ? [button("PNG", `${title} as PNG`, () => saveFigure(name, title, "png")),
      button("SVG", `${title} as SVG`, () => saveFigure(name, title, "svg"))] : []),
    ...(tabled ? [button("CSV", `${title}: data as CSV`, () => ask(`csv:${name}`))] : []));
  const rowOf = (offer) => {
    const key = JSON.stringify(offer);
    if (!rows.has(key)) rows.set(key, figureRow(offer));
    return rows.get(key);
  };
  const draw = () => {
    if (!model.offers.length) shown.replaceChildren();
    else if (!shown.childElementCount) shown.replaceChildren(...whole, each);
    const wanted = model.offers.map(rowOf);
    for (const old of [...each.children]) if (!wanted.includes(old)) old.remove();
    wanted.forEach((one, at) => { if (each.children[at] !== one) each.insertBefore(one, each.children[at] ?? null); });
  };
  model.on("offers", draw);
  draw();
  model.on("msg:custom", async (message) => {
    const given = message.data ?? message;
    if (copying.delete(given.give)) await copied(given.text, told);
    else await orTell(given.name, async () => save(given.name, new Blob([await withFigures(given)], { type: given.type })));
  });
  box.append(head, panel);
  document.addEventListener("keydown", (event) => { if (event.key === "Escape") box.open = false; });
  document.addEventListener("click", (event) => { if (!event.composedPath().includes(box)) box.open = false; });
  return { element: box, toggle: () => { box.open = !box.open; if (box.open) panel.querySelector("button").focus(); } };
}

// The file is read here; the server checks what it says, and takes all of it or nothing.
function loadButton(model, told) {
  const field = element("input");
  Object.assign(field, { type: "file", accept: ".toml", hidden: true });
  field.addEventListener("change", async () => {
    const [file] = field.files;
    field.value = "";
    if (!file) return;
    if (file.size > LARGEST_FILE) {
      told.textContent = `This file is larger than ${LARGEST_FILE} bytes: it is none with parameters.`;
      return;
    }
    const text = await file.text();
    const parts = text.match(PARTS) ?? [];
    model.send_msg({ load: Object.fromEntries(parts.map((part, i) => [String(i), part])) });
    told.textContent = "";
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

async function copied(text, told) {
  try {
    await navigator.clipboard.writeText(text);
    told.textContent = "Copied.";
  } catch {
    told.textContent = "This browser does not let the page copy: save it instead, or take the link from the address bar.";
  }
}

// What fails here is told where all errors are.
async function orTell(what, act) {
  say("failed", { value: "" });
  try {
    await act();
  } catch (error) {
    say("failed", { value: `${what} could not be made (${error.message}). Wait until the figures are drawn, then try again.` });
  }
}

function saveFigure(name, title, type) {
  return orTell(`“${title}”`, async () => save(`vibroscope-${name}.${type}`, await drawing(name, type)));
}

async function drawing(name, type) {
  const shape = inPage(`svg[data-figure="${name}"]`);
  if (shape) return pictureOf(shape, type);
  const view = viewOf(name);
  if (!view) throw new Error(`${name} is not drawn`);
  return view.export(type).to_blob();
}

// The report comes with empty places; the figures are drawn here.
async function withFigures({ give, text }) {
  if (give !== "report") return text;
  const page = new DOMParser().parseFromString(text, "text/html");
  for (const place of page.querySelectorAll("[data-figure]")) {
    const svg = new DOMParser().parseFromString(await (await drawing(place.dataset.figure, "svg")).text(), "image/svg+xml");
    place.append(page.importNode(svg.documentElement, true));
  }
  // The server knows its page by the query alone.
  for (const link of page.querySelectorAll("[data-page]")) {
    link.href = new URL(link.textContent, location).href;
    link.textContent = link.href;
  }
  return `<!DOCTYPE html>\n${page.documentElement.outerHTML}`;
}
