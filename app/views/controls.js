// The input panel. It sends texts and draws what the server accepted; it decides nothing.

const BUSY_AFTER = 150; // ms without an answer before the page says that it is computing
const OVERTAKE_AFTER = 250; // ms after which a move is sent although the last one is not answered
const SETTLED_AFTER = 250; // ms without a move before the address follows

export function render({ model, el }) {
  const root = document.createElement("form");
  root.className = "panel";
  root.setAttribute("aria-label", "Settings");
  root.addEventListener("submit", (event) => event.preventDefault());
  const link = new Link(model, root);
  const parts = [
    scenes(model.spec.scenes, link),
    ...model.spec.sliders.map((slider) => sliderRow(slider, link)),
    ...model.spec.switches.map((choice) => switchRow(choice, link)),
    key(),
  ];
  root.append(link.busyMark(), ...parts.map((part) => part.element));
  const draw = () => {
    const shown = model.shown;
    if (!shown.texts) return;
    const echo = link.answered(shown);
    parts.forEach((part) => part.draw(shown, echo));
  };
  model.on("shown", draw);
  draw();
  return root;
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
  }

  set(texts) {
    this.waiting = { ...(this.waiting ?? {}), ...texts };
    if (!this.paced) this.flush();
  }

  scene(key) {
    this.send({ scene: key });
  }

  flush() {
    this.paced = this.waiting !== null;
    if (!this.paced) return;
    requestAnimationFrame(() => this.flush());
    // One move in flight: what queues up on the way to the server, nothing there can overtake.
    if (this.answeredMove < this.move && performance.now() - this.sentAt < OVERTAKE_AFTER) return;
    const texts = this.waiting;
    this.waiting = null;
    this.send({ set: texts });
  }

  send(message) {
    this.move += 1;
    this.sentAt = performance.now();
    this.model.send_msg({ ...message, move: this.move });
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.busy(true), BUSY_AFTER);
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
    if (shown.move < this.move || this.waiting) return false;
    this.root.dataset.move = shown.move;
    clearTimeout(this.timer);
    this.busy(false);
    this.follow(shown);
    return true;
  }

  follow(shown) {
    clearTimeout(this.settling);
    if (!shown.address || shown.refused) return;
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
  // A hidden tab paints nothing, yet the server must not wait for it.
  if (document.hidden) setTimeout(done, 0);
  else requestAnimationFrame(() => setTimeout(done, 0));
}

function element(tag, className = "", text = "") {
  const made = document.createElement(tag);
  if (className) made.className = className;
  if (text) made.textContent = text;
  return made;
}

function scenes(list, link) {
  const box = element("fieldset", "scenes");
  box.append(element("legend", "", "Scenes of the paper"));
  const rows = new Map();
  const buttons = new Map();
  for (const scene of list) {
    if (!rows.has(scene.group)) rows.set(scene.group, sceneRow(scene.group, box));
    const button = element("button", "", scene.group === "motion" ? `[${scene.label}]` : scene.label);
    button.type = "button";
    button.title = scene.tooltip;
    button.setAttribute("aria-label", `${scene.group} ${scene.label}: ${scene.tooltip}`);
    if (scene.group === "motion") button.append(element("small", "", `η ${scene.eta.toFixed(2)}`));
    button.addEventListener("click", () => link.scene(scene.key));
    rows.get(scene.group).append(button);
    buttons.set(scene.key, button);
  }
  const draw = (shown) => {
    buttons.forEach((button, key) => button.setAttribute("aria-pressed", String(shown.scenes.includes(key))));
  };
  return { element: box, draw };
}

function sceneRow(group, box) {
  const row = element("div", group === "motion" ? "row motions" : "row sets");
  if (group !== "motion") row.append(element("span", "", group));
  box.append(row);
  return row;
}

function sliderRow(slider, link) {
  const box = element("div", "slider");
  const id = `vibroscope-${slider.name}`;
  const label = element("label", "", slider.label);
  label.htmlFor = `${id}-typed`;
  label.append(element("small", "", slider.hint));
  const typed = input("text", `${id}-typed`, `${slider.hint}, typed`);
  typed.inputMode = "decimal";
  typed.autocomplete = "off";
  const range = input("range", `${id}-slider`, slider.hint);
  const scale = scaleOf(slider);
  range.min = scale.position(slider.low);
  range.max = scale.position(slider.high);
  range.step = slider.step;
  const note = element("div", "note");
  range.addEventListener("input", () => {
    typed.value = scale.text(Number(range.value));
    range.setAttribute("aria-valuetext", `${slider.label} ${typed.value}`);
    link.set({ [slider.name]: typed.value });
  });
  typed.addEventListener("change", () => link.set({ [slider.name]: typed.value.trim().replace(",", ".") }));
  box.append(label, typed, range, note);
  const draw = (shown, echo) => {
    if (slider.name === "steps") note.textContent = shown.dtau;
    typed.setAttribute("aria-invalid", String(shown.refused === slider.name));
    if (!echo || shown.refused === slider.name) return;
    typed.value = shown.texts[slider.name];
    range.value = scale.position(Number(typed.value));
    range.setAttribute("aria-valuetext", `${slider.label} ${typed.value}`);
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
    element("dt", "penalty"), element("dd", "", "penalty: K, D, Newmark with step Δτ"),
    section, element("dd", "", "state at τ ≡ 0 (mod T), all kept periods"),
  );
  return { element: list, draw: () => {} };
}
