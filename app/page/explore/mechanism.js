// The animated pendulums: the reference filled, the penalty solution as an outline over it.

const WIDE = 260;
const HIGH = 190;
const PIVOT = 26; // height of the pivots from the top
const ROD = 136;
const BOB = 15; // radius
const REACH = 92; // pixels of the largest displacement
const FLASH = 0.03; // decay time of the flash of an impact, in periods
const SPEEDS = [["0.05", "0.05 periods/s"], ["0.1", "0.1 periods/s"], ["0.25", "0.25 periods/s"], ["0.5", "0.5 periods/s"], ["1", "1 period/s"]];
const STEP = 0.01; // of one key press, in periods
const REST = 200; // ms

export function render({ model }) {
  const root = element("div", "mechanism");
  const drawing = new Drawing();
  const player = new Player(model, drawing);
  root.append(element("h2", "", "The pendulums on their base"), drawing.element, player.element);
  player.begin();
  return root;
}

class Drawing {
  constructor() {
    this.element = svgElement("svg", { viewBox: `0 0 ${WIDE} ${HIGH}`, role: "img" });
    this.element.dataset.figure = "mechanism";
    this.element.setAttribute("aria-label", "Two pendulums side by side on a shaken base, at the present phase");
    this.base = svgElement("g", { class: "base" });
    this.base.append(
      svgElement("rect", { x: WIDE / 2 - 70, y: PIVOT - 16, width: 140, height: 10, rx: 2 }),
      svgElement("circle", { cx: WIDE / 2 - BOB, cy: PIVOT, r: 3.5 }),
      svgElement("circle", { cx: WIDE / 2 + BOB, cy: PIVOT, r: 3.5 }),
    );
    this.element.append(svgElement("line", { x1: 10, x2: WIDE - 10, y1: PIVOT - 20, y2: PIVOT - 20, class: "rail" }));
    this.bodies = Object.fromEntries(SOLVERS.map((solver) => [solver, new Bodies(solver)]));
    this.element.append(this.base, this.bodies.reference.element, this.bodies.penalty.element);
    this.scale = 1;
  }

  // Fits the scale of the drawing to all data, so that it does not change from instant to instant.
  fit(columns, { absolute, amplitude }) {
    let largest = amplitude;
    for (const solver of SOLVERS) {
      for (const pendulum of [1, 2]) {
        for (const x of columns[`${solver}${pendulum}`] ?? []) if (Math.abs(x) > largest) largest = Math.abs(x);
      }
    }
    this.scale = REACH / (largest + (absolute ? amplitude : 0) + amplitude);
  }

  show(instant) {
    const shift = instant.base * this.scale;
    this.base.setAttribute("transform", `translate(${shift} 0)`);
    for (const solver of SOLVERS) this.bodies[solver].show(instant, this.scale, shift);
  }
}

// Both pendulums of one solution, and the flash at their contact.
class Bodies {
  constructor(solver) {
    this.solver = solver;
    this.element = svgElement("g", { class: solver });
    this.rods = [svgElement("line", { class: "rod" }), svgElement("line", { class: "rod" })];
    this.bobs = [svgElement("circle", { r: BOB, class: "bob" }), svgElement("circle", { r: BOB, class: "bob" })];
    this.flash = svgElement("circle", { class: "flash" });
    this.names = [svgElement("text", { class: "name" }), svgElement("text", { class: "name" })];
    this.names.forEach((name, i) => { name.textContent = solver === "reference" ? String(i + 1) : ""; });
    this.element.append(...this.rods, this.flash, ...this.bobs, ...this.names);
  }

  show(instant, scale, shift) {
    const places = [1, 2].map((pendulum) => {
      const pivot = WIDE / 2 + shift + (pendulum === 1 ? -BOB : BOB);
      const out = instant.state(this.solver, pendulum)[0] * scale;
      return { pivot, x: pivot + out, y: PIVOT + Math.sqrt(Math.max(ROD ** 2 - out ** 2, 0)) };
    });
    this.element.style.display = places.every(({ x }) => Number.isFinite(x)) ? "" : "none";
    if (this.element.style.display) return;
    places.forEach(({ pivot, x, y }, i) => {
      put(this.rods[i], { x1: pivot, y1: PIVOT, x2: x, y2: y });
      put(this.bobs[i], { cx: x, cy: y });
      put(this.names[i], { x, y: y + 4 });
    });
    const { age, lasts } = instant.contact(this.solver);
    const brightness = Math.max(Math.exp(-age / FLASH), lasts ? 0.45 : 0);
    const [one, two] = places;
    put(this.flash, { cx: (one.x + two.x) / 2, cy: (one.y + two.y) / 2, r: 8 + 14 * brightness, opacity: brightness });
  }
}

const put = (shape, attributes) => {
  for (const [name, value] of Object.entries(attributes)) shape.setAttribute(name, value);
};

class Player {
  constructor(model, drawing) {
    this.model = model;
    this.drawing = drawing;
    this.time = 0;
    this.playing = false;
    this.held = false; // the pointer on a figure holds the instant
    this.moving = false; // a move of the settings has no answer yet
    this.visible = false; // false while scrolled out of view, or in a hidden tab
    this.animating = false; // an animation frame is requested
    this.element = element("div", "player");
    this.button = button("▶", "Play", () => this.chosen(() => this.play(!this.playing)), "play");
    this.slider = element("input");
    Object.assign(this.slider, { type: "range", min: 0, max: WINDOW, step: 0.005, value: 0 });
    this.slider.setAttribute("aria-label", "Phase τ/T in the last two periods");
    this.slider.addEventListener("input", () => this.chosen(() => { this.play(false); this.go(Number(this.slider.value)); }));
    this.readout = element("output", "readout", "time 0.000 T");
    this.speed = element("select");
    this.speed.setAttribute("aria-label", "Speed of the motion, in periods a second");
    this.speed.append(...SPEEDS.map(([value, text]) => Object.assign(element("option", "", text), { value })));
    this.speed.value = "0.1";
    this.element.append(this.slider, this.button, this.readout, this.speed);
  }

  // Begins when the figures are there; they come after this component.
  begin(tries = 400) {
    const source = modelOf("displacements");
    if (!source || !MARKED.every((name) => viewOf(name)?.has_finished())) {
      if (tries) setTimeout(() => this.begin(tries - 1), 25);
      return;
    }
    this.marks = new Marks();
    alignTimeAxes();
    const changed = oncePerTask(() => {
      this.drawing.fit(asObject(source.data), this.model);
      this.go(this.time);
    });
    // The flash depends on the contact strips, which may change after the displacements.
    for (const name of ["displacements", ...SOLVERS.map((solver) => `strip_${solver}`)]) {
      modelOf(name).properties.data.change.connect(changed);
    }
    this.model.on("absolute", changed);
    this.model.on("amplitude", changed);
    watchPointer((time) => { this.held = true; this.go(time); }, () => { this.held = false; this.animate(); });
    new IntersectionObserver(([{ isIntersecting }]) => {
      this.visible = isIntersecting;
      this.animate();
    }).observe(this.element);
    listen("play", () => this.chosen(() => this.play(!this.playing)));
    listen("step", ({ value }) => this.chosen(() => {
      this.play(false);
      this.go((this.time + value * STEP + WINDOW) % WINDOW);
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
      this.go((this.time + passed * Number(this.speed.value)) % WINDOW);
    };
    requestAnimationFrame(frame);
  }

  go(time) {
    this.time = time;
    const instant = new Instant(time, this.model);
    if (!instant.ready) return;
    this.drawing.show(instant);
    this.slider.value = time;
    this.slider.setAttribute("aria-valuetext", `${time.toFixed(2)} periods`);
    this.readout.textContent = `time ${time.toFixed(3)} T`;
    this.marks.put(instant);
  }
}
