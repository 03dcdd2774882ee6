// What to know of a motion that was opened from a branch.

import { button, element, emit, setText } from "../shared/dom.js";

export function render({ model }) {
  const root = element("section", "opened");
  root.setAttribute("aria-label", "Motion of a branch");
  const words = element("p");
  words.setAttribute("role", "status");
  root.append(
    words,
    button("Back to the branches", "", () => emit("view", { value: "bifurcation" })),
    button("×", "Close this line", () => model.send_msg({ close: true })),
  );
  const draw = () => {
    setText(words, model.words);
    emit("figures-changed"); // with the words comes a curve
  };
  model.on("words", draw);
  draw();
  return root;
}
