// Pictures of the figures as SVG, the form from which the files of each kind are made. A figure of Bokeh is drawn again
// at the wanted size, with letters of the size that they have on the page. A drawing of the page has one shape only; the
// properties that style sheets give are written into it, so that it looks the same without them.

const STYLE_PROPERTIES = ["fill", "stroke", "stroke-width", "stroke-dasharray", "opacity", "font-size", "font-weight", "text-anchor"];
const DRAWN = ":not(title)";
const PICTURE_FONT = "Helvetica, Arial, 'Liberation Sans', sans-serif"; // as wide as the letters of every PDF reader
const ON_THE_PAGE = /: click .*/; // words of a title that hold on the page only
const MM = 96 / 25.4; // pixels

// The picture of a figure as an SVG element; `width` and `height` in mm, null for those on the page.
async function pictureOf(name, { width = null, height = null } = {}) {
  const shape = inPage(`svg[data-figure="${name}"]`);
  if (shape) return standalone(shape, width);
  const view = viewOf(name);
  if (!view) throw new Error(`${name} is not drawn`);
  const { width: shown, height: high } = view.bbox;
  const wide = width ? width * MM : shown;
  const least = Math.min(high, wide); // of a wide figure in a narrow column
  const size = { width: wide, height: height ? height * MM : Math.max((wide * high) / shown, least) };
  return withCopyOf(view.model, size, PICTURE_FONT, async (copy, drawn) => {
    const { title } = copy.model;
    if (title) title.text = wholeText(view.model.title, "text").replace(ON_THE_PAGE, "");
    fitFigure(copy.model);
    await drawn();
    const svg = new DOMParser().parseFromString(await (await copy.export("svg").to_blob()).text(), "image/svg+xml");
    const picture = document.importNode(svg.documentElement, true);
    picture.setAttribute("viewBox", `0 0 ${copy.bbox.width} ${copy.bbox.height}`); // whole pixels
    for (const [name, value] of Object.entries(size)) picture.setAttribute(name, value);
    picture.querySelector("defs").after(background(copy.bbox.width, copy.bbox.height));
    for (const outline of picture.querySelectorAll('text[fill="none"]')) outline.remove(); // Bokeh's, and invisible
    for (const image of picture.querySelectorAll("image")) image.setAttribute("style", "image-rendering: pixelated"); // cells
    return picture;
  });
}

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
  const fill = getComputedStyle(document.documentElement).getPropertyValue("--paper");
  return svgElement("rect", { width, height, fill });
}

// ---- the files ----------------------------------------------------------------------------------------------------------

// The file of a picture. `about` is what it says of itself: title and description; `dpi` is the resolution of a PNG.
async function pictureFile(picture, type, about, dpi) {
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
