// A measurement: the button that chooses its file, which can be dropped on the page, too.

import { button, element, emit, listen } from "../shared/dom.js";
import { chooser } from "../shared/upload.js";

export function render({ model }) {
  const open = button(["+ CSV", element("span", "long", " measurement")], "", () => {});
  open.title = "Lay a measurement, or the CSV file of a code, over both solutions: choose a file, or drop it on the page";
  const { root, field } = chooser(model, open, {
    largest: model.largest,
    drop: "Drop the file: a CSV file is laid over both solutions, a TOML file sets the system",
    show: () => emit("view", { value: "explore" }), // where it is drawn
  });
  field.dataset.measurement = "";
  listen("choose-measurement", () => field.click());
  return root;
}
