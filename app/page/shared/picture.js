// A picture of what the page itself draws as SVG: with the looks that the style sheets give it written into each shape,
// so that it is the same without them. Bokeh makes the pictures of its own figures.

const LOOKS = ["fill", "stroke", "stroke-width", "stroke-dasharray", "opacity", "font-family", "font-size", "font-weight",
  "text-anchor"];
const SEEN = ":not(title)";
const FINE = 2; // pixels of a PNG for each unit of the drawing

async function pictureOf(shape, type) {
  const drawn = standalone(shape);
  const svg = new Blob([new XMLSerializer().serializeToString(drawn)], { type: "image/svg+xml" });
  return type === "svg" ? svg : painted(svg, drawn.viewBox.baseVal);
}

function standalone(shape) {
  const copy = shape.cloneNode(true);
  const { width, height } = shape.viewBox.baseVal;
  for (const [name, value] of Object.entries({ width, height })) copy.setAttribute(name, value);
  const copies = [...copy.querySelectorAll(SEEN)];
  [...shape.querySelectorAll(SEEN)].forEach((original, i) => dress(copies[i], getComputedStyle(original)));
  copy.prepend(ground(width, height));
  return copy;
}

function dress(copy, look) {
  if (look.display === "none") {
    copy.remove();
    return;
  }
  for (const name of ["class", "style", "tabindex", "role"]) copy.removeAttribute(name);
  for (const name of LOOKS) copy.setAttribute(name, look.getPropertyValue(name));
}

function ground(width, height) {
  const made = document.createElementNS("http://www.w3.org/2000/svg", "rect");
  const fill = getComputedStyle(document.documentElement).getPropertyValue("--paper");
  for (const [name, value] of Object.entries({ width, height, fill })) made.setAttribute(name, value);
  return made;
}

async function painted(svg, { width, height }) {
  const image = new Image();
  image.src = URL.createObjectURL(svg);
  try {
    await image.decode();
  } finally {
    URL.revokeObjectURL(image.src);
  }
  const canvas = element("canvas");
  Object.assign(canvas, { width: FINE * width, height: FINE * height });
  canvas.getContext("2d").drawImage(image, 0, 0, canvas.width, canvas.height);
  return new Promise((done) => canvas.toBlob(done, "image/png"));
}
