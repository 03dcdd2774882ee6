// The present phase: one instant of the last two periods, marked in every figure. It is moved by playing, by the slider
// below the pendulums, and by the pointer over any figure over time. Nothing of it goes to the server.

const WINDOW = 2; // periods, as in present.py
const TIME_FIGURES = ["displacement", "strip", "force"];
const MARKED = [...TIME_FIGURES, "phase1", "phase2"];
const SOLVERS = ["reference", "penalty"];

// Everything the page knows about one instant, from the columns of the displacement figure.
class Instant {
  constructor(time, { absolute, amplitude }) {
    this.time = time;
    const source = modelOf("displacements");
    this.columns = source ? asObject(source.data) : {};
    const count = this.columns.t?.length ?? 0;
    const at = Math.min(Math.max(time / WINDOW, 0), 1) * (count - 1);
    this.index = Math.min(Math.floor(at), count - 2);
    this.share = at - this.index;
    this.period = periodOf(this.columns);
    this.base = amplitude * Math.cos(2 * Math.PI * time);
    this.shift = absolute ? this.base : 0;
    this.ready = count > 1;
  }

  read(column) {
    const values = this.columns[column];
    if (!values || !this.ready) return NaN;
    return values[this.index] * (1 - this.share) + values[this.index + 1] * this.share;
  }

  // Displacement relative to the base, and velocity.
  state(solver, pendulum) {
    return [this.read(`${solver}${pendulum}`) - this.shift, this.read(`${solver}_v${pendulum}`)];
  }

  // Periods since contact was last begun, and whether it lasts; Infinity where there was none.
  contact(solver) {
    const source = modelOf(`strip_${solver}`);
    const { left = [], right = [] } = source ? asObject(source.data) : {};
    let age = Infinity;
    let lasts = false;
    for (let i = 0; i < left.length; i++) {
      const begun = left[i] / this.period;
      if (begun > this.time) continue;
      age = Math.min(age, this.time - begun);
      lasts = lasts || this.time <= right[i] / this.period;
    }
    return { age, lasts };
  }
}

// Of the excitation, on the axes of time: 1 where time is counted in periods.
const periodOf = ({ t = [] }) => (t.length ? t[t.length - 1] / WINDOW : 1);

// An element over a figure at a place in its data: it moves without a repaint of anything below it.
class Mark {
  constructor(figure, name, look) {
    this.view = viewOf(figure);
    this.element = element("div");
    this.element.dataset.mark = name;
    Object.assign(this.element.style, { position: "absolute", left: 0, top: 0, pointerEvents: "none" }, look);
    this.view.canvas_view.overlays_el.append(this.element);
    const { x_range, y_range, properties } = this.view.model;
    const moved = [x_range.properties.start, x_range.properties.end, y_range.properties.start, y_range.properties.end];
    for (const property of [...moved, properties.inner_width, properties.inner_height]) {
      property.change.connect(() => this.draw());
    }
  }

  put(x, y) {
    Object.assign(this.element.dataset, { x, y });
    [this.x, this.y] = [x, y];
    this.draw();
  }

  draw() {
    const { bbox, x_scale } = this.view.frame;
    const [sx, sy] = [x_scale.compute(this.x), this.across(this.view.frame)];
    this.element.style.display = bbox.contains(sx, sy) ? "" : "none"; // what is no number lies nowhere
    this.element.style.transform = `translate(${sx}px, ${sy}px)${this.turned}`;
  }
}

// A line across the frame.
class NowLine extends Mark {
  turned = "";

  constructor(figure) {
    super(figure, `now-${figure}`, { borderLeft: "1px dotted var(--ink)" });
  }

  across({ bbox }) {
    this.element.style.height = `${bbox.height}px`;
    return bbox.top;
  }
}

// A point of a solution, shaped as its section is.
class StateMark extends Mark {
  constructor(solver, pendulum) {
    const [size, round] = solver === "reference" ? [11, "50%"] : [9, 0];
    super(`phase${pendulum}`, `${solver}${pendulum}`, {
      boxSizing: "border-box", width: `${size}px`, height: `${size}px`, margin: `${-size / 2}px`,
      border: "1.2px solid var(--ink)", borderRadius: round, background: `var(--${solver})`,
    });
    this.turned = round ? "" : " rotate(45deg)";
  }

  across({ y_scale }) {
    return y_scale.compute(this.y);
  }
}

// All marks of an instant.
class Marks {
  constructor() {
    this.lines = TIME_FIGURES.map((figure) => new NowLine(figure));
    this.states = SOLVERS.flatMap((solver) => [1, 2].map((pendulum) => [solver, pendulum]))
      .map(([solver, pendulum]) => ({ solver, pendulum, mark: new StateMark(solver, pendulum) }));
  }

  put(instant) {
    for (const line of this.lines) line.put(instant.time * instant.period, 0);
    for (const { solver, pendulum, mark } of this.states) mark.put(...instant.state(solver, pendulum));
  }
}

// The figures over time keep one margin, the widest that any of them has come to need: their axes of time then stand
// above each other, whatever the ticks say, and stay where they are when those become shorter.
function alignTimes() {
  const views = TIME_FIGURES.map(viewOf);
  const fit = () => {
    const min_border_left = Math.ceil(Math.max(...views.map(({ frame }) => frame.bbox.left)));
    const right = ({ frame, bbox }) => bbox.width - frame.bbox.right;
    const min_border_right = Math.ceil(Math.max(...views.map(right)));
    for (const { model } of views) model.setv({ min_border_left, min_border_right }, HERE);
  };
  for (const { model } of views) model.properties.inner_width.change.connect(fit);
  fit();
}

// Call `at(time)` while the pointer rests on a figure over time, and `gone()` when it leaves.
function watchPointer(at, gone) {
  for (const name of TIME_FIGURES) {
    const view = viewOf(name);
    if (!view) continue;
    const pointed = (event) => {
      const canvas = view.canvas_view.el.getBoundingClientRect();
      const sx = event.clientX - canvas.left;
      const sy = event.clientY - canvas.top;
      if (!view.frame.bbox.contains(sx, sy)) return;
      const source = modelOf("displacements");
      const time = view.frame.x_scale.invert(sx) / periodOf(source ? asObject(source.data) : {});
      if (time >= 0 && time <= WINDOW) at(time);
    };
    for (const type of ["pointerdown", "pointermove"]) view.el.addEventListener(type, pointed); // a tap does not move
    view.el.addEventListener("pointerleave", gone);
  }
}
