// The head of the page: title, tabs, what can be taken away, light and dark, keys, the tour, errors and the summary.

export function render({ model }) {
  const root = element("header", "head");
  const title = element("h1", "", "Vibroscope");
  title.append(element("small", "", "where a penalty contact departs from the exact impact motion"));
  const bar = element("div", "bar");
  const keys = keyDialog(model);
  const take = takeMenu(model);
  const tools = element("div", "tools");
  tools.append(
    take.element,
    themeButton(model),
    button("Tour", "Five steps through the page", () => tour(root, true)),
    button("?", "Keys and help (?)", () => keys.open()),
  );
  bar.append(title, tabList(model), tools);
  root.append(bar, errorLine(model), summary(model), keys.element);
  shortcuts(model, keys, take);
  const fit = () => { darken(); forTouch(); forNarrow(); };
  // Another tab brings other figures.
  model.on("tab", () => whenDrawn(root, fit));
  whenDrawn(root, () => { fit(); landmark(); tour(root, false); });
  return root;
}

// What the head belongs to; it scrolls, so keys must reach it.
function landmark() {
  const stage = inPage(".stage");
  stage?.setAttribute("role", "main");
  if (stage) stage.tabIndex = 0;
}

// Figures come a moment after this component, or before it: its root stands in the page only when it has been returned.
function whenDrawn(root, act, wait = 0, tries = 200) {
  setTimeout(() => {
    if (root.isConnected && window.Bokeh?.documents[0]?.is_idle) act();
    else if (tries > 0) whenDrawn(root, act, 50, tries - 1);
  }, wait);
}

// ---- tabs -----------------------------------------------------------------------------------------------------------

function tabList(model) {
  const list = element("div", "tabs");
  list.setAttribute("role", "tablist");
  list.setAttribute("aria-label", "Parts of the page");
  const tabs = model.tabs.map(([key, title], index) => {
    const tab = button(title, "", () => open(key));
    tab.title = `${title} (Shift+${index + 1})`;
    tab.setAttribute("role", "tab");
    tab.dataset.tab = key;
    return tab;
  });
  list.append(...tabs);
  list.addEventListener("keydown", (event) => {
    const step = { ArrowRight: 1, ArrowLeft: -1, Home: -tabs.length, End: tabs.length }[event.key];
    if (!step) return;
    event.preventDefault();
    const now = tabs.findIndex((tab) => tab.dataset.tab === model.tab);
    const next = Math.abs(step) > 1 ? (step < 0 ? 0 : tabs.length - 1) : (now + step + tabs.length) % tabs.length;
    tabs[next].focus();
    tabs[next].click();
  });
  const open = (key) => { if (key !== model.tab) say("tab", { value: key }); };
  hear("tab-number", ({ value }) => tabs[value]?.click());
  const draw = () => tabs.forEach((tab) => {
    const on = tab.dataset.tab === model.tab;
    tab.setAttribute("aria-selected", String(on));
    tab.tabIndex = on ? 0 : -1;
  });
  model.on("tab", draw);
  draw();
  return list;
}

// ---- errors, and the summary for screen readers ---------------------------------------------------------------------

function errorLine(model) {
  const line = element("div", "error");
  line.setAttribute("role", "alert");
  const text = element("span");
  let here = ""; // what failed in this browser, of which the server knows nothing
  const draw = () => {
    text.textContent = model.error || here;
    line.hidden = !text.textContent;
  };
  const failed = (what) => { here = what; draw(); };
  line.append(text, button("Close", "Close this message", () => { model.error = ""; failed(""); }));
  model.on("error", draw);
  hear("failed", ({ value }) => failed(value));
  draw();
  return line;
}

function summary(model) {
  const text = element("p", "unseen summary");
  text.setAttribute("aria-live", "polite");
  const draw = () => { text.textContent = model.summary; };
  model.on("summary", draw);
  draw();
  return text;
}

// ---- keys -----------------------------------------------------------------------------------------------------------

const KEYS = [
  ["1 2 3 4", "scenes [A] to [D]"],
  ["Shift + 1 2 3 …", "tabs"],
  ["← →", "move the slider that has the focus"],
  ["Space", "play or pause the motion"],
  [", .", "one step back or forth in time"],
  ["P", "pin this result, or unpin it"],
  ["R", "reset"],
  ["Ctrl + Z, Ctrl + Shift + Z", "undo, redo"],
  ["T", "take away"],
  ["L", "light or dark"],
  ["Escape", "close; in a field: back to the last good value"],
  ["?", "this list"],
];

function keyDialog(model) {
  const dialog = element("dialog", "keys");
  dialog.setAttribute("aria-label", "Keys");
  const list = element("dl");
  for (const [key, what] of KEYS) list.append(element("dt", "", key), element("dd", "", what));
  const single = element("label", "single");
  const box = element("input");
  box.type = "checkbox";
  box.checked = singleKeys();
  box.addEventListener("change", () => memory.set("keys", box.checked ? "on" : "off"));
  single.append(box, element("span", "", "single keys work (switch off if you speak or use a switch)"));
  const more = button("Open Help", "", () => { dialog.close(); say("tab", { value: "help" }); });
  const close = button("Close", "", () => dialog.close());
  const row = element("div", "row");
  row.append(more, close);
  dialog.append(element("h2", "", "Keys"), list, single, row);
  return { element: dialog, open: () => dialog.showModal() };
}

const singleKeys = () => memory.get("keys") !== "off";

function shortcuts(model, keys, take) {
  document.addEventListener("keydown", (event) => {
    const target = event.composedPath()[0];
    const typing = target.matches?.("input[type=text], textarea, select, [contenteditable]");
    if ((event.ctrlKey || event.metaKey) && event.key.toLowerCase() === "z" && !event.altKey && !typing) {
      event.preventDefault();
      say(event.shiftKey ? "redo" : "undo");
      return;
    }
    if (typing || event.ctrlKey || event.metaKey || event.altKey || !singleKeys() || keys.element.open) return;
    const digit = /^Digit([1-9])$/.exec(event.code)?.[1];
    const act = digit ? (event.shiftKey ? () => say("tab-number", { value: digit - 1 })
                                        : () => "ABCD"[digit - 1] && say("scene", { value: "ABCD"[digit - 1] }))
      : single(event, target, { keys, take });
    if (!act) return;
    event.preventDefault();
    act();
  });
}

function single(event, target, { keys, take }) {
  if (event.key === " ") return target.matches?.("button, summary, input, a") ? null : () => say("play");
  return {
    "?": () => keys.open(),
    ",": () => say("step", { value: -1 }),
    ".": () => say("step", { value: 1 }),
    p: () => say("toggle-pin"),
    r: () => say("reset"),
    t: () => take.toggle(),
    l: () => say("theme"),
  }[event.key.toLowerCase()];
}

// ---- small screens ------------------------------------------------------------------------------------------------------

const allFigures = () => [...Bokeh.documents[0].all_models].filter((model) => model.type === "Figure");

// A finger that drags over a figure scrolls the page; a tap still shows values and sets η.
function forTouch() {
  if (!matchMedia("(pointer: coarse)").matches) return;
  for (const tool of allFigures().flatMap((figure) => figure.toolbar.tools)) {
    if (["BoxZoomTool", "PanTool", "WheelZoomTool"].includes(tool.type)) tool.setv({ active: false }, HERE);
  }
}

// A legend in one row would not fit, and in more it would hide curves: it stands above the frame.
function forNarrow() {
  if (innerWidth > 700) return;
  for (const figure of allFigures()) {
    const legends = figure.center.filter((part) => part.type === "Legend");
    if (!legends.length) continue;
    for (const legend of legends) legend.setv({ ncols: 2 }, HERE);
    const center = figure.center.filter((part) => !legends.includes(part));
    figure.setv({ center, above: [...figure.above, ...legends] }, HERE);
  }
}
