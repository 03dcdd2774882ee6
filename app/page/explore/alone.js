// What stands above the curves over each number alone: the title, how far the search is, and the key of the marks.

const MARKS = [
  ["now", "◆", "now"],
  ["best", "○", "at best"],
  ["equal", "┆", "equal restitution"],
  ["unresolved", "■", "under 10 steps in a contact"],
  ["floor", "─", "joint damping, which none mends"],
];

export function render({ model }) {
  const root = element("section", "head");
  const state = element("span", "state");
  state.setAttribute("role", "status");
  const key = element("ul", "key");
  for (const [name, sign, words] of MARKS) {
    const entry = element("li", name);
    const mark = element("span", "sign", sign);
    mark.setAttribute("aria-hidden", "true");
    entry.append(mark, words);
    key.append(entry);
  }
  root.append(element("h2", "", "Change one number alone: what is left of the difference"), state, key);
  const draw = () => {
    setText(state, model.state);
    key.querySelector(".floor").hidden = !model.floor;
    emit("figures-changed"); // with the search come figures
  };
  model.on(["state", "floor"], draw);
  draw();
  return root;
}
