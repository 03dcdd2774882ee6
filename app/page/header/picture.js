// Pictures of the figures as SVG, the form from which the files of each kind are made. A figure of Bokeh is drawn again
// at the wanted size, with letters of the size that they have on the page. A drawing of the page has one shape only; the
// properties that style sheets give are written into it, so that it looks the same without them.

import { pdfFile } from "./pdf.js";
import { element, inPage, modelOf, svgElement, viewOf } from "../shared/dom.js";
import { fitFigure, wholeText, widthOf } from "../shared/fit.js";

const STYLE_PROPERTIES = ["fill", "stroke", "stroke-width", "stroke-dasharray", "opacity", "font-size", "font-weight", "text-anchor"];
const DRAWN = ":not(title)";
const PICTURE_FONT = "Helvetica, Arial, 'Liberation Sans', sans-serif"; // as wide as the letters of every PDF reader
const ON_THE_PAGE = /: click .*/; // words of a title that hold on the page only
const MM = 96 / 25.4; // pixels
const FOLDED = 360; // px, width of a figure that is folded, and so has none on the page

// The picture of a figure as an SVG element; `width` and `height` in mm, null for those on the page.
export async function pictureOf(name, { width = null, height = null } = {}) {
  const shape = inPage(`svg[data-figure="${name}"]`);
  if (shape) return standalone(shape, width);
  const view = await drawnView(name);
  if (!view) throw new Error(`${name} is not drawn`);
  const folded = { width: FOLDED, height: view.model.height ?? FOLDED / 2 };
  const { width: shown, height: high } = view.bbox.width > 0 ? view.bbox : folded;
  const wide = width ? width * MM : shown;
  const least = Math.min(high, wide); // of a wide figure in a narrow column
  const key = keyOf(name, wide);
  const size = { width: wide, height: height ? Math.max(height * MM - key.height, LEAST) : Math.max((wide * high) / shown, least) };
  return withCopyOf(view.model, size, PICTURE_FONT, async (copy, drawn) => {
    const { title } = copy.model;
    if (title) title.text = wholeText(view.model.title, "text").replace(ON_THE_PAGE, "");
    fitFigure(copy.model);
    await drawn();
    const svg = new DOMParser().parseFromString(await (await copy.export("svg").to_blob()).text(), "image/svg+xml");
    const picture = document.importNode(svg.documentElement, true);
    const { width: drawnWidth, height: drawnHeight } = copy.bbox; // whole pixels
    picture.setAttribute("viewBox", `0 0 ${drawnWidth} ${drawnHeight + key.height}`);
    picture.setAttribute("width", size.width);
    picture.setAttribute("height", size.height + key.height);
    picture.querySelector("defs").after(background(drawnWidth, drawnHeight + key.height));
    picture.append(...key.draw(drawnHeight));
    for (const outline of picture.querySelectorAll('text[fill="none"]')) outline.remove(); // Bokeh's, and invisible
    for (const image of picture.querySelectorAll("image")) image.setAttribute("style", "image-rendering: pixelated"); // cells
    return picture;
  });
}

// The view of a figure, which may come a moment after the file that asks for it.
async function drawnView(name, tries = 60) {
  const view = viewOf(name);
  if (view?.frame && view.bbox.width > 1) return view;
  if (!tries || !modelOf(name)) return view;
  await new Promise((done) => setTimeout(done, 50));
  return drawnView(name, tries - 1);
}

// ---- the key of the colours, which stands beside the figures on the page ----

const LEAST = 60; // px, height of a figure above its key
const KEY = { line: 18, gap: 14, size: 11, left: 8, patch: { width: 16, height: 12 } };

// The key of a figure in so many lines as its width asks for: their height, and the shapes below a figure.
function keyOf(name, width) {
  const list = inPage(`.study[data-keyed~="${name}"] .key`);
  const parts = [...list?.children ?? []].map((item) => ({ text: item.textContent, patch: item.querySelector(".patch") }));
  if (!parts.length) return { height: 0, draw: () => [] };
  const head = list.previousElementSibling.textContent;
  let [x, row] = [KEY.left + widthOf(`${head}:`, `${KEY.size}px ${PICTURE_FONT}`) + KEY.gap, 0];
  for (const part of parts) {
    const long = KEY.patch.width + 5 + widthOf(part.text, `${KEY.size}px ${PICTURE_FONT}`);
    if (x > KEY.left && x + long > width) [x, row] = [KEY.left, row + 1];
    Object.assign(part, { x, row });
    x += long + KEY.gap;
  }
  const draw = (top) => {
    const write = (x, row, text) => svgElement("text", { x, y: top + row * KEY.line + 10, fill: colourOfPage("--ink"),
      "font-size": `${KEY.size}px`, "font-family": PICTURE_FONT }, text);
    return [write(KEY.left, 0, `${head}:`), ...parts.flatMap(({ x, row, text, patch }) => [
      ...patchShapes(patch, x, top + row * KEY.line), write(x + KEY.patch.width + 5, row, text)])];
  };
  return { height: (row + 1) * KEY.line + 2, draw };
}

const colourOfPage = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

// One patch with its colour and hatch, as `study.css` has them.
function patchShapes(patch, x, y) {
  const { width: w, height: h } = KEY.patch;
  const [, pattern] = patch.className.split(" ");
  const across = (step, at) => Array.from({ length: Math.floor(at / step) }, (_, i) => step * (i + 0.5));
  const level = across(4, h).map((d) => `M ${x} ${y + d} L ${x + w} ${y + d}`);
  const upright = across(4, w).map((d) => `M ${x + d} ${y} L ${x + d} ${y + h}`);
  const rising = [0, 4].map((d) => `M ${x + d} ${y + h} L ${x + d + h} ${y}`);
  const falling = [0, 4].map((d) => `M ${x + d} ${y} L ${x + d + h} ${y + h}`);
  const lines = { lines: level, bars: upright, grid: [...level, ...upright], slant: rising, back: falling,
    cross: [`M ${x} ${y} L ${x + w} ${y + h}`, `M ${x} ${y + h} L ${x + w} ${y}`], veil: upright }[pattern];
  const look = { fill: "none", stroke: pattern === "veil" ? KEY_VEIL : colourOfPage("--ink"), "stroke-width": pattern === "veil" ? 2.5 : 1 };
  const round = { dots: { r: 1.1, fill: colourOfPage("--ink") }, rings: { r: 1.8, ...look, "stroke-width": 0.8 } }[pattern];
  const spots = round ? across(5, w).flatMap((dx) => across(6, h).map((dy) => svgElement("circle", { cx: x + dx, cy: y + dy, ...round }))) : [];
  return [
    svgElement("rect", { x, y, width: w, height: h, fill: getComputedStyle(patch).backgroundColor, stroke: colourOfPage("--line"), "stroke-width": 1 }),
    ...(lines ? [svgElement("path", { d: lines.join(" "), ...look })] : []),
    ...spots,
  ];
}
const KEY_VEIL = "#35456C"; // of the dark classes, which a veil lies over

function standalone(shape, width) {
  const copy = shape.cloneNode(true);
  const { width: wide, height: high } = shape.viewBox.baseVal;
  const scale = width ? (width * MM) / wide : 1;
  for (const [name, value] of Object.entries({ width: wide * scale, height: high * scale })) copy.setAttribute(name, value);
  for (const name of ["class", "style", "role", "data-figure", "aria-label"]) copy.removeAttribute(name);
  copy.setAttribute("font-family", PICTURE_FONT);
  const copies = [...copy.querySelectorAll(DRAWN)];
  [...shape.querySelectorAll(DRAWN)].forEach((original, i) => copyStyle(copies[i], getComputedStyle(original)));
  copy.prepend(background(wide, high));
  return copy;
}

function copyStyle(copy, style) {
  if (style.display === "none") {
    copy.remove();
    return;
  }
  for (const name of ["class", "style", "tabindex", "role"]) copy.removeAttribute(name);
  for (const name of STYLE_PROPERTIES) copy.setAttribute(name, style.getPropertyValue(name));
}

function background(width, height) {
  return svgElement("rect", { width, height, fill: colourOfPage("--paper") });
}

// ---- the files ----

// The file of a picture. `about` is what it says of itself: title and description; `dpi` is the resolution of a PNG.
export async function pictureFile(picture, type, about, dpi) {
  const size = { width: Number(picture.getAttribute("width")), height: Number(picture.getAttribute("height")) };
  if (type === "pdf") return pdfFile(picture, size, about);
  for (const [name, value] of Object.entries(size)) picture.setAttribute(name, `${(value / MM).toFixed(3)}mm`);
  picture.prepend(svgElement("title", {}, about.title), svgElement("desc", {}, about.description));
  const svg = new Blob([new XMLSerializer().serializeToString(picture)], { type: "image/svg+xml" });
  return type === "svg" ? svg : pngFile(svg, size, about, dpi);
}

async function pngFile(svg, { width, height }, about, dpi) {
  const image = new Image();
  image.src = URL.createObjectURL(svg);
  const canvas = element("canvas");
  try {
    await image.decode();
    Object.assign(canvas, { width: Math.round((width * dpi) / 96), height: Math.round((height * dpi) / 96) });
    canvas.getContext("2d").drawImage(image, 0, 0, canvas.width, canvas.height);
  } finally {
    URL.revokeObjectURL(image.src);
  }
  const drawn = await new Promise((done) => canvas.toBlob(done, "image/png"));
  if (!drawn) throw new Error("this browser cannot draw so many pixels: take a smaller width, or fewer dpi");
  const bytes = new Uint8Array(await drawn.arrayBuffer());
  const perMetre = new DataView(new ArrayBuffer(9));
  for (const at of [0, 4]) perMetre.setUint32(at, Math.round(dpi / 0.0254));
  perMetre.setUint8(8, 1);
  const texts = Object.entries({ Title: about.title, Description: about.description }).map(([key, text]) =>
    pngChunk("iTXt", new TextEncoder().encode(`${key}\0\0\0\0\0${text}`)));
  const start = 33; // the signature, and the header, which comes first
  return new Blob([bytes.slice(0, start), pngChunk("pHYs", new Uint8Array(perMetre.buffer)), ...texts, bytes.slice(start)],
    { type: "image/png" });
}

function pngChunk(kind, content) {
  const chunk = new Uint8Array(content.length + 12);
  chunk.set(new TextEncoder().encode(kind), 4);
  chunk.set(content, 8);
  const view = new DataView(chunk.buffer);
  view.setUint32(0, content.length);
  view.setUint32(content.length + 8, crc32(chunk.subarray(4, content.length + 8)));
  return chunk;
}

function crc32(bytes) {
  let crc = -1;
  for (const byte of bytes) {
    crc ^= byte;
    for (let bit = 0; bit < 8; bit += 1) crc = (crc >>> 1) ^ (crc & 1 ? 0xEDB88320 : 0);
  }
  return ~crc >>> 0;
}
