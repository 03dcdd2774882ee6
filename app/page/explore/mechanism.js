// The animated system: the reference filled, the penalty solution as an outline over it.

import { Instant, MARKED, Marks, SOLVERS, TIME_FIGURES, watchPointer } from "./instant.js";
import { SystemDrawing } from "../shared/bodies.js";
import { alignFrames, button, columnsOf, element, follow, listen, modelOf, oncePer, viewOf, whenever } from "../shared/dom.js";

const STEP = 0.01; // of one key press, in periods
const REST = 200; // ms

export function render({ model }) {
  const drawing = new Drawing(model);
  const player = new Player(model, drawing);
  const head = element("h2");
  follow(model, "system", () => { head.textContent = model.system.head; });
  const root = element("div", "mechanism", [head, drawing.element, player.element]);
  // The figures come after this component.
  const drawn = () => modelOf("displacements") && MARKED.every((name) => viewOf(name)?.has_finished());
  whenever(drawn, () => player.begin());
  return root;
}

// The drawing of the present instant, as large as the motion of both solutions allows.
class Drawing extends SystemDrawing {
  constructor(model) {
    super(SOLVERS);
    this.element.classList.add("moving");
    this.element.outlines = () => this.outlines(); // for its file
    this.model = model;
    this.draw();
  }

  // The system as it is, before anything moves.
  draw() {
    this.set({ ...this.model.system });
    this.element.setAttribute("aria-label", `${this.model.words} At the present phase.`);
  }

  // All lengths in the units of the columns.
  fit(columns) {
    const { absolute, amplitude, system } = this.model;
    const lengths = { clearance: amplitude * system.clearance, base: amplitude * system.base };
    if (system.clearance2 !== null) lengths.clearance2 = amplitude * system.clearance2;
    lengths.separate = system.separate.map((x) => amplitude * x);
    this.set({ ...system, ...lengths });
    let largest = system.base ? Math.abs(lengths.base) : 0;
    for (const solver of SOLVERS) {
      for (const body of system.kind === "wall" ? [1] : [1, 2]) {
        const rest = this.rest[body - 1];
        for (const x of columns[`${solver}${body}`] ?? []) if (Math.abs(x - rest) > largest) largest = Math.abs(x - rest);
      }
    }
    super.fit(largest + (absolute ? Math.abs(lengths.base) : 0));
  }

  at(instant) {
    const states = SOLVERS.map((solver) => [solver, [1, 2].map((body) => instant.state(solver, body)[0])]);
    this.show(instant.base, Object.fromEntries(states), (solver) => instant.contact(solver));
  }
}

class Player {
  constructor(model, drawing) {
    this.model = model;
    this.drawing = drawing;
    this.read();
    this.time = 0;
    this.playing = false;
    this.held = false; // the pointer on a figure holds the instant
    this.moving = false; // a move of the settings has no answer yet
    this.visible = false; // false while scrolled out of view, or in a hidden tab
    this.animating = false; // an animation frame is requested
    this.element = element("div", "player");
    this.button = button("▶", "Play", () => this.chosen(() => this.play(!this.playing)), "play");
    this.slider = element("input", "", "", { "aria-label": "Phase τ/T in the periods that are shown" });
    Object.assign(this.slider, { type: "range", min: 0, max: model.window, step: 0.005, value: 0 });
    this.slider.addEventListener("input", () => this.chosen(() => { this.play(false); this.go(Number(this.slider.value)); }));
    this.readout = element("output", "readout", "time 0.000 T");
    this.speed = 0.1; // periods a second
    this.element.append(this.button, this.slider, this.readout);
  }

  // Copies what each instant needs: to read a value of the model takes as long as to draw the bodies.
  read() {
    const { absolute, amplitude, system, window } = this.model;
    this.values = { absolute, amplitude, system, window };
  }

  // Begins when the figures are there.
  begin() {
    this.marks = new Marks();
    alignFrames(TIME_FIGURES.map(viewOf));
    const changed = oncePer(queueMicrotask, () => {
      this.read();
      this.drawing.draw();
      this.drawing.fit(columnsOf("displacements"));
      this.slider.max = this.values.window;
      this.go(Math.min(this.time, this.values.window));
    });
    // The flash depends on the contact strips, which may change after the displacements.
    for (const name of ["displacements", ...SOLVERS.map((solver) => `strip_${solver}`)]) {
      modelOf(name).properties.data.change.connect(changed);
    }
    for (const name of ["absolute", "amplitude", "system", "window"]) this.model.on(name, changed);
    watchPointer(() => this.values.window, (time) => { this.held = true; this.go(time); }, () => this.release());
    new IntersectionObserver(([{ isIntersecting }]) => {
      this.visible = isIntersecting;
      this.animate();
    }).observe(this.element);
    listen("speed", ({ value }) => { this.speed = value; });
    listen("play", () => this.chosen(() => this.play(!this.playing)));
    listen("step", ({ value }) => this.chosen(() => {
      this.play(false);
      this.go((this.time + value * STEP + this.values.window) % this.values.window);
    }));
    listen("moving", ({ value }) => { this.moving = value; this.animate(); });
    if (this.model.held !== null) this.time = this.model.held;
    changed();
    this.play(this.model.held === null && !matchMedia("(prefers-reduced-motion: reduce)").matches);
  }

  // The user plays, pauses or sets the phase: once that rests, the server hears of it, for the link.
  chosen(act) {
    act();
    clearTimeout(this.resting);
    this.resting = setTimeout(() => {
      const held = this.playing ? null : this.time;
      if (held !== this.model.held) this.model.send_msg({ held });
    }, REST);
  }

  // The pointer leaves: a motion goes on, an instant that was pointed at stays as one that was set.
  release() {
    if (!this.held) return;
    this.held = false;
    this.chosen(() => this.animate());
  }

  play(on) {
    this.playing = on;
    this.button.textContent = on ? "❚❚" : "▶";
    this.button.setAttribute("aria-label", on ? "Pause" : "Play");
    this.button.title = on ? "Pause (Space)" : "Play (Space)";
    this.animate();
  }

  // Animation frames are requested only while something moves, since each costs time.
  get still() {
    return !this.playing || this.held || this.moving || !this.visible;
  }

  animate() {
    if (this.animating || this.still) return;
    this.animating = true;
    let last = null;
    const frame = (now) => {
      this.animating = !this.still;
      if (!this.animating) return;
      requestAnimationFrame(frame);
      const passed = last === null ? 0 : Math.min((now - last) / 1000, 0.1);
      last = now;
      this.go((this.time + passed * this.speed) % this.values.window);
    };
    requestAnimationFrame(frame);
  }

  go(time) {
    this.time = time;
    const instant = new Instant(time, this.values);
    if (!instant.ready) return;
    this.drawing.at(instant);
    this.slider.value = time;
    this.slider.setAttribute("aria-valuetext", `${time.toFixed(2)} periods`);
    this.readout.textContent = `time ${time.toFixed(3)} T`;
    this.marks.put(instant);
  }
}
