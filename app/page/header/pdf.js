// A drawing in SVG as a PDF of one page: curves stay curves, and letters letters of the fonts that every PDF reader has.

import { element } from "../shared/dom.js";
import { ruler } from "../shared/fit.js";

const PT = 72 / 96; // of a pixel
// Characters of the font Symbol by their codes there.
const SYMBOL = { "α": 97, "β": 98, "γ": 103, "δ": 100, "ε": 101, "η": 104, "κ": 107, "λ": 108, "μ": 109, "ξ": 120, "π": 112,
  "σ": 115, "τ": 116, "ω": 119, "Δ": 68, "Σ": 83, "Ω": 87, "−": 45, "′": 162, "″": 178, "≤": 163, "≥": 179, "∞": 165, "≈": 187,
  "≡": 186, "≠": 185, "√": 214, "∂": 182, "→": 174, "←": 172, "↑": 173, "↓": 175, "⋅": 215, "∫": 242 };
// Characters of Helvetica beyond Latin-1, by their codes there (WinAnsiEncoding).
const LATIN = { "–": 150, "—": 151, "‘": 145, "’": 146, "“": 147, "”": 148, "•": 149, "…": 133, "€": 128 };
const LOWERED = Object.fromEntries([..."₀₁₂₃₄₅₆₇₈₉"].map((digit, i) => [digit, String(i)]));
const RAISED = { ...Object.fromEntries([..."⁰¹²³⁴⁵⁶⁷⁸⁹"].map((digit, i) => [digit, String(i)])), "⁻": "−", "⁺": "+" };
const SMALL = 0.7; // size of a lowered or raised character

export async function pdfFile(picture, { width, height }, about) {
  const place = element("div");
  Object.assign(place.style, { position: "fixed", left: "-20000px", top: 0 });
  place.append(picture); // for its styles, and the places of its letters
  document.body.append(place);
  try {
    const file = new PdfFile();
    const page = new PdfDrawing(file, picture);
    const { viewBox } = picture;
    const scale = viewBox.baseVal?.width ? width / viewBox.baseVal.width : 1;
    const toPage = new DOMMatrix([PT * scale, 0, 0, -PT * scale, 0, PT * height]);
    page.put(`${matrixText(toPage)} cm`);
    for (const child of picture.children) await page.draw(child, new DOMMatrix(), toPage);
    return await file.finish(page, [width * PT, height * PT], about);
  } finally {
    place.remove();
  }
}

const pdfNumber = (value) => String(Math.round(value * 1e4) / 1e4);
const matrixText = ({ a, b, c, d, e, f }) => [a, b, c, d, e, f].map(pdfNumber).join(" ");
// Text outside the page, in UTF-16 with its mark.
const pdfText = (text) => `<FEFF${[...Array(text.length).keys()].map((i) => text.charCodeAt(i).toString(16).padStart(4, "0")).join("")}>`;

class PdfFile {
  constructor() {
    this.objects = []; // each an array of texts and bytes
    this.fonts = {};
    for (const [name, font] of [["F", "Helvetica"], ["B", "Helvetica-Bold"], ["S", "Symbol"]]) {
      const encoding = name === "S" ? "" : " /Encoding /WinAnsiEncoding";
      this.fonts[name] = this.add([`<< /Type /Font /Subtype /Type1 /BaseFont /${font}${encoding} >>`]);
    }
  }

  add(parts) {
    return this.objects.push(parts);
  }

  async addStream(entries, bytes) {
    const packed = new Blob([bytes]).stream().pipeThrough(new CompressionStream("deflate"));
    const content = new Uint8Array(await new Response(packed).arrayBuffer());
    return this.add([`<< ${entries} /Filter /FlateDecode /Length ${content.length} >>\nstream\n`, content, "\nendstream"]);
  }

  async finish(page, [width, height], { title, description }) {
    const content = await this.addStream("", page.content());
    const pages = this.objects.length + 2;
    const box = `[0 0 ${pdfNumber(width)} ${pdfNumber(height)}]`;
    const only = this.add([`<< /Type /Page /Parent ${pages} 0 R /MediaBox ${box} ${page.resources()} /Contents ${content} 0 R >>`]);
    this.add([`<< /Type /Pages /Kids [${only} 0 R] /Count 1 >>`]);
    const root = this.add([`<< /Type /Catalog /Pages ${pages} 0 R >>`]);
    const info = this.add([`<< /Title ${pdfText(title)} /Subject ${pdfText(description)} /Creator (Vibroscope) >>`]);
    const encoder = new TextEncoder();
    const file = [];
    let length = 0;
    const write = (...parts) => {
      for (const part of parts) {
        const bytes = typeof part === "string" ? encoder.encode(part) : part;
        file.push(bytes);
        length += bytes.length;
      }
    };
    write("%PDF-1.4\n");
    const starts = this.objects.map((parts, i) => {
      const start = length;
      write(`${i + 1} 0 obj\n`, ...parts, "\nendobj\n");
      return start;
    });
    const table = length;
    const rows = starts.map((start) => `${String(start).padStart(10, "0")} 00000 n \n`).join("");
    write(`xref\n0 ${starts.length + 1}\n0000000000 65535 f \n${rows}`);
    write(`trailer\n<< /Size ${starts.length + 1} /Root ${root} 0 R /Info ${info} 0 R >>\nstartxref\n${table}\n%%EOF\n`);
    return new Blob(file, { type: "application/pdf" });
  }
}

// What is drawn on a page, or in one tile of a pattern.
class PdfDrawing {
  constructor(file, svg) {
    this.file = file;
    this.svg = svg;
    this.lines = [];
    this.used = { ExtGState: new Map(), XObject: new Map(), Pattern: new Map() }; // number of each object, by name
  }

  put(line) {
    this.lines.push(line);
  }

  content() {
    return new TextEncoder().encode(this.lines.join("\n"));
  }

  resources() {
    const entries = Object.entries(this.used).filter(([, used]) => used.size)
      .map(([kind, used]) => `/${kind} << ${[...used].map(([name, number]) => `/${name} ${number} 0 R`).join(" ")} >>`);
    const fonts = Object.entries(this.file.fonts).map(([name, number]) => `/${name} ${number} 0 R`).join(" ");
    return `/Resources << /Font << ${fonts} >> ${entries.join(" ")} >>`;
  }

  // `outer` is the matrix from the parent to the drawing, `base` that from the drawing to the page, for patterns.
  async draw(shape, outer, base, opacity = 1) {
    if (!(shape instanceof SVGGraphicsElement) || shape instanceof SVGDefsElement) return;
    const own = shape.transform.baseVal.consolidate()?.matrix;
    const matrix = own ? outer.multiply(new DOMMatrix([own.a, own.b, own.c, own.d, own.e, own.f])) : outer;
    const style = getComputedStyle(shape);
    if (style.display === "none") return;
    const alpha = opacity * Number(style.opacity);
    const clip = this.referred(shape.getAttribute("clip-path"));
    const nested = shape instanceof SVGGElement;
    this.put("q");
    if (clip) this.clip(clip, matrix);
    if (nested) for (const child of shape.children) await this.draw(child, matrix, base, alpha);
    else {
      this.put(`${matrixText(matrix)} cm`);
      if (shape instanceof SVGTextElement) this.text(shape, style, alpha);
      else if (shape instanceof SVGImageElement) await this.image(shape);
      else await this.outline(shape, style, alpha, base.multiply(matrix));
    }
    this.put("Q");
  }

  referred(url) {
    const id = /url\(["']?#([^"')]+)/.exec(url ?? "")?.[1];
    return id ? this.svg.querySelector(`[id="${id}"]`) : null;
  }

  clip(clip, matrix) {
    const back = matrix.inverse();
    this.put(`${matrixText(matrix)} cm`);
    for (const shape of clip.children) {
      this.put(`${outlineOf(shape)} ${shape.getAttribute("clip-rule") === "evenodd" ? "W*" : "W"} n`);
    }
    this.put(`${matrixText(back)} cm`);
  }

  transparency(stroke, fill) {
    const name = `G${Math.round(stroke * 1000)}x${Math.round(fill * 1000)}`;
    const { ExtGState: used } = this.used;
    if (!used.has(name)) used.set(name, this.file.add([`<< /CA ${pdfNumber(stroke)} /ca ${pdfNumber(fill)} >>`]));
    this.put(`/${name} gs`);
  }

  async outline(shape, style, alpha, toPage) {
    const pattern = this.referred(style.fill);
    const fill = pattern ? null : colourOf(style.fill);
    const stroke = Number.parseFloat(style.strokeWidth) > 0 ? colourOf(style.stroke) : null;
    const path = outlineOf(shape);
    if (!path || !(fill || stroke || pattern)) return;
    this.transparency(alpha * Number(style.strokeOpacity) * (stroke?.[3] ?? 1), alpha * Number(style.fillOpacity) * (fill?.[3] ?? 1));
    if (fill) this.put(`${fill.slice(0, 3).map(pdfNumber).join(" ")} rg`);
    if (pattern) this.put(`/Pattern cs /${await this.pattern(pattern, toPage)} scn`);
    if (stroke) {
      const dashes = style.strokeDasharray === "none" ? "" : style.strokeDasharray.replaceAll("px", "").replaceAll(",", " ");
      const cap = ["butt", "round", "square"].indexOf(style.strokeLinecap);
      const join = ["miter", "round", "bevel"].indexOf(style.strokeLinejoin);
      const offset = Number.parseFloat(style.strokeDashoffset) || 0;
      this.put(`${stroke.slice(0, 3).map(pdfNumber).join(" ")} RG ${pdfNumber(Number.parseFloat(style.strokeWidth))} w`
        + ` ${Math.max(cap, 0)} J ${Math.max(join, 0)} j [${dashes}] ${pdfNumber(offset)} d`);
    }
    const filled = fill || pattern;
    const rule = style.fillRule === "evenodd" ? "*" : "";
    this.put(`${path} ${filled && stroke ? `B${rule}` : filled ? `f${rule}` : "S"}`);
  }

  async pattern(pattern, toPage) {
    const tile = new PdfDrawing(this.file, this.svg);
    for (const child of pattern.children) await tile.draw(child, new DOMMatrix(), toPage);
    const [wide, high] = ["width", "height"].map((name) => Number.parseFloat(pattern.getAttribute(name)));
    const entries = `/Type /Pattern /PatternType 1 /PaintType 1 /TilingType 1 /BBox [0 0 ${wide} ${high}] /XStep ${wide}`
      + ` /YStep ${high} /Matrix [${matrixText(toPage)}] ${tile.resources()}`;
    const number = await this.file.addStream(entries, tile.content());
    this.used.Pattern.set(`P${number}`, number);
    return `P${number}`;
  }

  async image(shape) {
    const image = new Image();
    image.src = shape.getAttribute("href");
    await image.decode();
    const canvas = element("canvas");
    const { naturalWidth: width, naturalHeight: height } = image;
    Object.assign(canvas, { width, height });
    const context = canvas.getContext("2d");
    context.drawImage(image, 0, 0);
    const { data } = context.getImageData(0, 0, width, height);
    const colours = new Uint8Array(width * height * 3);
    const shades = new Uint8Array(width * height);
    for (let i = 0; i < shades.length; i += 1) {
      colours.set(data.subarray(4 * i, 4 * i + 3), 3 * i);
      shades[i] = data[4 * i + 3];
    }
    const entries = `/Type /XObject /Subtype /Image /Width ${width} /Height ${height} /BitsPerComponent 8`;
    const mask = await this.file.addStream(`${entries} /ColorSpace /DeviceGray`, shades);
    const number = await this.file.addStream(`${entries} /ColorSpace /DeviceRGB /SMask ${mask} 0 R`, colours);
    this.used.XObject.set(`I${number}`, number);
    const [wide, high] = ["width", "height"].map((name) => Number(shape.getAttribute(name) ?? { width, height }[name]));
    this.transparency(1, Number(shape.getAttribute("opacity") ?? 1));
    this.put(`${wide} 0 0 ${-high} ${Number(shape.getAttribute("x") ?? 0)} ${Number(shape.getAttribute("y") ?? 0) + high} cm /I${number} Do`);
  }

  text(shape, style, alpha) {
    const colour = colourOf(style.fill);
    const size = Number.parseFloat(style.fontSize);
    if (!colour || !shape.getNumberOfChars()) return;
    ruler.font = `${style.fontWeight} ${size}px ${style.fontFamily}`;
    const baseline = shape.getBBox().y + ruler.measureText("x").fontBoundingBoxAscent;
    this.transparency(1, alpha * Number(style.fillOpacity) * colour[3]);
    this.put(`BT ${colour.slice(0, 3).map(pdfNumber).join(" ")} rg`);
    for (const { font, at, codes, lift, scale } of runsOf(shape.textContent, Number(style.fontWeight) > 500)) {
      const { x } = shape.getStartPositionOfChar(at);
      const letters = codes.map((code) => code.toString(16).padStart(2, "0")).join("");
      this.put(`/${font} ${pdfNumber(size * scale)} Tf 1 0 0 -1 ${pdfNumber(x)} ${pdfNumber(baseline - lift * size)} Tm <${letters}> Tj`);
    }
    this.put("ET");
  }
}

// Letters of one font each, in their order; `at` is the place of the first one in the text.
function runsOf(text, bold) {
  const runs = [];
  for (let at = 0; at < text.length; at += 1) {
    const shown = text[at];
    const letter = LOWERED[shown] ?? RAISED[shown] ?? shown;
    const lift = LOWERED[shown] ? -0.15 : RAISED[shown] ? 0.33 : 0;
    const scale = lift ? SMALL : 1;
    const code = SYMBOL[letter] ?? LATIN[letter] ?? letter.charCodeAt(0);
    if (!(letter in SYMBOL) && !(letter in LATIN) && code > 255) throw new Error(`a PDF has no letter “${letter}”: take SVG`);
    const font = letter in SYMBOL ? "S" : bold ? "B" : "F";
    const last = runs.at(-1);
    if (last && last.font === font && last.lift === lift) last.codes.push(code);
    else runs.push({ font, at, codes: [code], lift, scale });
  }
  return runs;
}

// Red, green, blue from 0 to 1 and opacity of a computed colour; null if nothing is painted.
function colourOf(text) {
  const numbers = /^rgba?\(([^)]+)\)$/.exec(text)?.[1].split(/[\s,/]+/).map(Number.parseFloat);
  return numbers ? [...numbers.slice(0, 3).map((value) => value / 255), numbers[3] ?? 1] : null;
}

// ---- outlines ----

const pointText = (...numbers) => numbers.map(pdfNumber).join(" ");

function outlineOf(shape) {
  const of = (name) => shape[name].baseVal.value;
  const points = (list) => [...list].map(({ x, y }, i) => `${pointText(x, y)} ${i ? "l" : "m"}`).join(" ");
  switch (shape.tagName) {
    case "path": return pathOutline(shape.getAttribute("d") ?? ""); // a curve without points
    case "rect": return `${pointText(of("x"), of("y"), of("width"), of("height"))} re`;
    case "line": return `${pointText(of("x1"), of("y1"))} m ${pointText(of("x2"), of("y2"))} l`;
    case "polyline": return points(shape.points);
    case "polygon": return `${points(shape.points)} h`;
    case "circle": return pathOutline(circlePath(of("cx"), of("cy"), of("r"), of("r")));
    case "ellipse": return pathOutline(circlePath(of("cx"), of("cy"), of("rx"), of("ry")));
    default: throw new Error(`a PDF of <${shape.tagName}> is not foreseen: take SVG`);
  }
}

const circlePath = (x, y, rx, ry) => `M ${x - rx} ${y} A ${rx} ${ry} 0 0 1 ${x + rx} ${y} A ${rx} ${ry} 0 0 1 ${x - rx} ${y} Z`;

function pathOutline(description) {
  const drawn = [];
  let [x, y] = [0, 0];
  for (const [, given, rest] of description.matchAll(/([a-zA-Z])([^a-zA-Z]*(?:e[-+]?\d+[^a-zA-Z]*)*)/g)) {
    const numbers = (rest.match(/[-+]?(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?/gi) ?? []).map(Number);
    const relative = given !== given.toUpperCase();
    const letter = given.toUpperCase();
    const each = { M: 2, L: 2, H: 1, V: 1, Q: 4, C: 6, A: 7, Z: 0 }[letter];
    if (each === undefined) throw new Error(`a PDF of the path “${letter}” is not foreseen: take SVG`);
    if (letter === "Z") drawn.push("h");
    for (let i = 0; i + each <= numbers.length && each; i += each) {
      const part = numbers.slice(i, i + each).map((value, k) => value + (relative ? originOf(letter, k, each, x, y) : 0));
      const [endX, endY] = letter === "H" ? [part[0], y] : letter === "V" ? [x, part[0]] : part.slice(-2);
      if ("MLHV".includes(letter)) drawn.push(`${pointText(endX, endY)} ${letter === "M" && !i ? "m" : "l"}`);
      if (letter === "C") drawn.push(`${pointText(...part)} c`);
      if (letter === "Q") {
        const [qx, qy] = part;
        drawn.push(`${pointText((x + 2 * qx) / 3, (y + 2 * qy) / 3, (endX + 2 * qx) / 3, (endY + 2 * qy) / 3, endX, endY)} c`);
      }
      if (letter === "A") drawn.push(...arcOutline([x, y], part));
      [x, y] = [endX, endY];
    }
  }
  return drawn.join(" ");
}

// What the k-th number of a relative command is counted from: of an arc, radii, angle and flags are not relative.
function originOf(letter, k, each, x, y) {
  if (letter === "V") return y;
  if (letter === "A" && k < each - 2) return 0;
  return (each - k) % 2 === 0 || letter === "H" ? x : y;
}

// An elliptical arc as Bézier curves of at most a quarter each; the radii suffice, as they do in drawings of a browser.
function arcOutline([x0, y0], [rx, ry, degrees, large, sweep, x1, y1]) {
  const turn = new DOMMatrix().rotate(degrees);
  const toCircle = turn.scale(rx, ry).inverse();
  const [from, to] = [[x0, y0], [x1, y1]].map(([x, y]) => toCircle.transformPoint({ x, y }));
  const [dx, dy] = [to.x - from.x, to.y - from.y];
  const square = dx * dx + dy * dy;
  if (!square) return [];
  const away = Math.sqrt(Math.max(1 / square - 0.25, 0)) * (large === sweep ? -1 : 1);
  const centre = { x: (from.x + to.x) / 2 - away * dy, y: (from.y + to.y) / 2 + away * dx };
  const start = Math.atan2(from.y - centre.y, from.x - centre.x);
  let angle = Math.atan2(to.y - centre.y, to.x - centre.x) - start;
  if (sweep && angle < 0) angle += 2 * Math.PI;
  if (!sweep && angle > 0) angle -= 2 * Math.PI;
  const count = Math.ceil(Math.abs(angle) / (Math.PI / 2) - 1e-9) || 1;
  const reach = (4 / 3) * Math.tan(angle / count / 4);
  const back = toCircle.inverse();
  const place = (x, y) => { const point = back.transformPoint({ x: centre.x + x, y: centre.y + y }); return [point.x, point.y]; };
  return [...Array(count).keys()].map((i) => {
    const [a, b] = [start + (angle * i) / count, start + (angle * (i + 1)) / count];
    return `${pointText(
      ...place(Math.cos(a) - reach * Math.sin(a), Math.sin(a) + reach * Math.cos(a)),
      ...place(Math.cos(b) + reach * Math.sin(b), Math.sin(b) - reach * Math.cos(b)),
      ...place(Math.cos(b), Math.sin(b)),
    )} c`;
  });
}
