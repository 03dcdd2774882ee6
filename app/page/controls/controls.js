// The panel of inputs. It sends texts and draws what the server has accepted; it checks nothing itself.

import { input, typedField } from "./field.js";
import { actions, folded, key, scenes, solverDetails, speedRow, startDetails, switchRow } from "./parts.js";
import { systemDetails } from "./system.js";
import { button, cueScroll, element, emit, explainTerms, follow, listen, setText } from "../shared/dom.js";

const BUSY_AFTER = 150; // ms without an answer before the page shows "computing"
const OVERTAKE_AFTER = 250; // ms after which a move is sent although the last one has no answer
const SETTLED_AFTER = 250; // ms without a move before the address changes

export function render({ model }) {
  const root = element("form", "panel", "", { "aria-label": "Settings" });
  root.addEventListener("submit", (event) => event.preventDefault());
  const link = new Link(model, root);
  const units = switchRow(model.spec.units, link);
  const system = systemDetails(model.spec, link, model);
  const solver = solverDetails(model.spec, link);
  const first = [scenes(model.spec, link), actions(model.spec, link)];
  const sliders = model.spec.sliders.map((slider) => sliderRow(slider, link));
  const view = [...model.spec.viewSwitches.map((choice) => switchRow(choice, link)), speedRow(), key()];
  const start = startDetails(model.spec, link);
  const drawn = folded("Display", ...view.map((part) => part.element));
  system.element.firstChild.after(units.element);
  system.element.append(start.element);
  const folds = element("div", "folds", [system.element, solver.element, drawn]);
  const parts = [...first, ...sliders, units, ...system.parts, ...start.parts, ...solver.parts, ...view];
  const elements = (some) => some.map((part) => part.element);
  root.append(
    link.busyMark(),
    group("first", ...elements(first)),
    group("sliders", ...elements(sliders)),
    group("rest", folds),
  );
  const hide = () => {
    root.hidden = !model.visible; // on a narrow page the component has no box of its own that could be hidden
    start.element.hidden = !model.starts;
    drawn.hidden = !model.motions;
  };
  for (const name of ["visible", "starts", "motions"]) model.on(name, hide);
  hide();
  const draw = () => {
    if (!model.shown.texts) return;
    const fields = Object.entries(model.shown.numbers).map(([name, text]) => [
      name,
      { ...model.fields[name], span: model.spans[name], text },
    ]);
    const shown = { ...model.shown, fields: Object.fromEntries(fields) };
    const isLatest = link.receive(shown);
    parts.forEach((part) => part.draw(shown, isLatest));
    for (const { name, element } of view) if (name === "coordinate") element.hidden = shown.texts.bodies === "wall";
  };
  follow(model, "shown", draw);
  explainTerms(root);
  cueScroll(root, true);
  return root;
}

function group(name, ...content) {
  return element("div", `group ${name}`, content);
}

// The connection to the server. It sends the first move at once, then at most one message per animation frame, with the
// latest value of each parameter.
class Link {
  constructor(model, root) {
    this.model = model;
    this.root = root;
    this.move = 0; // number of the last move that was sent
    this.waiting = null; // texts that are still to be sent
    this.paced = false; // whether they wait for the next animation frame
    this.sentAt = 0;
    this.answeredMove = 0;
    this.painted = 0; // number of the last update
    for (const name of ["scene", "undo", "redo", "reset", "pin", "unpin", "view"]) {
      listen(name, (detail) => this.act({ [name]: detail.value ?? true }));
    }
    listen("set", (texts) => this.set(texts));
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
      // Only one move is under way: a queue on the way to the server could not be overtaken.
      this.overtaking = setTimeout(() => this.flush(), patience);
      return;
    }
    const texts = this.waiting;
    this.waiting = null;
    this.send({ set: texts });
    this.pace();
  }

  // Requested only after a move was sent, since an animation frame costs time even if nothing changes.
  pace() {
    this.paced = true;
    requestAnimationFrame(() => {
      this.paced = false;
      this.flush();
    });
  }

  // Sends a message that is no move of a slider, after the moves that wait.
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
    emit("moving", { value: true });
  }

  // Takes an answer; true if it answers the latest move and none waits to be sent. Only then may it change the inputs, or
  // a key that was pressed in the meantime would start from the previous value.
  receive(shown) {
    if (shown.update > this.painted) {
      this.painted = shown.update;
      afterPaint(() => this.model.send_msg({ painted: shown.update }));
    }
    this.root.dataset.update = shown.update;
    this.answeredMove = shown.move;
    if (this.waiting && !this.paced) this.pace();
    if (shown.move < this.move || this.waiting) return false;
    this.root.dataset.move = shown.move;
    clearTimeout(this.timer);
    this.busy(false);
    this.changeAddress(shown);
    emit("moving", { value: false });
    return true;
  }

  changeAddress(shown) {
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
    this.mark = element("div", "busy", "computing …", { role: "status" });
    this.mark.hidden = true;
    return this.mark;
  }
}

function afterPaint(done) {
  // A hidden page is not painted, but the server must not wait for it.
  if (document.hidden) setTimeout(done, 0);
  else requestAnimationFrame(done);
}

function sliderRow(slider, link) {
  const box = element("div", "slider");
  const id = `vibroscope-${slider.name}`;
  const symbol = element("span", "", slider.label);
  const hint = element("small", "", slider.hint);
  const label = element("label", "", [symbol, hint], { for: `${id}-typed` });
  const range = input("range", `${id}-slider`, `${slider.label}: ${slider.hint}`);
  let scale = null; // of the span that the slider covers, which the system decides
  let covered = "";
  const cover = (span) => {
    if (String(span) === covered) return;
    covered = String(span);
    scale = scaleOf(slider, ...span);
    range.min = scale.position(span[0]);
    range.max = scale.position(span[1]);
  };
  range.step = slider.step;
  const note = element("div", "note");
  const field = typedField(slider, link, note);
  const noteText = element("span");
  const offer = button("", "", () => link.set(offered), "offer"); // for who does not know the number
  let offered = {};
  note.prepend(noteText, offer);
  range.addEventListener("input", () => {
    const text = scale.text(Number(range.value));
    field.fill(field.preview(text));
    range.setAttribute("aria-valuetext", `${symbol.textContent} ${field.typed.value} ${field.unit.textContent}`.trim());
    link.set({ [slider.name]: text });
  });
  box.append(label, field.typed, range, note);
  const draw = (shown, isLatest) => {
    const { label: name, name: words, unit, text, span, locked } = shown.fields[slider.name];
    range.disabled = Boolean(locked);
    cover(span);
    setText(symbol, name);
    setText(hint, words);
    noteText.textContent = shown.notes[slider.name] ?? "";
    const found = shown.offers[slider.name];
    offer.hidden = !found;
    if (found) {
      setText(offer, found.text);
      offered = found.set;
    }
    field.draw(shown, isLatest);
    if (!isLatest || shown.refused.name === slider.name) return;
    range.value = scale.position(Number(shown.texts[slider.name]));
    range.setAttribute("aria-valuetext", `${name} ${text} ${unit}`.trim());
  };
  return { element: box, draw };
}

// Position of a slider for a value, and text for a position; logarithmic sliders give three significant digits.
function scaleOf(slider, low, high) {
  const clip = (value) => Math.min(high, Math.max(low, value));
  if (!slider.log) return { position: (value) => value, text: (p) => String(Number(clip(p).toFixed(4))) };
  const round = (value) => Number(clip(value).toPrecision(3));
  return {
    position: (value) => Math.log10(clip(value)), // a typed 0 has no logarithm
    text: (p) => String(slider.whole ? Math.round(round(10 ** p)) : round(10 ** p)),
  };
}
