// What to know of a motion that was opened from a branch.

import { button, card, element, emit, follow, setText } from "../shared/dom.js";

export function render({ model }) {
  const root = card("opened", "Motion of a branch");
  const words = element("p", "", "", { role: "status" });
  const back = button("Back to the branches", "", () => emit("view", { value: "bifurcation" }));
  root.append(words, back, button("×", "Close this line", () => model.send_msg({ close: true })));
  follow(model, "words", () => setText(words, model.words));
  return root;
}
