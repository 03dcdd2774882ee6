// Five steps through the page, shown on the first visit and from the button; `?tour=0` and automated browsers are spared.

const STEPS = [
  [".scenes", "Begin with a scene", "Each is a motion or a figure of the paper and sets η, K, D and the time step at once."],
  [".slider", "Move a slider", "Both solvers run anew over 2,050 periods while you drag: the exact reference, and the penalty model as an FE code would compute it."],
  [".mechanism", "Watch it move", "The pendulums at the present phase. Rest the pointer on a time figure and every figure marks that instant."],
  [".findings", "Read what it means", "Whether the two agree, by how much, and which number is to blame where they do not."],
  [".take", "Take it away", "Figures, data, a script that gives the same numbers, a report, and a link that restores this view."],
];

// `root` is where its style lies.
function tour(root, asked) {
  const spared = navigator.webdriver || new URLSearchParams(location.search).get("tour") === "0";
  if (!asked && (spared || memory.get("tour") === "seen")) return;
  const dialog = element("dialog", "tour");
  const head = element("h2");
  const text = element("p");
  const count = element("span", "count");
  const row = element("div", "row");
  let at = -1;
  let marked = null;
  const next = button("Next", "", () => step(at + 1));
  const back = button("Back", "", () => step(at - 1));
  row.append(count, button("Skip", "Skip the tour", () => dialog.close()), back, next);
  dialog.append(head, text, row);
  dialog.setAttribute("aria-label", "Tour");
  dialog.addEventListener("close", () => { marked?.classList.remove("toured"); dialog.remove(); });
  const step = (to) => {
    if (to >= STEPS.length) return dialog.close();
    at = to;
    const [where, title, words] = STEPS[at];
    head.textContent = title;
    text.textContent = words;
    count.textContent = `${at + 1} of ${STEPS.length}`;
    back.disabled = at === 0;
    next.textContent = at === STEPS.length - 1 ? "Done" : "Next";
    marked?.classList.remove("toured");
    marked = inPage(where);
    marked?.classList.add("toured");
    marked?.scrollIntoView({ block: "nearest" });
    place(dialog, marked);
  };
  styleOnce();
  root.append(dialog);
  dialog.showModal();
  memory.set("tour", "seen");
  step(0);
}

// The first element of a selector, in whatever shadow root it lies.
function inPage(selector, root = document) {
  const found = root.querySelector(selector);
  if (found) return found;
  for (const host of root.querySelectorAll("*")) {
    const deeper = host.shadowRoot && inPage(selector, host.shadowRoot);
    if (deeper) return deeper;
  }
  return null;
}

function place(dialog, marked) {
  const box = marked?.getBoundingClientRect();
  if (!box) return;
  const width = Math.min(340, innerWidth - 24);
  const height = dialog.offsetHeight;
  const right = box.right + 12 + width < innerWidth;
  const left = right ? box.right + 12 : Math.max(12, box.left - width - 12);
  let top = Math.min(Math.max(12, box.top), innerHeight - height - 12);
  // No room beside it: the half of the screen that it does not lie in.
  if (!right && left + width > box.left) {
    top = box.top + box.bottom < innerHeight ? innerHeight - height - 12 : 12;
  }
  Object.assign(dialog.style, { width: `${width}px`, left: `${left}px`, top: `${top}px`, margin: "0" });
}

// The element that is meant may lie in any shadow root, so the mark is put on it directly.
function styleOnce() {
  if (styleOnce.done) return;
  styleOnce.done = true;
  const sheet = new CSSStyleSheet();
  sheet.replaceSync(".toured { outline: 3px solid #1B6FC2 !important; outline-offset: 2px; border-radius: 6px; }");
  const adopt = (root) => {
    root.adoptedStyleSheets = [...root.adoptedStyleSheets, sheet];
    for (const host of root.querySelectorAll("*")) if (host.shadowRoot) adopt(host.shadowRoot);
  };
  adopt(document);
}
