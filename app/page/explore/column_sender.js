// Receives changed columns of the sources: names and lengths, and the numbers of all columns in one buffer.

import { LOCAL, asObject, element } from "../shared/dom.js";

export function render({ model }) {
  model.on("msg:custom", ({ names, values }) => {
    const changed = new Map();
    let offset = 0;
    for (const [source, name, length] of names) {
      if (!changed.has(source)) changed.set(source, {});
      // A copy: Bokeh writes the whole buffer of a view, so that a picture would show all columns in each.
      changed.get(source)[name] = new Float32Array(values, offset, length).slice();
      offset += 4 * length;
    }
    for (const [id, columns] of changed) {
      const source = Bokeh.documents[0].get_model_by_id(id);
      source.setv({ data: { ...asObject(source.data), ...columns } }, LOCAL);
    }
  });
  model.send_msg({ listens: true });
  return element("div");
}
