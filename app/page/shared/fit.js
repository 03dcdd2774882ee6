// Texts and legends of the figures at the size that each figure has: titles and axis labels are broken into lines, and a
// legend that is wider than its frame goes above it. The names of the figures for screen readers are made of the same
// texts.

import { LOCAL, oncePer } from "./dom.js";

const EDGE = 4; // px left free beside a text
const LEGEND_MARGIN = 20; // px of a legend beside its entries
const TOUCHED = 26; // px, height of a legend entry under a finger
const ruler = document.createElement("canvas").getContext("2d");

const widthOf = (text, font) => {
  ruler.font = font;
  return ruler.measureText(text).width;
};
const fontOf = (model, name) => ["font_style", "font_size", "font"].map((part) => model[`${name}_${part}`]).join(" ");

// The text in as few lines of this width as its words allow.
function inLines(text, font, width) {
  const lines = [];
  for (const word of text.split(" ")) {
    const longer = `${lines.at(-1)} ${word}`;
    if (lines.length && widthOf(longer, font) <= width) lines.splice(-1, 1, longer);
    else lines.push(word);
  }
  return lines.join("\n");
}

const wholeTexts = new WeakMap(); // by model, since the server knows only whole texts, and sends nothing twice

function wholeText(model, name) {
  const known = wholeTexts.get(model);
  return known && known.shown === model[name] ? known.whole : model[name] ?? "";
}

const linesIn = (text) => text.split("\n").length;

// Returns whether the number of lines is another one than before.
function breakText(model, name, font, width) {
  const whole = wholeText(model, name);
  const shown = inLines(whole, font, width);
  const before = wholeTexts.get(model)?.shown ?? "";
  wholeTexts.set(model, { whole, shown });
  if (shown !== (model[name] ?? "")) model.setv({ [name]: shown }, LOCAL);
  return linesIn(shown) !== linesIn(before);
}

const axesOf = (figure) => [...figure.below, ...figure.left, ...figure.right, ...figure.above]
  .filter((part) => "axis_label" in part);

function fitTexts(view) {
  const { model: figure, bbox, frame } = view;
  if (figure.title?.visible) {
    const width = bbox.width - frame.bbox.left - EDGE;
    const changed = breakText(figure.title, "text", fontOf(figure.title, "text"), width);
    // Bokeh paints a changed title where it is: only a new layout gives its lines room. They are known a moment later,
    // before the next frame is painted.
    if (changed) setTimeout(() => view.invalidate_layout());
  }
  const centred = (middle, length) => 2 * Math.min(middle, length - middle) - EDGE;
  for (const axis of axesOf(figure)) {
    const upright = figure.left.includes(axis) || figure.right.includes(axis);
    const room = upright ? centred(frame.bbox.vcenter, bbox.height) : centred(frame.bbox.hcenter, bbox.width);
    breakText(axis, "axis_label", fontOf(axis, "axis_label_text"), room);
  }
}

// A figure has at most one legend.
const raisedLegends = new WeakSet(); // those that were put above their frame here, and not by the server
const legendColumns = new WeakMap(); // by legend: the number that the server gave
const legendOf = (figure) => [...figure.center, ...figure.above].find((part) => part.type === "Legend");

function fitLegend(view) {
  const { model: figure, bbox, frame } = view;
  const legend = legendOf(figure);
  if (!legend) return;
  if (!legendColumns.has(legend)) legendColumns.set(legend, legend.ncols);
  const most = legendColumns.get(legend);
  const font = fontOf(legend, "label_text");
  const widths = legend.items.filter((item) => item.visible)
    .map((item) => legend.glyph_width + legend.label_standoff + legend.spacing + widthOf(item.label.value ?? "", font));
  const fits = (columns, room) => {
    const widest = Array.from({ length: columns }, (_, i) => Math.max(...widths.filter((__, at) => at % columns === i)));
    return widest.reduce((sum, width) => sum + width, LEGEND_MARGIN) <= room;
  };
  const all = Math.min(most === "auto" ? 99 : most, widths.length) || 1;
  const isInside = figure.center.includes(legend);
  const inside = (isInside || raisedLegends.has(legend)) && fits(all, frame.bbox.width);
  let columns = all;
  while (!inside && columns > 1 && !fits(columns, bbox.width - frame.bbox.left)) columns -= 1;
  const ncols = inside ? most : columns;
  if (ncols !== legend.ncols) legend.setv({ ncols }, LOCAL);
  if (inside === isInside) return;
  raisedLegends.add(legend);
  moveLegend(view, legend, inside);
}

function nameFigure(view) {
  const { model: figure } = view;
  const title = figure.title ? wholeText(figure.title, "text") : "";
  const axes = axesOf(figure).filter((axis) => axis.visible).map((axis) => wholeText(axis, "axis_label")).filter(Boolean);
  const stop = view.canvas_view.events_el; // has the keyboard's focus
  stop.setAttribute("role", "figure");
  stop.setAttribute("aria-label", [title || figure.name, ...axes].join(", "));
}

const fitted = new WeakSet(); // views that are followed

// Fits a figure now, and whenever its size or one of its texts changes. Returns whether it is on the page.
export function fitFigure(figure) {
  const view = Bokeh.index.find_one_by_id(figure.id);
  if (!view?.frame) return false;
  if (fitted.has(view)) return true;
  fitted.add(view);
  const fit = () => {
    nameFigure(view);
    if (view.bbox.width < 2 || !view.el.isConnected) return; // in a hidden tab
    fitLegend(view);
    fitTexts(view);
  };
  const later = oncePer(requestAnimationFrame, fit);
  const { properties } = figure;
  const legend = legendOf(figure);
  if (legend && matchMedia("(pointer: coarse)").matches) {
    legend.setv({ glyph_height: TOUCHED, label_height: TOUCHED }, LOCAL);
  }
  const changes = [properties.inner_width, properties.inner_height, properties.outer_width, figure.title?.properties.text,
    ...axesOf(figure).map((axis) => axis.properties.axis_label),
    ...(legend?.items.map((item) => item.properties.visible) ?? []), legend?.properties.items]; // pins add entries
  for (const property of changes) property?.change.connect(later);
  fit();
  return true;
}
