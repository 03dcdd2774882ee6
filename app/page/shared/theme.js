// The light and the dark theme. The page itself follows its style sheet. Bokeh's figures do not, so their colours are
// exchanged here in the browser, by a table of the server, which makes figures in the light theme (`shared/figure.py`).

import { LOCAL, button, emit, listen, preferences } from "./dom.js";

const DARK = {}; // by the colour in the light theme, upper case; the server gives it
const system = matchMedia("(prefers-color-scheme: dark)");
let chosen = null; // "light" or "dark", chosen by the link or by the user, now or on an earlier visit
const isDark = () => (chosen ?? (system.matches ? "dark" : "light")) === "dark";

export function themeButton(model) {
  Object.assign(DARK, model.dark);
  chosen = model.theme || preferences.get("theme");
  const send = () => model.send_msg({ theme: chosen }); // for the link
  if (chosen && !model.theme) send();
  const made = button("", "", () => {
    chosen = isDark() ? "light" : "dark";
    preferences.set("theme", chosen);
    send();
    darken();
  });
  const draw = () => {
    made.textContent = isDark() ? "☀" : "☾";
    const name = isDark() ? "Light page (L)" : "Dark page (L)";
    made.title = name;
    made.setAttribute("aria-label", name);
  };
  listen("theme", () => made.click());
  listen("theme-changed", draw);
  system.addEventListener("change", darken);
  draw();
  return made;
}

export function darken() {
  document.documentElement.dataset.theme = isDark() ? "dark" : "light";
  const table = isDark() ? DARK : Object.fromEntries(Object.entries(DARK).map(([light, dark]) => [dark, light]));
  for (const doc of window.Bokeh?.documents ?? []) {
    for (const model of doc.all_models) exchangeColours(model, table);
  }
  emit("theme-changed");
}

function exchangeColours(model, table) {
  const changed = {};
  for (const property of Object.values(model.properties)) {
    if (property.attr !== "palette" && !property.attr.endsWith("color")) continue;
    if (property.is_unset) continue;
    const old = property.get_value();
    const now = counterpart(old, table);
    if (now !== old) changed[property.attr] = now;
  }
  if (!Object.keys(changed).length) return;
  model.setv(changed, LOCAL);
  if (model.type === "Figure") clearCanvas(model);
}

// Bokeh clears a canvas half a pixel off, so that the previous colours would remain at its edges. It repaints by itself.
function clearCanvas(model) {
  const canvas = Bokeh.index.find_one_by_id(model.id)?.canvas_view?.primary.canvas;
  if (canvas) canvas.width = canvas.width;
}

// The counterpart of a colour (with or without opacity), of a value specification that holds a colour, or of a palette.
function counterpart(value, table) {
  if (typeof value === "string") {
    const upper = value.toUpperCase();
    const found = table[upper.slice(0, 7)];
    return found ? found + upper.slice(7) : value;
  }
  if (Array.isArray(value)) {
    const all = value.map((one) => counterpart(one, table));
    return all.some((one, i) => one !== value[i]) ? all : value;
  }
  if (typeof value?.value === "string") {
    const one = counterpart(value.value, table);
    return one === value.value ? value : { ...value, value: one };
  }
  return value;
}
