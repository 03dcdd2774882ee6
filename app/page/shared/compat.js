// The only file of the page that uses private names of Bokeh's and Panel's scripts; it runs after them, before any figure.
//
// Bokeh asks for styles between writing others, and prepares curves that nobody sees. Each hook leaves out a part of that;
// what is painted stays the same. Its comment says what the main thread takes without it (benchmarks/hooks.py NAME). If a
// later version lacks a name, that part works as the library has it, and the console and tests/ui/test_compat.py say so.

function hook(name, path, className, changes) {
  const prototype = Bokeh.loader[path]?.[className]?.prototype;
  for (const [method, change] of Object.entries(changes)) {
    if (typeof prototype?.[method] === "function") prototype[method] = change(prototype[method]);
    else console.warn(`hook "${name}": Bokeh has no method ${path} ${className}.${method}`);
  }
}

// Panel loads modules through es-module-shims, which fetches blob: addresses; the page's policy forbids that. The browser's
// own import suffices, and that script is not loaded (`app.server.admission`).
window.importShim = Object.assign((url) => import(url), { addImportMap() {} });

// Colours from CSS variables (--bk-…), which Bokeh reads one by one; the page's themes exchange the models' colours.
// A key press takes 6 to 10 % more.
hook("colours", "core/visuals/visual", "VisualProperties", {
  _get_css_value: () => () => "",
});

// Whatever changes in a figure or in the size of a component, Bokeh lays out all figures of the page. The grids of the page
// give each figure a size that its content does not change, so that it is laid out alone. An opening takes 30 % more.
hook("figures", "models/plots/plot_canvas", "PlotView", {
  invalidate_layout: () => function () {
    this.update_layout();
    this.compute_layout();
  },
  compute_layout: () => function () {
    this.measure_layout();
    this.update_bbox();
    this._compute_layout();
    this.after_layout();
    this._layout_computed = true;
  },
});
hook("resizes", "models/layouts/layout_dom", "LayoutDOMView", {
  after_resize: (act) => function () {
    if (this.canvas_view) {
      act.call(this);
      return;
    }
    this._resized = true;
    this._update_bbox(); // its own: a figure compares its size with the one that it was laid out for
    this.finish();
  },
});

// A view of a tab that is hidden is laid out once more, and then when it is shown again. To open one view after the other
// takes twice as much.
const rests = (view) => view.model.visible === false && view.laidOutHidden;
const unlessHidden = (act) => function () {
  return rests(this) ? undefined : act.call(this);
};
hook("hidden", "models/layouts/layout_dom", "LayoutDOMView", {
  update_layout: unlessHidden,
  measure_layout: unlessHidden,
  update_bbox: unlessHidden,
  _compute_layout: unlessHidden,
  after_layout: (act) => function () {
    if (rests(this)) return;
    act.call(this);
    this.laidOutHidden = !this.model.visible;
  },
  r_after_render: () => function () {
    for (const child of this.children()) if (!rests(child)) child.r_after_render?.();
    this.after_render();
    this._was_built = true;
  },
});

// The browser parses a style sheet again when the same text is written to it. A key press takes 17 to 24 % more.
hook("sheets", "core/dom", "InlineStyleSheet", {
  _update: (update) => function (css) {
    if (css !== this.written) update.call(this, css);
    this.written = css;
  },
});

// The position of a curve's HTML element, which is empty, changes with its data. A key press takes 13 to 21 % more.
hook("positions", "models/renderers/glyph_renderer", "GlyphRendererView", {
  update_position: () => () => {},
});

// Beside its own glyph, which is built first, a curve has four more: selected, not selected, muted, thinned. They take
// new data when they are painted. A key press takes 19 % more.
hook("glyphs", "models/renderers/glyph_renderer", "GlyphRendererView", {
  build_glyph_view: (build) => async function (glyph) {
    const view = await build.call(this, glyph);
    return this.glyph ? updateWhenPainted(view) : view;
  },
});

function updateWhenPainted(view) {
  const due = new Map(); // the latest call of each method
  for (const name of ["set_data", "set_visuals", "after_visuals", "map_data"]) {
    const update = view[name];
    view[name] = (...given) => { due.set(name, () => update.apply(view, given)); };
  }
  const paint = view.paint;
  view.paint = (...given) => {
    for (const update of due.values()) update();
    due.clear();
    paint.apply(view, given);
  };
  return view;
}

// Numbers with a power of ten have three digits after the point, also where these are zeros: 2.000e−6, 0.000e+0.
hook("numbers", "models/formatters/basic_tick_formatter", "BasicTickFormatter", {
  _format_with_precision: (format) => function (...given) {
    return format.apply(this, given).map((text) => text.replace(/\.?0+e/, "e").replace(/^0e.*/, "0"));
  },
});

// Entries of a legend mute their curves. Bokeh offers that to a pointer only; here they are switches that keys and
// screen readers reach.
hook("switches", "models/annotations/legend", "LegendView", {
  _render_items: (renderItems) => function () {
    const focused = this.entries.findIndex(({ el }) => el === this.shadow_el.activeElement);
    renderItems.call(this);
    if (this.model.click_policy === "none") return;
    for (const { el } of this.entries) {
      el.tabIndex = 0;
      el.role = "switch";
      el.addEventListener("keydown", pressEntry);
    }
    this.entries[focused]?.el.focus({ preventScroll: true }); // the entry that was pressed is a new element
  },
  _toggle_inactive: (toggle) => function (entry) {
    toggle.call(this, entry);
    if (this.model.click_policy !== "none") entry.el.ariaChecked = String(this.is_active(entry.item));
  },
});

function pressEntry(event) {
  if (event.key !== "Enter" && event.key !== " ") return;
  event.preventDefault();
  event.stopPropagation(); // these are keys of the page, too
  event.currentTarget.dispatchEvent(new PointerEvent("pointerdown"));
}

// A legend builds its entries again whenever the data of their curves change. A key press takes 18 % more.
hook("legends", "models/annotations/legend", "LegendView", {
  render: (render) => function () {
    this.states = null; // the legend itself has changed
    render.call(this);
  },
  _render_items: (renderItems) => function () {
    const states = JSON.stringify(this.model.items.map((item) => [item.visible, this.is_active(item)]));
    if (this._should_rerender_items || states !== this.states) renderItems.call(this);
    this.states = states;
  },
});

// A tooltip follows the pointer; here it appears where the pointer rests. A move of the pointer takes twice as long.
const REST = 100; // ms

hook("tooltips", "models/tools/inspectors/hover_tool", "HoverToolView", {
  _inspect: (inspect) => function (sx, sy, dims) {
    clearTimeout(this.resting);
    const show = () => inspect.call(this, sx, sy, dims);
    if (!Number.isFinite(sx + sy)) {
      show(); // the pointer has left the figure: this hides the tooltip
      return;
    }
    const place = `${sx} ${sy}`;
    if (place !== this.place) this.ttmodels.forEach((tooltip) => tooltip.clear());
    this.place = place;
    this.resting = setTimeout(show, REST);
  },
});

// Puts a legend inside the frame of its figure, or above it. Its view keeps the place at a side for ever unless that is
// taken from it.
window.moveLegend = (view, legend, inside) => {
  const [center, above] = [view.model.center, view.model.above].map((parts) => parts.filter((part) => part !== legend));
  if (inside) Object.assign(view.views.find_one(legend), { panel: null, layout: undefined });
  (inside ? center : above).push(legend);
  view.model.setv({ center, above }, { sync: false });
};

// The room that the axes at a side of a figure need with their present labels, in pixels.
window.widthOfAxes = (view, side) => view.model[side]
  .map((axis) => view.views.find_one(axis)?.get_size?.().height ?? 0).reduce((sum, width) => sum + width, 0);

// ---- pictures of figures ----

// The button of a figure's toolbar that saves it: Bokeh asks for a name and gives the pixels of the screen. Here the
// menu Take away makes the file.
hook("save", "models/tools/actions/save_tool", "SaveToolView", {
  doit: () => function () {
    document.dispatchEvent(new CustomEvent("vibroscope:save-figure", { detail: { value: this.parent.model.name } }));
  },
});
