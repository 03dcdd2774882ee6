// The drawing of the system to scale, each solution as shapes of its own: at rest in the panel System, moving on Explore.

import { element, svgElement } from "./dom.js";

export const WIDE = 260;
export const HIGH = 190;
export const MIDDLE = WIDE / 2;
const PIVOT = 26; // height of the pivots from the top
const ROD = 136;
const BOB = 15; // radius
const LOW = 46; // upper edge of the drawing where nothing hangs
export const FLOOR = 132; // height of the floor that bodies slide on, from the top
const POST = 6; // width of a post that a spring is fixed to
export const SIDES = [22, 44]; // smallest and largest side of a body
// Pixels of the largest displacement, half the clearance, or the play of two stops, and the base.
const REACH = { pendulums: 92, two: 46, wall: 60 };
const COILS = 6;
const EDGE = 10; // pixels left free at both sides
const WALL = 14; // width of a wall
const FLASH = 0.03; // decay time of the flash of an impact, in periods

const put = (shape, attributes) => {
  for (const [name, value] of Object.entries(attributes)) shape.setAttribute(name, value);
};
export const clamp = (value, low, high) => Math.min(Math.max(value, low), high);

// A spring between two points of one height.
function spring(from, to, y) {
  const end = 5;
  const [begin, last] = [from + end, to - end];
  const points = [];
  for (let i = 0; i <= 2 * COILS; i++) {
    const x = begin + ((last - begin) * i) / (2 * COILS);
    points.push(`${x.toFixed(2)} ${y + (i % 2 ? (i % 4 === 1 ? -6 : 6) : 0)}`);
  }
  return `M${from} ${y} L${points.join(" L")} L${to} ${y}`;
}

const hatch = (x, top, bottom, out) => {
  let path = `M${x} ${top} V${bottom}`;
  for (let y = top + 6; y <= bottom; y += 9) path += ` M${x} ${y} l${out * 7} -7`;
  return path;
};

const playOf = ({ clearance, clearance2 }) => (clearance2 === null ? Infinity : clearance + clearance2);

// Where the bodies rest: of an overlap of the relaxed springs at either stop, each takes up its share.
function restPlaces({ kind, clearance, clearance2, separate: [one, two], share }) {
  const gap = clearance + two - one;
  const held = clamp(gap, 0, playOf({ clearance, clearance2 }));
  if (gap === held) return [one, two];
  const first = kind === "wall" ? clearance - held : one + share * (gap - held);
  return [first, kind === "wall" ? 0 : first - clearance + held];
}

export class SystemDrawing {
  constructor(solvers) {
    this.element = svgElement("svg", { viewBox: `0 0 ${WIDE} ${HIGH}`, role: "img" });
    this.base = svgElement("g", { class: "base" });
    this.element.append(svgElement("path", { class: "rail" }), this.base);
    this.bodies = Object.fromEntries(solvers.map((solver) => [solver, new Bodies(solver)]));
    this.element.append(...Object.values(this.bodies).map(({ element }) => element));
    this.scale = 1;
    this.below = 0; // more height below what hangs
  }

  // `system` as `app.explorer.drawing` gives it, lengths in units of their own.
  set(system) {
    this.system = system;
    this.rest = restPlaces(system);
    this.gap = system.clearance + this.rest[1] - this.rest[0]; // at rest
    const hung = system.kind === "pendulums";
    put(this.element, { viewBox: `0 ${hung ? 0 : LOW} ${WIDE} ${hung ? HIGH + this.below : HIGH - LOW}` });
    put(this.element.firstChild, { d: hung ? `M10 ${PIVOT - 20} H${WIDE - 10}` : `M4 ${FLOOR + 14} H${WIDE - 4}` });
    this.base.replaceChildren();
    for (const bodies of Object.values(this.bodies)) bodies.set(system);
  }

  // Fits the scale to the largest displacement from rest, so that it does not change from instant to instant.
  fit(largest) {
    const { kind, base } = this.system;
    const play = playOf(this.system);
    this.scale = REACH[kind] / (largest + (play < Infinity ? play : this.gap / 2) + Math.abs(base) || 1);
    const room = Math.abs(base) * this.scale + EDGE;
    this.place = { half: (this.gap * this.scale) / 2, play: play * this.scale, left: room, right: WIDE - room - (kind === "wall" ? WALL : 0) };
    this.base.replaceChildren(...(kind === "pendulums" ? this.pivots() : this.posts()));
  }

  pivots() {
    const out = this.place.half + BOB;
    const plate = Math.max(70, out + 12);
    return [
      svgElement("rect", { x: MIDDLE - plate, y: PIVOT - 16, width: 2 * plate, height: 10, rx: 2 }),
      ...[-out, out].map((x) => svgElement("circle", { cx: MIDDLE + x, cy: PIVOT, r: 3.5 })),
    ];
  }

  // The floor, and on it what the springs are fixed to, or the wall.
  posts() {
    const { left, right } = this.place;
    return [
      svgElement("rect", { x: left - POST, y: FLOOR, width: right - left + 2 * POST, height: 6, rx: 1 }),
      svgElement("path", { class: "post", d: hatch(left, FLOOR - 56, FLOOR, -1) }),
      svgElement("path", { class: "post", d: hatch(right, FLOOR - 56, FLOOR, 1) }),
    ];
  }

  // `base`: where the base is; `states`: ξ₁ and ξ₂ of each solution, relative to the base; `contact`: age and lasting.
  show(base, states, contact = () => null) {
    const shift = base * this.scale;
    put(this.base, { transform: `translate(${shift} 0)` });
    for (const [solver, bodies] of Object.entries(this.bodies)) {
      const places = states[solver].map((x, i) => (x - this.rest[i]) * this.scale);
      bodies.show(places, shift, this.place, contact(solver));
    }
  }
}

// The bodies of one solution, and the flash at their contact.
class Bodies {
  constructor(solver) {
    this.solver = solver;
    this.element = svgElement("g", { class: solver });
    this.flash = svgElement("circle", { class: "flash" });
    this.stop = svgElement("path", { class: "stop" }); // the second one, which body 2 or the wall carries around body 1
  }

  set({ kind, mass, share }) {
    this.kind = kind;
    const count = kind === "wall" ? 1 : 2;
    const hung = kind === "pendulums";
    this.sides = [mass < 1 ? 1 : 1 / mass, mass < 1 ? mass : 1].map((each) => clamp(SIDES[1] * Math.cbrt(each), ...SIDES));
    const make = (tag, name) => Array.from({ length: count }, () => svgElement(tag, { class: name }));
    this.rods = make(hung ? "line" : "path", hung ? "rod" : "rod spring");
    this.rods[0].style.display = share ? "" : "none"; // a body without a spring
    this.bobs = make(hung ? "circle" : "rect", "bob");
    for (const bob of this.bobs) if (hung) put(bob, { r: BOB });
    this.names = make("text", "name");
    this.names.forEach((name, i) => { name.textContent = this.solver === "penalty" ? "" : String(i + 1); });
    this.element.replaceChildren(...this.rods, this.stop, this.flash, ...this.bobs, ...this.names);
  }

  show(displacements, shift, place, contact) {
    const shown = displacements.slice(0, this.bobs.length).every(Number.isFinite);
    this.element.style.display = shown ? "" : "none";
    if (!shown) return;
    const touch = this.kind === "pendulums" ? this.hang(displacements, shift, place) : this.slide(displacements, shift, place);
    const { age, lasts } = contact ?? { age: Infinity, lasts: false };
    const brightness = Math.max(Math.exp(-age / FLASH), lasts ? 0.45 : 0);
    put(this.flash, { cx: touch.x, cy: touch.y, r: 8 + 14 * brightness, opacity: brightness });
  }

  // Draws the second stop so far left of the right face of body 1 as there is play; returns where the bodies touch.
  touch(right, left, play, side, path) {
    const stop = left - play - side;
    put(this.stop, { d: play < Infinity ? path(stop) : "" });
    return left - right > play / 2 ? stop : (right + left) / 2;
  }

  hang(displacements, shift, { half, play }) {
    const places = displacements.map((out, i) => {
      const pivot = MIDDLE + shift + (i ? half + BOB : -half - BOB);
      return { pivot, x: pivot + out, y: PIVOT + Math.sqrt(Math.max(ROD ** 2 - out ** 2, 0)) };
    });
    places.forEach(({ pivot, x, y }, i) => {
      put(this.rods[i], { x1: pivot, y1: PIVOT, x2: x, y2: y });
      put(this.bobs[i], { cx: x, cy: y });
      put(this.names[i], { x, y: y + 4 });
    });
    const [one, two] = places;
    const hook = (x) => `M${two.x} ${two.y - BOB} v-7 H${x} V${one.y + BOB}`;
    return { x: this.touch(one.x + BOB, two.x - BOB, play, 2 * BOB, hook), y: (one.y + two.y) / 2 };
  }

  // Body 1 ends where its right face is; body 2, or the wall, begins at its left face.
  slide(displacements, shift, { half, play, left, right }) {
    const middle = (this.kind === "wall" ? right - half : MIDDLE) + shift;
    const faces = [middle - half + displacements[0], middle + half + (this.kind === "wall" ? 0 : displacements[1])];
    this.bobs.forEach((bob, i) => {
      const side = this.sides[i];
      const x = i ? faces[1] : faces[0] - side;
      put(bob, { x, y: FLOOR - side, width: side, height: side, rx: 3 });
      put(this.names[i], { x: x + side / 2, y: FLOOR - side / 2 + 4 });
      const ends = i ? [x + side, right + shift] : [left + shift, x];
      put(this.rods[i], { d: spring(...ends, FLOOR - SIDES[0] / 2) });
    });
    const [top, end] = [FLOOR - SIDES[1] - 6, FLOOR - 14]; // above the spring
    const second = this.bobs[1] ? `M${faces[1] + this.sides[1] / 2} ${FLOOR - this.sides[1]} V${top} H` : "";
    const stop = (x) => (second ? `${second}${x} V${end}` : hatch(x, FLOOR - 56, end, -1));
    return { x: this.touch(...faces, play, this.sides[0], stop), y: FLOOR - SIDES[0] / 2 };
  }
}
