// Pictures of the SVG drawings of the page. The properties that style sheets give are written into each shape, so that
// the picture looks the same without them. Bokeh makes the pictures of its own figures.

const STYLE_PROPERTIES = ["fill", "stroke", "stroke-width", "stroke-dasharray", "opacity", "font-family", "font-size", "font-weight",
  "text-anchor"];
const DRAWN = ":not(title)";
const PIXELS_PER_UNIT = 2; // of a PNG

async function pictureOf(shape, type) {
  const drawn = standalone(shape);
  const svg = new Blob([new XMLSerializer().serializeToString(drawn)], { type: "image/svg+xml" });
  return type === "svg" ? svg : rasterise(svg, drawn.viewBox.baseVal);
}

function standalone(shape) {
  const copy = shape.cloneNode(true);
  const { width, height } = shape.viewBox.baseVal;
  for (const [name, value] of Object.entries({ width, height })) copy.setAttribute(name, value);
  const copies = [...copy.querySelectorAll(DRAWN)];
  [...shape.querySelectorAll(DRAWN)].forEach((original, i) => copyStyle(copies[i], getComputedStyle(original)));
  copy.prepend(background(width, height));
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

async function rasterise(svg, { width, height }) {
  const image = new Image();
  image.src = URL.createObjectURL(svg);
  try {
    await image.decode();
  } finally {
    URL.revokeObjectURL(image.src);
  }
  const canvas = element("canvas");
  Object.assign(canvas, { width: PIXELS_PER_UNIT * width, height: PIXELS_PER_UNIT * height });
  canvas.getContext("2d").drawImage(image, 0, 0, canvas.width, canvas.height);
  return new Promise((done) => canvas.toBlob(done, "image/png"));
}
