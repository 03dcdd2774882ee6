// Entries of a legend mute their curves. Bokeh lets only a pointer do so: here they are switches, by key as well, and who
// speaks to the page says which are on.

only("models/annotations/legend", "LegendView", (legend) => {
  const renderItems = legend._render_items;
  legend._render_items = function () {
    const held = this.entries.findIndex(({ el }) => el === this.shadow_el.activeElement);
    renderItems.call(this);
    if (this.model.click_policy === "none") return;
    for (const { el } of this.entries) {
      el.tabIndex = 0;
      el.role = "switch";
      el.addEventListener("keydown", pressed);
    }
    this.entries[held]?.el.focus({ preventScroll: true }); // the one that was pressed has been made anew
  };
  const toggle = legend._toggle_inactive;
  legend._toggle_inactive = function (entry) {
    toggle.call(this, entry);
    if (this.model.click_policy !== "none") entry.el.ariaChecked = String(this.is_active(entry.item));
  };
});

function pressed(event) {
  if (event.key !== "Enter" && event.key !== " ") return;
  event.preventDefault();
  event.stopPropagation(); // the page's own keys
  event.currentTarget.dispatchEvent(new PointerEvent("pointerdown"));
}
