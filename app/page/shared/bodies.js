// The drawing of the system to scale, each solution as shapes of its own: at rest in the panel System, moving on Explore.
// Files draw what it draws: see `outlines`.

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

// Draws lines, each a list of points.
function trace(path, lines) {
  path.lines = lines;
  put(path, { d: lines.map((points) => `M${points.map(([x, y]) => `${x.toFixed(2)} ${y.toFixed(2)}`).join(" L")}`).join(" ") });
}

// A spring between two points of one height.
function spring(from, to, y) {
  const [begin, last] = [from + 5, to - 5];
  const coil = (_, i) => [begin + ((last - begin) * i) / (2 * COILS), y + [0, -6, 0, 6][i % 4]];
  return [[[from, y], ...Array.from({ length: 2 * COILS + 1 }, coil), [to, y]]];
}

function hatch(x, top, bottom, out) {
  const lines = [[[x, top], [x, bottom]]];
  for (let y = top + 6; y <= bottom; y += 9) lines.push([[x, y], [x + out * 7, y - 7]]);
  return lines;
}

// The numbers of a shape: points of its lines or corners, or the middle and the radius of a circle.
function outline(shape, shift) {
  const [x, y, width, height] = ["x", "y", "width", "height"].map((name) => Number(shape.getAttribute(name)));
  const corners = [[x, y], [x + width, y], [x + width, y + height], [x, y + height]];
  if (shape.tagName !== "circle") return (shape.lines ?? [corners]).map((points) => points.flatMap(([x, y]) => [x + shift, y]));
  const [cx, cy, r] = ["cx", "cy", "r"].map((name) => Number(shape.getAttribute(name)));
  return [[cx + shift, cy, r]];
}

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
    this.rail = svgElement("path", { class: "rail" });
    this.element.append(this.rail, this.base);
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
    const [edge, y] = hung ? [10, PIVOT - 20] : [4, FLOOR + 14];
    trace(this.rail, [[[edge, y], [WIDE - edge, y]]]);
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
      svgElement("rect", { class: "plate", x: MIDDLE - plate, y: PIVOT - 16, width: 2 * plate, height: 10, rx: 2 }),
      ...[-out, out].map((x) => svgElement("circle", { class: "pivot", cx: MIDDLE + x, cy: PIVOT, r: 3.5 })),
    ];
  }

  // The floor, and on it what the springs are fixed to, or the wall.
  posts() {
    const { left, right } = this.place;
    const posts = [left, right].map((x, i) => {
      const post = svgElement("path", { class: "post" });
      trace(post, hatch(x, FLOOR - 56, FLOOR, i ? 1 : -1));
      return post;
    });
    return [svgElement("rect", { class: "plate", x: left - POST, y: FLOOR, width: right - left + 2 * POST, height: 6, rx: 1 }), ...posts];
  }

  // `base`: where the base is; `states`: ξ₁ and ξ₂ of each solution, relative to the base; `contact`: age and lasting.
  show(base, states, contact = () => null) {
    const shift = base * this.scale;
    this.shift = shift;
    put(this.base, { transform: `translate(${shift} 0)` });
    for (const [solver, bodies] of Object.entries(this.bodies)) {
      const places = states[solver].map((x, i) => (x - this.rest[i]) * this.scale);
      bodies.show(places, shift, this.place, contact(solver));
    }
  }

  // What is drawn now, for a file: whose and what each shape is, with its numbers in px, after the part that is seen, as
  // "view_0_0_260_190*base.plate_60_10_200_10_200_20_60_20*penalty.bob_99.5_162_15". The letters need no escape in a query.
  outlines() {
    const shapes = [["base", [this.rail], 0], ["base", [...this.base.children], this.shift]];
    for (const [solver, { element, rods, stop, bobs }] of Object.entries(this.bodies)) {
      if (element.style.display !== "none") shapes.push([solver, [...rods, stop, ...bobs], 0]);
    }
    const written = shapes.flatMap(([owner, each, shift]) => each.filter(({ style }) => style.display !== "none").flatMap((shape) =>
      outline(shape, shift).map((numbers) => [`${owner}.${shape.classList[0]}`, ...numbers.map((x) => Number(x.toFixed(1)))].join("_"))));
    return [`view_${this.element.getAttribute("viewBox").replaceAll(" ", "_")}`, ...written].join("*");
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

  set({ kind, mass, springs }) {
    this.kind = kind;
    const count = kind === "wall" ? 1 : 2;
    const hung = kind === "pendulums";
    this.sides = [mass < 1 ? 1 : 1 / mass, mass < 1 ? mass : 1].map((each) => clamp(SIDES[1] * Math.cbrt(each), ...SIDES));
    const make = (tag, name) => Array.from({ length: count }, () => svgElement(tag, { class: name }));
    this.rods = make("path", hung ? "rod" : "rod spring");
    this.rods.forEach((rod, i) => { rod.style.display = springs[i] ? "" : "none"; });
    this.bobs = make(hung ? "circle" : "rect", "bob");
    for (const bob of this.bobs) if (hung) put(bob, { r: BOB });
    this.names = make("text", "name");
    this.names.forEach((name, i) => { name.textContent = this.solver === "penalty" ? "" : String(i + 1); });
    this.element.replaceChildren(...this.rods, this.stop, this.flash, ...this.bobs, ...this.names);
    this.element.style.display = "none"; // until there is a motion to show
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
  touch(right, left, play, side, lines) {
    const stop = left - play - side;
    trace(this.stop, play < Infinity ? lines(stop) : []);
    return left - right > play / 2 ? stop : (right + left) / 2;
  }

  hang(displacements, shift, { half, play }) {
    const places = displacements.map((out, i) => {
      const pivot = MIDDLE + shift + (i ? half + BOB : -half - BOB);
      return { pivot, x: pivot + out, y: PIVOT + Math.sqrt(Math.max(ROD ** 2 - out ** 2, 0)) };
    });
    places.forEach(({ pivot, x, y }, i) => {
      trace(this.rods[i], [[[pivot, PIVOT], [x, y]]]);
      put(this.bobs[i], { cx: x, cy: y });
      put(this.names[i], { x, y: y + 4 });
    });
    const [one, two] = places;
    const top = two.y - BOB;
    const hook = (x) => [[[two.x, top], [two.x, top - 7], [x, top - 7], [x, one.y + BOB]]];
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
      trace(this.rods[i], spring(...ends, FLOOR - SIDES[0] / 2));
    });
    const [top, end] = [FLOOR - SIDES[1] - 6, FLOOR - 14]; // above the spring
    const from = faces[1] + this.sides[1] / 2;
    const hook = (x) => [[[from, FLOOR - this.sides[1]], [from, top], [x, top], [x, end]]];
    const stop = (x) => (this.bobs[1] ? hook(x) : hatch(x, FLOOR - 56, end, -1));
    return { x: this.touch(...faces, play, this.sides[0], stop), y: FLOOR - SIDES[0] / 2 };
  }
}
