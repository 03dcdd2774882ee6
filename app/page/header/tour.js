// The tour: from the problem to a suggestion that is applied. It is shown on the first visit and by the button, except with
// `?tour=0` and in automated browsers.

import { exercises } from "./exercises.js";
import { button, element, emit, inPage, listenUntil, preferences } from "../shared/dom.js";

const STEPS = [
  { where: ".question", title: "The problem",
    words: "Two parts of a machine touch. The code that simulates them asks for a contact stiffness K, a contact damping D "
      + "and a time step. No theory supplies the three, and whatever is set, the code shows a motion." },
  { where: ".displacement", title: "A motion that looks right", scene: "9B",
    words: "The thin line is what such a code shows with the numbers that are set: smooth, steady, plausible. The wide line "
      + "is the exact motion of the same two bodies. Only the comparison shows that the thin one is wrong." },
  { where: ".findings", title: "How wrong, and why",
    words: "How far the two are apart, which of the three numbers causes it, and what to change first." },
  { where: ".slider", title: "Other numbers",
    words: "Move a slider: both motions are computed anew, over thousands of periods, while you drag." },
  { where: ".suggest", title: "Numbers that are right", next: "Suggest and set them",
    words: "You need not search by hand. The next step searches for K, D and a time step that meet the error in this field "
      + "at the least cost, and moves the sliders there." },
  { where: ".suggest", title: "Searching", words: "", suggests: true, found: "A suggestion, applied" },
];

// Shows the tour in `root`, which has its style; on the first visit, or whenever `requested`.
export function tour(root, requested) {
  const skipped = navigator.webdriver || new URLSearchParams(location.search).get("tour") === "0";
  if (!requested && (skipped || preferences.get("tour") === "seen")) return;
  const dialog = element("dialog", "tour", "", { "aria-label": "Tour" });
  const head = element("h2");
  const text = element("p", "", "", { "aria-live": "polite" });
  const count = element("span", "count");
  let at = -1;
  const mark = marker();
  const next = button("Next", "", () => step(at + 1));
  const back = button("Back", "", () => step(at - 1));
  const practise = button("Exercises", "Three exercises: predict, try, see", () => { dialog.close(); exercises(root); });
  const skip = button("Skip", "Skip the tour", () => dialog.close());
  const row = element("div", "row", [count, skip, practise, back, next]);
  dialog.append(head, text, row);
  dialog.addEventListener("close", () => { mark(null); stop(); dialog.remove(); });
  const step = (to) => {
    if (to >= STEPS.length) return dialog.close();
    at = to;
    const { where, title, words, scene, next: onward, suggests } = STEPS[at];
    head.textContent = title;
    text.textContent = words;
    count.textContent = `${at + 1} of ${STEPS.length}`;
    back.disabled = at === 0;
    const last = at === STEPS.length - 1;
    next.textContent = last ? "Done" : onward ?? "Next";
    practise.hidden = !(skip.hidden = last);
    if (scene) emit("scene", { value: scene });
    if (suggests) emit("suggest");
    place(dialog, mark(where));
  };
  const stop = listenUntil("suggestion", ({ phase, head: found, lines = [], error, met, use = {} }) => {
    if (!STEPS[at].suggests) return;
    head.textContent = phase === "done" && met ? STEPS[at].found : STEPS[at].title;
    text.textContent = { running: "Searching …", failed: error, done: [`${found}.`, ...lines].join(" ") }[phase] ?? "";
    if (phase === "done" && !met && Object.keys(use).length) emit("set", use); // the best that there is
    place(dialog, mark(STEPS[at].where)); // the text is longer now
  });
  root.append(dialog);
  dialog.showModal();
  preferences.set("tour", "seen");
  emit("view", { value: "explore" });
  step(0);
}

// A function that marks the first element that matches a selector (null: none), and returns it.
function marker() {
  addMarkStyle();
  let marked = null;
  return (selector) => {
    marked?.classList.remove("toured");
    marked = selector && inPage(selector);
    marked?.classList.add("toured");
    marked?.scrollIntoView({ block: "nearest" });
    return marked;
  };
}

function place(dialog, marked) {
  const box = marked?.getBoundingClientRect();
  if (!box) return;
  const width = Math.min(340, innerWidth - 24);
  dialog.style.width = `${width}px`; // before its height is read
  const height = dialog.offsetHeight;
  const right = box.right + 12 + width < innerWidth;
  const left = right ? box.right + 12 : Math.max(12, box.left - width - 12);
  let top = Math.min(Math.max(12, box.top), innerHeight - height - 12);
  // No room beside it: below it, above it, or in the half of the screen in which it does not lie.
  if (!right && left + width > box.left) {
    const below = box.bottom + 12;
    const lowest = innerHeight - height - 12;
    if (below <= lowest) top = below;
    else if (box.top - 12 - height >= 12) top = box.top - 12 - height;
    else top = box.top + box.bottom < innerHeight ? lowest : 12;
  }
  Object.assign(dialog.style, { left: `${left}px`, top: `${top}px`, margin: "0" });
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
