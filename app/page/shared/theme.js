// Light and dark. The page follows by its style sheet; Bokeh's figures do not know style sheets, so each of their
// colours is exchanged here, by this table, without the server. Light is how they are made (`base.py`).

const DARK = {
  "#FFFFFF": "#171E26", // paper
  "#22303C": "#E4E9EE", // ink
  "#E4E8EC": "#2A343E", // grid
  "#8A97A3": "#7F8C98", // axes
  "#C6CDD4": "#3C4854", // outline
  "#F1F3F5": "#222B34", // ground of the strip
  "#76818C": "#A7B1BB", // pinned
  "#0072B2": "#56B4E9", // reference: both blues are Okabe and Ito's
  "#D55E00": "#F0A030", // penalty, time step
  "#007A5A": "#3CC796", // K and D
  "#8A5A9E": "#C79BD8", // joint damping
};
const LIGHT = Object.fromEntries(Object.entries(DARK).map(([light, dark]) => [dark, light]));

const system = matchMedia("(prefers-color-scheme: dark)");
let chosen = null; // by the link, or by this user: now or on an earlier visit
const isDark = () => (chosen ?? (system.matches ? "dark" : "light")) === "dark";

function themeButton(model) {
  chosen = model.theme || memory.get("theme");
  const tell = () => model.send_msg({ theme: chosen }); // what the user has chosen goes into the link
  if (chosen && !model.theme) tell();
  const made = button("", "", () => {
    chosen = isDark() ? "light" : "dark";
    memory.set("theme", chosen);
    tell();
    darken();
  });
  const draw = () => {
    made.textContent = isDark() ? "☀" : "☾";
    const name = isDark() ? "Light page (L)" : "Dark page (L)";
    made.title = name;
    made.setAttribute("aria-label", name);
  };
  hear("theme", () => made.click());
  hear("themed", draw);
  system.addEventListener("change", darken);
  draw();
  return made;
}

function darken() {
  document.documentElement.dataset.theme = isDark() ? "dark" : "light";
  const table = isDark() ? DARK : LIGHT;
  for (const doc of window.Bokeh?.documents ?? []) {
    for (const model of doc.all_models) exchange(model, table);
  }
  say("themed");
}

function exchange(model, table) {
  const changed = {};
  for (const property of Object.values(model.properties)) {
    if (property.attr !== "palette" && !property.attr.endsWith("color")) continue;
    if (property.is_unset) continue;
    const old = property.get_value();
    const now = exchanged(old, table);
    if (now !== old) changed[property.attr] = now;
  }
  if (!Object.keys(changed).length) return;
  model.setv(changed, HERE);
  if (model.type === "Figure") wipe(model);
}

// Bokeh clears a canvas half a pixel off: at its edges the former colours would shine through. It paints anew at once.
function wipe(model) {
  const canvas = Bokeh.index.find_one_by_id(model.id)?.canvas_view?.primary.canvas;
  if (canvas) canvas.width = canvas.width;
}

// A colour, with or without opacity behind it; a value that holds one; a palette.
function exchanged(value, table) {
  if (typeof value === "string") {
    const upper = value.toUpperCase();
    const found = table[upper.slice(0, 7)];
    return found ? found + upper.slice(7) : value;
  }
  if (Array.isArray(value)) {
    const all = value.map((one) => exchanged(one, table));
    return all.some((one, i) => one !== value[i]) ? all : value;
  }
  if (typeof value?.value === "string") {
    const one = exchanged(value.value, table);
    return one === value.value ? value : { ...value, value: one };
  }
  return value;
}
