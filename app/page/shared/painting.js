// What Bokeh does for each paint, and each move of the pointer, that our figures don't need: it asks the browser for
// styles between writing others, so that all styles are computed anew some sixty times a paint, and prepares looks of
// curves that nobody sees: together as much work as the painting. It stands in the page's head, before any figure.
//
// Nothing here changes what is painted, but for when a tooltip comes. Should a later Bokeh lack a name, that part stays
// as Bokeh has it.

function only(path, name, change) {
  try { change(Bokeh.loader[path][name].prototype); } catch (error) { console.warn(`${name} is left as it is`, error); }
}

// Colours by CSS variables (--bk-…), asked for one by one: our themes exchange the models' own colours.
only("core/visuals/visual", "VisualProperties", (visual) => {
  visual._get_css_value = () => "";
});

// The same text as before, written again, makes the browser read it again.
only("core/dom", "InlineStyleSheet", (sheet) => {
  const update = sheet._update;
  sheet._update = function (css) {
    if (css !== this.written) update.call(this, css);
    this.written = css;
  };
});

// What an "em" is: asked for with each label of an axis. Our fonts are in pixels.
only("models/plots/plot_canvas", "PlotView", (plot) => {
  const asked = Object.getOwnPropertyDescriptor(plot, "base_font_size").get;
  Object.defineProperty(plot, "base_font_size", {
    get() {
      this.em ??= asked.call(this);
      return this.em;
    },
  });
});

// The layer above all others is empty but while somebody draws a box. The browser puts an empty
// layer into the page with each frame as it does a full one.
only("models/plots/plot_canvas", "PlotView", (plot) => {
  const paint = plot._paint_overlays;
  plot._paint_overlays = function (ctx) {
    paint.call(this, ctx);
    const used = this.computed_renderer_views.some(({ model }) => model.level === "overlay" && model.visible);
    this.canvas_view.overlays.el.style.display = used ? "" : "none";
  };
});

only("models/renderers/glyph_renderer", "GlyphRendererView", (curve) => {
  // The place of a curve's element, another with each of its numbers: nothing lies in it.
  curve.update_position = () => {};
  // Beside its own look, which is built first, a curve has four: selected, not selected, muted, thinned.
  const build = curve.build_glyph_view;
  curve.build_glyph_view = async function (glyph) {
    const look = await build.call(this, glyph);
    return this.glyph ? whenPainted(look) : look;
  };
});

// A look that takes its numbers not when they come but when it is painted, the latest of them.
function whenPainted(look) {
  const due = new Map();
  for (const name of ["set_data", "set_visuals", "after_visuals", "map_data"]) {
    const act = look[name];
    look[name] = (...given) => { due.set(name, () => act.apply(look, given)); };
  }
  const paint = look.paint;
  look.paint = (...given) => {
    for (const act of due.values()) act();
    due.clear();
    paint.apply(look, given);
  };
  return look;
}

// A legend makes its entries anew with each number of the curves that they name.
only("models/annotations/legend", "LegendView", (legend) => {
  const render = legend.render;
  legend.render = function () {
    this.states = null; // a change of the legend's own
    render.call(this);
  };
  const renderItems = legend._render_items;
  legend._render_items = function () {
    const states = JSON.stringify(this.model.items.map((item) => [item.visible, this.is_active(item)]));
    if (this._should_rerender_items || states !== this.states) renderItems.call(this);
    this.states = states;
  };
});

// A tooltip that follows the pointer costs more than all else that a move does: it comes where the pointer rests.
const RESTS = 100; // ms

only("models/tools/inspectors/hover_tool", "HoverToolView", (hover) => {
  const inspect = hover._inspect;
  hover._inspect = function (sx, sy, dims) {
    clearTimeout(this.resting);
    const look = () => inspect.call(this, sx, sy, dims);
    if (!Number.isFinite(sx + sy)) {
      look(); // the pointer has left: nothing is there
      return;
    }
    const place = `${sx} ${sy}`;
    if (place !== this.place) this.ttmodels.forEach((tooltip) => tooltip.clear());
    this.place = place;
    this.resting = setTimeout(look, RESTS);
  };
});
