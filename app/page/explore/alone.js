// What stands above the curves over each number alone: the title, how far the search is, and the key of the marks.

import { element, follow, setText } from "../shared/dom.js";

const MARKS = [
  ["now", "◆", "now", "What is left with the present value"],
  ["best", "○", "at best", "The value that leaves least; a click sets it"],
  ["equal", "┆", "equal restitution", "The contact has the restitution of the reference"],
  ["unresolved", "■", "under 10 steps", "A contact takes fewer than ten steps"],
  ["floor", "─", "joint damping", "Its part of the difference: no K, D or step mends it"],
];

export function render({ model }) {
  const state = element("span", "state", "", { role: "status" });
  const key = element("ul", "key");
  for (const [name, sign, words, hint] of MARKS) {
    const mark = element("span", "sign", sign, { "aria-hidden": "true" });
    key.append(element("li", name, [mark, words], { title: hint }));
  }
  const root = element("section", "head", [element("h2", "", "Change one number alone: what is left of the difference"), state, key]);
  follow(model, ["state", "floor"], () => {
    setText(state, model.state);
    key.querySelector(".floor").hidden = !model.floor;
  });
  return root;
}
