// What a person can do on the page and what there is to see of it, for `walk.py`.
(() => {
  const visible = (node) => node.checkVisibility({ visibilityProperty: true, opacityProperty: true });
  const all = (root = document, found = []) => {
    for (const node of root.querySelectorAll("*")) {
      found.push(node);
      if (node.shadowRoot) all(node.shadowRoot, found);
    }
    return found;
  };
  const textOf = (node) => node.textContent.trim().replace(/\s+/g, " ");
  const labelOf = (node) => node.labels?.length ? [...node.labels].map(textOf).join(" ") : "";
  const nameOf = (node) => node.ariaLabel || labelOf(node) || (node.matches("select, input") ? "" : textOf(node)) || node.title || node.name;
  const groupOf = (node) => node.closest("fieldset")?.querySelector("legend")?.textContent ?? "";
  const INTERACTIVE = "button, input, select, summary, [role=switch], [role=button]";
  const KINDS = { text: "typed", range: "slider", radio: "choice", checkbox: "choice" };
  const kindOf = (node) => {
    if (node.matches("input")) return KINDS[node.type] ?? "";
    if (node.matches("select")) return "select";
    if (node.matches("summary")) return "fold";
    if (node.role === "tab") return "tab";
    if (node.role === "switch") return "legend";
    if (node.matches("[data-scene]")) return "scene";
    return "button";
  };
  const inFrame = (node) => {
    const box = node.getBoundingClientRect();
    return box.width > 1 && box.height > 1;
  };
  // A radio button is drawn by its label.
  const isShown = (node) => (node.matches("input[type=radio]") ? visible(node.parentElement) : visible(node) && inFrame(node));
  const interactive = () => all().filter((node) => node.matches(INTERACTIVE) && isShown(node));

  const figures = () => [...Bokeh.documents[0].all_models].filter((model) => model.type === "Figure")
    .map((model) => ({ model, view: Bokeh.index.find_one_by_id(model.id) }))
    .filter(({ view }) => view?.el && visible(view.el) && inFrame(view.el));

  // What can be done: the elements stay in `window.walked`, by their places in this list.
  const choices = () => {
    window.walked = interactive().filter((node) => !node.disabled && !node.closest("dialog, [popover], .suggest")); // no link holds a search
    return window.walked.map((node) => ({
      kind: kindOf(node),
      name: nameOf(node),
      group: groupOf(node),
      value: node.value ?? "",
      on: Boolean(node.checked || node.ariaPressed === "true" || node.ariaSelected === "true"),
      options: node.matches("select") ? [...node.options].filter((each) => !each.disabled).map((each) => each.value) : [],
    }));
  };
  const frames = () => figures().map(({ model, view }) => {
    view.el.scrollIntoView({ block: "nearest" });
    const canvas = view.canvas_view.el.getBoundingClientRect();
    const { x0, y0, x1, y1 } = view.frame.bbox;
    const zooms = model.toolbar.tools.some((tool) => tool.type === "BoxZoomTool" && tool.active !== false);
    return { name: model.name, zooms, x: canvas.x + x0, y: canvas.y + y0, width: x1 - x0, height: y1 - y0 };
  });

  const isDriven = () => {
    const given = new URLSearchParams(location.search);
    return given.get("base") !== "0" || given.has("force1") || given.has("force2");
  };

  // What is still being computed, in a word.
  const busy = () => {
    if (!Bokeh.documents.every((each) => each.is_idle)) return "messages";
    const nodes = all();
    const running = nodes.find((node) =>
      node.matches("[data-running=true], [data-pending=true], [data-phase=running], [data-stale=true], .busy, [aria-busy=true], progress")
      && !(node.matches("progress") && node.closest(".study, .compiling")) && visible(node));
    const open = nodes.find((node) => node.matches(".line[data-kind='']") && visible(node) && isDriven());
    if (open) return "kinds of motion";
    if (running) return running.className || running.tagName;
    const alone = nodes.find((node) => node.matches("h2") && /^Change one number alone/.test(node.textContent) && visible(node));
    if (alone && !Bokeh.documents[0].get_model_by_name("alone_K")) return "figures that come when they are looked at";
    const title = figures().map(({ model }) => model.title?.text ?? "").find((text) => /comput/.test(text) && !/\b100 %/.test(text));
    if (title) return title;
    const said = nodes.find((node) => !node.childElementCount && /(computing|checking|searching|reading) …/i.test(node.textContent) && visible(node));
    return said ? textOf(said) : "";
  };

  // The same folds are open in both pages, all is scrolled to its beginning, and notes are closed.
  const calm = () => {
    for (const node of all()) {
      if (node.matches(":popover-open")) node.hidePopover();
      if (node.matches("details") && !node.closest("header")) node.open = true;
      if (node.matches("header details")) node.open = false;
      if (node.scrollTop || node.scrollLeft) node.scrollTo({ left: 0, top: 0, behavior: "instant" });
      if (node.matches("[aria-expanded=true]")) node.click();
      if (node.matches(".message.note:not([hidden]) button")) node.click(); // of the numbers of a link that a wall has not
    }
  };
  // Hides some parts, or shows them again; nothing has the focus then.
  const veil = (parts, on) => {
    for (const node of all()) if (node.matches(parts)) node.style.visibility = on ? "hidden" : "";
    let at = document.activeElement;
    while (at?.shadowRoot?.activeElement) at = at.shadowRoot.activeElement;
    at?.blur?.();
  };

  // What the user has done before, and with it what Undo, Redo and Reset can do, is no part of a link.
  const isOfHistory = (node) => node.closest(".actions") && /Undo|Redo|Reset/.test(node.textContent);
  const controls = () => interactive().filter((node) => !node.closest(".found, .message, .coexisting, .tour") && !isOfHistory(node))
    .map((node) => {
      const state = node.matches("[type=radio], [type=checkbox]") ? node.checked : node.value ?? "";
      const marks = ["ariaPressed", "ariaSelected", "ariaChecked", "ariaInvalid"].map((mark) => node[mark]).filter(Boolean);
      return [kindOf(node), groupOf(node), nameOf(node), String(state), ...marks, node.disabled ? "disabled" : ""].join(" | ");
    });

  const ends = (range) => (range.start === undefined || typeof range.start !== "number" ? range.factors ?? []
    : [range.start, range.end].map((end) => Number(end.toPrecision(5))));
  const axes = (model) => [...model.below, ...model.left, ...model.right, ...model.above]
    .filter((part) => part.type.endsWith("Axis") && part.visible).map((axis) => axis.axis_label ?? "");
  const ranges = ({ x_range, y_range, extra_x_ranges, extra_y_ranges }) =>
    [x_range, y_range, ...[extra_x_ranges, extra_y_ranges].flatMap((more) => Object.values(more instanceof Map ? Object.fromEntries(more) : more ?? {}))]
      .map(ends);
  const entries = (model) => [...model.center, ...model.above].filter((part) => part.type === "Legend" && part.visible)
    .flatMap(({ items }) => items.filter((item) => item.visible)
      .map((item) => [item.label.value ?? item.label.field, item.renderers.map((each) => each.visible)]));
  // A sum of all values in their order: equal columns have equal sums.
  const sum = (values) => {
    let total = 0;
    let k = 1;
    for (const value of values) {
      if (typeof value === "number") total += Number.isFinite(value) ? value * (1 + (k % 97)) : 1e-3 * k;
      else if (ArrayBuffer.isView(value)) total += sum(value);
      else for (const letter of String(value)) total += letter.codePointAt(0) * k;
      k += 1;
    }
    return Number(total.toPrecision(6));
  };
  const numeric = (value) => (value && typeof value === "object" && "value" in value ? value.value : value);
  const look = (glyph) => ["line_color", "line_width", "line_dash", "fill_color", "marker"]
    .map((name) => glyph[name]).filter((each) => each !== undefined).map(numeric).join(" ");
  const curves = (model) => model.renderers.filter((renderer) => renderer.data_source && renderer.visible)
    .map(({ glyph, data_source: source }) => {
      const used = ["x", "y", "x0", "y0", "x1", "y1", "left", "right", "top", "bottom", "image", "text"]
        .map((name) => glyph[name]).map((each) => (typeof each === "string" ? each : each?.field)).filter((name) => source.columns().includes(name));
      return [glyph.type, look(glyph), ...used.map((name) => `${name}: ${source.get_column(name).length} ${sum(source.get_column(name))}`)];
    }).filter(([, , ...columns]) => columns.some((column) => !/: 0 /.test(column)))
    .map((each) => each.join(" | "));
  const marks = (model) => model.center.concat(model.renderers).filter((part) => ["Span", "Label"].includes(part.type) && part.visible)
    .map((part) => [part.type, Number((part.location ?? part.x).toPrecision(6)), part.text ?? ""].join(" | "));

  const state = () => ({
    controls: controls(),
    figures: Object.fromEntries(figures().map(({ model }) => [model.name, {
      title: model.title?.text ?? "", axes: axes(model), ranges: ranges(model), legend: entries(model),
      curves: curves(model).sort(), marks: marks(model),
    }])),
  });

  window.walk = { choices, frames, busy, calm, veil, state };
})()
