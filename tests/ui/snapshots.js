// Reads the page for `snapshots_page.py`: every figure as it is drawn, every text and its position.
() => {
  const BOXES = "header.head, form.panel, div.lines, div.statements, section, article";
  const document_ = Bokeh.documents[0];
  const round = ({ x, y, width, height }) => [x, y, width, height].map(Math.round);
  const list = (values) => Array.from(values, (value) => (typeof value === "number" && !Number.isFinite(value) ? null : value));

  // ---- figures ------------------------------------------------------------------------------------------------------

  const shown = (view) => view?.el?.checkVisibility({ visibilityProperty: true }) && view.el.getBoundingClientRect().width > 0;
  const figures = [...document_.all_models].filter((model) => model.type === "Figure")
    .map((model) => ({ model, view: Bokeh.index.find_one_by_id(model.id) })).filter(({ view }) => shown(view));

  // A picture is described by the shares of its most frequent values.
  const shares = (pixels) => {
    const counts = new Map();
    for (const pixel of pixels) counts.set(pixel, (counts.get(pixel) ?? 0) + 1);
    return [...counts.values()].sort((a, b) => b - a).slice(0, 6).map((count) => count / pixels.length);
  };
  const columns = (source) => Object.fromEntries([...source.columns()].map((name) => {
    const values = source.get_column(name);
    return [name, ArrayBuffer.isView(values[0]) ? shares(values[0]) : list(values)];
  }));
  const drawn = (model) => model.renderers.filter((renderer) => renderer.data_source && renderer.visible);
  const sources = (model) => Object.fromEntries(drawn(model).map(({ glyph, data_source }, index) =>
    [data_source.name ?? `${glyph.type} ${index}`, columns(data_source)]));
  const axes = (model) => [...model.below, ...model.left, ...model.right, ...model.above]
    .filter((part) => part.type.endsWith("Axis") && part.visible)
    .map((axis) => ({ kind: axis.type, label: axis.axis_label ?? "" }));
  const legend = (model) => model.center.concat(model.above).filter((part) => part.type === "Legend" && part.visible)
    .flatMap(({ items }) => items.filter((item) => item.visible).map((item) => item.label.value ?? item.label.field));
  // A strip under another figure with the same axis needs no label of its own.
  const shares_axis = (model) => figures.some(({ model: other }) =>
    other !== model && other.x_range === model.x_range && axes(other)[0]?.label);

  const paint = (view) => { view.invalidate_painters(); view.paint(); };

  // Pixels that the curves, marks and pictures of a figure add to its empty frame.
  const ink = (view) => {
    const pixels = () => {
      paint(view);
      const from = view.canvas_view.primary.canvas;
      const copy = new OffscreenCanvas(from.width, from.height).getContext("2d", { willReadFrequently: true });
      copy.drawImage(from, 0, 0);
      return copy.getImageData(0, 0, from.width, from.height).data;
    };
    const glyphs = view.computed_renderer_views.filter(({ model }) => model.type === "GlyphRenderer");
    for (const glyph of glyphs) glyph.paint = () => {};
    const without = pixels();
    for (const glyph of glyphs) delete glyph.paint;
    const whole = pixels();
    let count = 0;
    for (let i = 0; i < whole.length; i += 4) {
      if ([0, 1, 2].some((c) => Math.abs(whole[i + c] - without[i + c]) > 24)) count += 1;
    }
    return count;
  };

  // ---- texts --------------------------------------------------------------------------------------------------------

  const texts = [];

  // Texts on a canvas are recorded while they are painted.
  const context = CanvasRenderingContext2D.prototype;
  const plain = context.fillText;
  const written = (figure) => function (text, x, y) {
    plain.call(this, text, x, y);
    if (!text.trim()) return;
    const size = this.measureText(text);
    const corner = (dx, dy) => this.getTransform().transformPoint(new DOMPoint(x + dx, y + dy));
    const one = corner(-size.actualBoundingBoxLeft, -size.actualBoundingBoxAscent);
    const two = corner(size.actualBoundingBoxRight, size.actualBoundingBoxDescent);
    const canvas = this.canvas.getBoundingClientRect();
    const [left, right] = [one.x, two.x].sort((a, b) => a - b);
    const [top, bottom] = [one.y, two.y].sort((a, b) => a - b);
    const cut = left < -1 || top < -1 || right > canvas.width + 1 || bottom > canvas.height + 1;
    texts.push({ text, figure, cut, box: [canvas.x + left, canvas.y + top, right - left, bottom - top] });
  };
  const read_figures = () => figures.map(({ model, view }) => {
    const found = ink(view);
    context.fillText = written(model.name);
    try { paint(view); } finally { context.fillText = plain; }
    return {
      name: model.name, title: model.title.text, axes: axes(model), legend: legend(model), sources: sources(model),
      shares_axis: Boolean(shares_axis(model)), ink: found, box: round(view.el.getBoundingClientRect()),
    };
  });

  const above = (node) => node.assignedSlot ?? node.parentNode ?? node.host ?? null;
  // The nearest element around a node that cuts off what lies outside it; most texts have it in common with others.
  const clips = new Map();
  const clip = (node) => {
    if (!clips.has(node)) {
      const at = above(node);
      const { overflowX = "visible", overflowY = "visible" } = at instanceof Element ? getComputedStyle(at) : {};
      const around = overflowX === "visible" && overflowY === "visible" ? at && clip(at)
        : { at, frame: at.getBoundingClientRect(), scrolls: /auto|scroll/.test(overflowX + overflowY) };
      clips.set(node, around);
    }
    return clips.get(node);
  };
  // The visible part of a box in all elements that contain it, and whether a part is cut off that cannot be scrolled to.
  const seen = (box, node) => {
    let { left, top, right, bottom } = box;
    let cut = false;
    for (let around = clip(node); around; around = clip(around.at)) {
      const { frame, scrolls } = around;
      if (frame.width <= 1 || frame.height <= 1) return null; // for screen readers alone
      const lost = left < frame.left - 2 || right > frame.right + 2 || top < frame.top - 2 || bottom > frame.bottom + 2;
      if (lost && !scrolls) cut = true;
      [left, top] = [Math.max(left, frame.left), Math.max(top, frame.top)];
      [right, bottom] = [Math.min(right, frame.right), Math.min(bottom, frame.bottom)];
      if (!cut && (right - left <= 1 || bottom - top <= 1)) return null;
    }
    return { box: [left, top, right - left, bottom - top], cut };
  };
  const boxes = [];
  const measured = (node) => Boolean(node.parentElement?.closest(".chip dd"));
  const walk = (node) => {
    if (node.nodeType === Node.TEXT_NODE && node.data.trim()) {
      const range = document.createRange();
      range.selectNodeContents(node);
      const lines = [...range.getClientRects()].filter(({ width, height }) => width > 1 && height > 1);
      const places = lines.map((line) => seen(line, node)).filter(Boolean);
      if (places.length) texts.push({ text: node.data.trim().replace(/\s+/g, " "), places, measured: measured(node) });
      return;
    }
    if (node instanceof Element) {
      const boxless = getComputedStyle(node).display === "contents"; // which has no box, and may hold others that have
      if (!boxless && !node.checkVisibility({ visibilityProperty: true, opacityProperty: true })) return;
      if (node.matches("style, script, option, .cue")) return; // a cue fades out the text that it covers
      if (node.matches(BOXES)) boxes.push([node.className, ...round(node.getBoundingClientRect())]);
      const cut = node.matches("input[type=text], input[type=number]") && node.scrollWidth > node.clientWidth + 1;
      if (cut) texts.push({ text: node.value, places: [{ box: round(node.getBoundingClientRect()), cut }], measured: false });
    }
    for (const child of node.shadowRoot?.childNodes ?? []) walk(child);
    for (const child of node.childNodes) walk(child);
  };

  const read = read_figures();
  walk(document.body);
  return { figures: read, texts, boxes, wide: document.scrollingElement.scrollWidth - innerWidth };
}
