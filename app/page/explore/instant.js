// The present instant of the periods that are shown, marked in every figure. The server is not involved.

import { columnsOf, element, viewOf } from "../shared/dom.js";

export const TIME_FIGURES = ["displacement", "strip", "force"];
export const MARKED = [...TIME_FIGURES, "phase1", "phase2"];
export const SOLVERS = ["reference", "penalty"];

// The states at one instant, interpolated from the columns of the displacement figure.
export class Instant {
  constructor(time, { absolute, amplitude, system, window }) {
    this.time = time;
    this.columns = columnsOf("displacements");
    const count = this.columns.t?.length ?? 0;
    const at = Math.min(Math.max(time / window, 0), 1) * (count - 1);
    this.index = Math.min(Math.floor(at), count - 2);
    this.share = at - this.index;
    this.period = periodOf(this.columns, window);
    this.base = amplitude * system.base * Math.cos(2 * Math.PI * time + system.phase);
    this.shift = absolute ? this.base : 0;
    this.ready = count > 1;
  }

  read(column) {
    const values = this.columns[column];
    if (!values || !this.ready) return NaN;
    return values[this.index] * (1 - this.share) + values[this.index + 1] * this.share;
  }

  // Displacement relative to the base, and velocity.
  state(solver, body) {
    return [this.read(`${solver}${body}`) - this.shift, this.read(`${solver}_v${body}`)];
  }

  // `age`: periods since the last contact began, Infinity if there was none; `lasts`: whether there is contact now.
  contact(solver) {
    const { left = [], right = [] } = columnsOf(`strip_${solver}`);
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

// Length of an excitation period on the time axes: 1 where time is counted in periods.
const periodOf = ({ t = [] }, window) => (t.length ? t[t.length - 1] / window : 1);

// An element over a figure, at a position in its data; it moves without a repaint of the figure.
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
    this.element.style.display = bbox.contains(sx, sy) ? "" : "none"; // false for NaN, too
    this.element.style.transform = `translate(${sx}px, ${sy}px)${this.turned}`;
  }
}

// A vertical line at the instant.
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

// The state of one body in a phase plot, with the shape of the marks of the section.
class StateMark extends Mark {
  constructor(solver, body) {
    const [size, round] = solver === "reference" ? [11, "50%"] : [9, 0];
    super(`phase${body}`, `${solver}${body}`, {
      boxSizing: "border-box", width: `${size}px`, height: `${size}px`, margin: `${-size / 2}px`,
      border: "1.2px solid var(--ink)", borderRadius: round, background: `var(--${solver})`,
    });
    this.turned = round ? "" : " rotate(45deg)";
  }

  across({ y_scale }) {
    return y_scale.compute(this.y);
  }
}

// All marks of the instant.
export class Marks {
  constructor() {
    this.lines = TIME_FIGURES.map((figure) => new NowLine(figure));
    this.states = SOLVERS.flatMap((solver) => [1, 2].map((body) => [solver, body]))
      .map(([solver, body]) => ({ solver, body, mark: new StateMark(solver, body) }));
  }

  put(instant) {
    for (const line of this.lines) line.put(instant.time * instant.period, 0);
    for (const { solver, body, mark } of this.states) mark.put(...instant.state(solver, body));
  }
}

// `window`: how many periods are shown. Calls `onTime(time)` when the pointer is over a time figure, and `onLeave()` when it leaves.
export function watchPointer(window, onTime, onLeave) {
  for (const name of TIME_FIGURES) {
    const view = viewOf(name);
    if (!view) continue;
    const pointed = (event) => {
      const canvas = view.canvas_view.el.getBoundingClientRect();
      const sx = event.clientX - canvas.left;
      const sy = event.clientY - canvas.top;
      if (!view.frame.bbox.contains(sx, sy)) return;
      const time = view.frame.x_scale.invert(sx) / periodOf(columnsOf("displacements"), window());
      if (time >= 0 && time <= window()) onTime(time);
    };
    // Browsers hold a move back until they begin a frame; what is done ahead of it does not delay that frame. They offer
    // this on secure pages only, and as often as the mouse reports: the first of a frame counts here.
    let ahead = null; // the place that was shown ahead of its frame
    const early = (event) => {
      if (ahead) return;
      ahead = [event.clientX, event.clientY];
      requestAnimationFrame(() => { ahead = null; });
      pointed(event);
    };
    const moved = (event) => {
      if (ahead?.[0] !== event.clientX || ahead[1] !== event.clientY) pointed(event);
    };
    view.el.addEventListener("pointerrawupdate", early);
    view.el.addEventListener("pointermove", moved);
    view.el.addEventListener("pointerdown", pointed); // a tap sends no move
    view.el.addEventListener("pointerleave", onLeave);
  }
}
