// The present phase: one instant of the last two periods, marked in every figure. It is moved by playing, by the slider
// below the pendulums, and by the pointer over any figure over time. Nothing of it goes to the server.

const WINDOW = 2; // periods, as in present.py
const TIME_FIGURES = ["displacement", "strip", "force"];
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

function mark(instant) {
  for (const name of TIME_FIGURES) modelOf(`now_${name}`)?.setv({ location: instant.time * instant.period }, HERE);
  for (const solver of SOLVERS) {
    for (const pendulum of [1, 2]) {
      const [x, v] = instant.state(solver, pendulum);
      const data = Number.isFinite(x) ? { x: [x], v: [v] } : { x: [], v: [] };
      modelOf(`mark_${solver}${pendulum}`)?.setv({ data }, HERE);
    }
  }
}

// Call `at(time)` while the pointer rests on a figure over time, and `gone()` when it leaves.
function watchPointer(at, gone) {
  for (const name of TIME_FIGURES) {
    const view = viewOf(name);
    if (!view) continue;
    view.el.addEventListener("pointermove", (event) => {
      const canvas = view.canvas_view.el.getBoundingClientRect();
      const sx = event.clientX - canvas.left;
      const sy = event.clientY - canvas.top;
      if (!view.frame.bbox.contains(sx, sy)) return;
      const source = modelOf("displacements");
      const time = view.frame.x_scale.invert(sx) / periodOf(source ? asObject(source.data) : {});
      if (time >= 0 && time <= WINDOW) at(time);
    });
    view.el.addEventListener("pointerleave", gone);
  }
}
