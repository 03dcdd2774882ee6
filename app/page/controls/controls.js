// The input panel. It sends texts and draws what the server accepted; it decides nothing.

const BUSY_AFTER = 150; // ms without an answer before the page says that it is computing
const OVERTAKE_AFTER = 250; // ms after which a move is sent although the last one is not answered
const SETTLED_AFTER = 250; // ms without a move before the address follows

export function render({ model }) {
  const root = element("form", "panel");
  root.setAttribute("aria-label", "Settings");
  root.addEventListener("submit", (event) => event.preventDefault());
  const link = new Link(model, root);
  const folded = details(model.spec, link);
  const first = [scenes(model.spec.scenes, link), actions(link)];
  const sliders = model.spec.sliders.map((slider) => sliderRow(slider, link));
  const shown = model.spec.shown.map((choice) => switchRow(choice, link));
  const ofMotions = [...shown.slice(0, -1), key()]; // all but the units, which the notes of the sliders follow, too
  const parts = [...first, ...sliders, ...folded.parts, ...shown, ofMotions.at(-1)];
  const elements = (some) => some.map((part) => part.element);
  root.append(
    link.busyMark(),
    group("first", ...elements(first)),
    group("sliders", ...elements(sliders)),
    group("rest", folded.box, tucked("What is shown", ...elements([...shown, ofMotions.at(-1)]))),
  );
  const hide = () => {
    root.hidden = !model.visible; // on a narrow page what is around it has no box that could be hidden
    for (const { element } of ofMotions) element.hidden = !model.motions;
  };
  for (const what of ["visible", "motions"]) model.on(what, hide);
  hide();
  const draw = () => {
    const shown = model.shown;
    if (!shown.texts) return;
    const echo = link.answered(shown);
    parts.forEach((part) => part.draw(shown, echo));
    folded.draw(shown);
  };
  model.on("shown", draw);
  draw();
  return root;
}

function group(name, ...content) {
  const box = element("div", `group ${name}`);
  box.append(...content);
  return box;
}

// Folded away where the page is narrow; elsewhere it is always open.
function tucked(title, ...content) {
  const box = element("details", "tucked");
  box.append(element("summary", "", title), ...content);
  const narrow = matchMedia("(max-width: 1000px)");
  const fold = () => { box.open = !narrow.matches; };
  narrow.addEventListener("change", fold);
  fold();
  return box;
}

// Talks to the server: the first move at once, then one message per animation frame at most,
// with the latest value of each name.
class Link {
  constructor(model, root) {
    this.model = model;
    this.root = root;
    this.move = 0;
    this.waiting = null;
    this.paced = false;
    this.sentAt = 0;
    this.answeredMove = 0;
    this.painted = 0;
    for (const what of ["scene", "undo", "redo", "reset", "pin", "tab"]) {
      hear(what, (detail) => this.act({ [what]: detail.value ?? true }));
    }
    hear("set", (texts) => this.set(texts));
  }

  set(texts) {
    this.waiting = { ...(this.waiting ?? {}), ...texts };
    if (!this.paced) this.flush();
  }

  flush() {
    clearTimeout(this.overtaking);
    if (!this.waiting) return;
    const patience = this.sentAt + OVERTAKE_AFTER - performance.now();
    if (this.answeredMove < this.move && patience > 0) {
      // One move in flight: what queues up on the way to the server, nothing there can overtake.
      this.overtaking = setTimeout(() => this.flush(), patience);
      return;
    }
    const texts = this.waiting;
    this.waiting = null;
    this.send({ set: texts });
    this.pace();
  }

  // A frame costs the browser something even if nothing changed: none is asked for to wait in.
  pace() {
    this.paced = true;
    requestAnimationFrame(() => {
      this.paced = false;
      this.flush();
    });
  }

  // What is no move of a slider comes after those that wait.
  act(message) {
    const texts = this.waiting;
    this.waiting = null;
    if (texts) this.send({ set: texts });
    this.send(message);
  }

  send(message) {
    this.move += 1;
    this.sentAt = performance.now();
    this.model.send_msg({ ...message, move: this.move });
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.busy(true), BUSY_AFTER);
    say("moving", { value: true });
  }

  // True when this answers the latest move and none waits to be sent: only then may it overwrite what the user is
  // moving, or a key pressed meanwhile would start from the value before.
  answered(shown) {
    if (shown.frame > this.painted) {
      this.painted = shown.frame;
      afterPaint(() => this.model.send_msg({ painted: shown.frame }));
    }
    this.root.dataset.frame = shown.frame;
    this.answeredMove = shown.move;
    if (this.waiting && !this.paced) this.pace();
    if (shown.move < this.move || this.waiting) return false;
    this.root.dataset.move = shown.move;
    clearTimeout(this.timer);
    this.busy(false);
    this.follow(shown);
    say("moving", { value: false });
    return true;
  }

  follow(shown) {
    clearTimeout(this.settling);
    if (!shown.address || shown.refused.name) return;
    const write = () => history.replaceState(history.state, "", `?${shown.address}`);
    this.settling = setTimeout(write, SETTLED_AFTER);
  }

  busy(on) {
    this.root.setAttribute("aria-busy", String(on));
    this.mark.hidden = !on;
  }

  busyMark() {
    this.mark = element("div", "busy", "computing …");
    this.mark.setAttribute("role", "status");
    this.mark.hidden = true;
    return this.mark;
  }
}

function afterPaint(done) {
  // A hidden page paints nothing, yet the server must not wait for it.
  if (document.hidden) setTimeout(done, 0);
  else requestAnimationFrame(done);
}

function scenes(list, link) {
  const box = element("fieldset", "scenes");
  box.append(element("legend", "", "Scenes of the paper"));
  const rows = new Map();
  const buttons = new Map();
  for (const scene of list) {
    if (!rows.has(scene.group)) rows.set(scene.group, sceneRow(scene.group));
    const made = button(scene.group === "motion" ? `[${scene.label}]` : scene.label, scene.tooltip,
      () => link.act({ scene: scene.key }));
    made.setAttribute("aria-label", `${scene.group} ${scene.label}: ${scene.tooltip}`);
    if (scene.group === "motion") made.append(element("small", "", `η ${scene.eta.toFixed(2)}`));
    rows.get(scene.group).append(made);
    buttons.set(scene.key, made);
  }
  const [motions, ...sets] = rows.values();
  box.append(motions, tucked("Scenes of its other figures", ...sets));
  const draw = (shown) => {
    buttons.forEach((made, key) => made.setAttribute("aria-pressed", String(shown.scenes.includes(key))));
  };
  return { element: box, draw };
}

function sceneRow(name) {
  const row = element("div", name === "motion" ? "row motions" : "row sets");
  if (name !== "motion") row.append(element("span", "", name));
  return row;
}

function actions(link) {
  const row = element("div", "row actions");
  const undo = button("↶ Undo", "Undo the last move (Ctrl+Z)", () => link.act({ undo: true }));
  const redo = button("↷ Redo", "Redo (Ctrl+Shift+Z)", () => link.act({ redo: true }));
  const reset = button("Reset", "Back to the default setting, its ranges and no pin (R)", () => link.act({ reset: true }));
  const pin = button("Pin", "Keep this result as thin grey curves, to compare the next with it (P)",
    () => link.act({ pin: pin.getAttribute("aria-pressed") !== "true" }));
  hear("toggle-pin", () => pin.click());
  row.append(undo, redo, reset, pin);
  const draw = (shown) => {
    undo.disabled = !shown.undo;
    redo.disabled = !shown.redo;
    pin.setAttribute("aria-pressed", String(shown.pinned));
  };
  return { element: row, draw };
}

// A typed value, what was refused of it, and why.
function typedField(number, link, place) {
  const typed = input("text", `vibroscope-${number.name}-typed`, `${number.label}: ${number.hint}, typed`);
  typed.inputMode = "decimal";
  typed.autocomplete = "off";
  const refusal = element("p", "refusal");
  refusal.id = `vibroscope-${number.name}-refusal`;
  refusal.setAttribute("role", "alert");
  refusal.hidden = true;
  let accepted = "";
  let begun = false; // something is being typed, which no answer may take away
  typed.addEventListener("input", () => { begun = true; });
  typed.addEventListener("change", () => {
    begun = false;
    link.set({ [number.name]: typed.value.trim().replace(",", ".") });
  });
  typed.addEventListener("blur", () => {
    if (begun) typed.value = accepted; // it is what it was, or the change would have been told
    begun = false;
  });
  typed.addEventListener("keydown", (event) => {
    if (event.key !== "Escape") return;
    begun = false;
    typed.value = accepted;
    link.set({ [number.name]: accepted });
  });
  place.append(refusal);
  const draw = (shown, echo) => {
    accepted = shown.texts[number.name];
    const refused = shown.refused.name === number.name;
    typed.setAttribute("aria-invalid", String(refused));
    if (refused) typed.setAttribute("aria-describedby", refusal.id);
    else typed.removeAttribute("aria-describedby");
    refusal.hidden = !refused;
    refusal.textContent = refused ? `${shown.refused.text} Escape brings back ${accepted}.` : "";
    if (echo && !refused && !begun) typed.value = accepted;
  };
  return { typed, draw };
}

function sliderRow(slider, link) {
  const box = element("div", "slider");
  const id = `vibroscope-${slider.name}`;
  const label = element("label", "", slider.label);
  label.htmlFor = `${id}-typed`;
  label.append(element("small", "", slider.hint));
  const range = input("range", `${id}-slider`, `${slider.label}: ${slider.hint}`);
  const scale = scaleOf(slider);
  range.min = scale.position(slider.low);
  range.max = scale.position(slider.high);
  range.step = slider.step;
  const note = element("div", "note");
  const field = typedField(slider, link, note);
  const words = element("span");
  note.prepend(words);
  range.addEventListener("input", () => {
    field.typed.value = scale.text(Number(range.value));
    range.setAttribute("aria-valuetext", `${slider.label} ${field.typed.value}`);
    link.set({ [slider.name]: field.typed.value });
  });
  box.append(label, field.typed, range, note);
  const draw = (shown, echo) => {
    words.textContent = shown.notes[slider.name] ?? "";
    field.draw(shown, echo);
    if (!echo || shown.refused.name === slider.name) return;
    range.value = scale.position(Number(shown.texts[slider.name]));
    range.setAttribute("aria-valuetext", `${slider.label} ${shown.texts[slider.name]}`);
  };
  return { element: box, draw };
}

function input(type, id, name) {
  const made = element("input");
  made.type = type;
  made.id = id;
  made.setAttribute("aria-label", name);
  return made;
}

// Slider position and printed value; logarithmic sliders move in decades, with three significant digits.
function scaleOf(slider) {
  const clip = (value) => Math.min(slider.high, Math.max(slider.low, value));
  if (!slider.log) return { position: (value) => value, text: (p) => String(Number(clip(p).toFixed(4))) };
  const round = (value) => Number(clip(value).toPrecision(3));
  return {
    position: (value) => Math.log10(value),
    text: (p) => String(slider.whole ? Math.round(round(10 ** p)) : round(10 ** p)),
  };
}

// System and solver: seldom moved, so folded away; open where the address or a refusal concerns them.
function details(spec, link) {
  const box = element("details", "more");
  box.append(element("summary", "", "System and solver"));
  const grid = element("div", "numbers");
  const parts = spec.numbers.map((number) => numberRow(number, link));
  const switches = spec.folded.map((choice) => switchRow(choice, link));
  grid.append(...parts.map((part) => part.element));
  box.append(grid, ...switches.map((part) => part.element));
  const names = [...spec.numbers, ...spec.folded].map((one) => one.name);
  let opened = false;
  const draw = (shown) => {
    const moved = !opened && names.some((name) => shown.texts[name] !== spec.defaults[name]);
    if (moved || names.includes(shown.refused.name)) box.open = opened = true;
  };
  return { box, parts: [...parts, ...switches], draw };
}

function numberRow(number, link) {
  const box = element("div", "number");
  const label = element("label", "", number.label);
  label.htmlFor = `vibroscope-${number.name}-typed`;
  label.title = number.hint;
  const under = element("div", "under");
  const field = typedField(number, link, under);
  field.typed.title = `${number.hint}; ${number.low} to ${number.high}`;
  box.append(label, field.typed, under);
  return { element: box, draw: field.draw };
}

function switchRow(choice, link) {
  const box = element("fieldset", "switch");
  const legend = element("legend", "", choice.label);
  legend.title = choice.doc;
  box.append(legend);
  const row = element("div", "row");
  const inputs = new Map();
  for (const [value, text] of Object.entries(choice.choices)) {
    const label = element("label");
    const radio = element("input");
    radio.type = "radio";
    radio.name = `vibroscope-${choice.name}`;
    radio.value = value;
    radio.addEventListener("change", () => link.set({ [choice.name]: value }));
    label.append(radio, element("span", "", text));
    row.append(label);
    inputs.set(value, radio);
  }
  box.append(row);
  const draw = (shown, echo) => {
    if (echo) inputs.get(shown.texts[choice.name]).checked = true;
  };
  return { element: box, draw };
}

function key() {
  const list = element("dl", "key");
  list.setAttribute("aria-label", "Key");
  const section = element("dt", "section", "●");
  section.append(element("span", "", "◇"));
  list.append(
    element("dt", "reference"), element("dd", "", "reference: exact, impact law"),
    element("dt", "penalty"), element("dd", "", "penalty: K, D, Newmark, step Δτ"),
    section, element("dd", "", "state at τ ≡ 0 (mod T)"),
  );
  return { element: list, draw: () => {} };
}
