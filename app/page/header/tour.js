// Five steps through the page, shown on the first visit and by the button, except with `?tour=0` and in automated browsers.

const STEPS = [
  [".scenes", "Begin with a scene", "Each is a motion or a figure of the paper and sets η, K, D and the time step at once."],
  [".slider", "Move a slider", "Both solvers run anew over 2,050 periods while you drag: the exact reference, and the penalty model as an FE code would compute it."],
  [".mechanism", "Watch it move", "The pendulums at the present phase. Rest the pointer on a time figure and every figure marks that instant."],
  [".findings", "Read what it means", "Whether the two agree, by how much, and which number causes the difference where they do not."],
  [".take-away", "Take it away", "Figures, data, a script that gives the same numbers, a report, and a link that restores this view."],
];

// Shows the tour in `root`, which has its style; on the first visit, or whenever `requested`.
function tour(root, requested) {
  const skipped = navigator.webdriver || new URLSearchParams(location.search).get("tour") === "0";
  if (!requested && (skipped || preferences.get("tour") === "seen")) return;
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
  addMarkStyle();
  root.append(dialog);
  dialog.showModal();
  preferences.set("tour", "seen");
  step(0);
}

// The first element that matches a selector, in any shadow root.
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
  // No room beside it: use the half of the screen in which it does not lie.
  if (!right && left + width > box.left) {
    top = box.top + box.bottom < innerHeight ? innerHeight - height - 12 : 12;
  }
  Object.assign(dialog.style, { width: `${width}px`, left: `${left}px`, top: `${top}px`, margin: "0" });
}

// The marked element may lie in any shadow root, so every shadow root gets the style of the mark.
function addMarkStyle() {
  if (addMarkStyle.done) return;
  addMarkStyle.done = true;
  const sheet = new CSSStyleSheet();
  sheet.replaceSync(".toured { outline: 3px solid #1B6FC2 !important; outline-offset: 2px; border-radius: 6px; }");
  const adopt = (root) => {
    root.adoptedStyleSheets = [...root.adoptedStyleSheets, sheet];
    for (const host of root.querySelectorAll("*")) if (host.shadowRoot) adopt(host.shadowRoot);
  };
  adopt(document);
}
