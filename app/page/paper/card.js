// One claim of the paper: its sentence, the verdict, what was found, and a button to its setting. The card informs the
// server when it comes into view, where the claim is then checked; in a hidden tab it never does. Only textContent is
// set, so that no text can become markup.

import { button, drawCard, element, emit, say, whenever } from "../shared/dom.js";

const MARKS = { agrees: "✓ agrees", differs: "≠ differs", "shown by example": "○ shown by example" };
const AGREES = { agrees: "true", differs: "false", "shown by example": "example" };

export function render({ model }) {
  const { name, place, text, title } = model.claim;
  const verdict = element("strong", "verdict");
  const heading = element("h3", "", [name, element("small", "", place)]);
  const head = element("header", "", [heading, verdict]);
  const found = element("p", "found");
  const why = element("p", "why");
  const open = button(`Open in ${title}`, `Open the setting of ${name} in ${title}`, () => show(model.claim));
  // While the check runs it cancels; once it is cancelled it begins the check.
  const check = button("Cancel", `Cancel the check of ${name}`, () => {
    model.send_msg(model.found.cancelled ? { seen: true } : { cancel: true });
  }, "check");
  const root = element("article", "claim", [head, element("p", "says", text), found, check, why, open]);
  const draw = () => {
    const { verdict: said, error, cancelled } = model.found;
    const known = said !== undefined;
    root.dataset.agrees = AGREES[said] ?? "";
    verdict.textContent = MARKS[said] ?? "";
    found.textContent = error ?? model.found.found ?? (cancelled ? "Not checked: cancelled." : "computing …");
    check.hidden = known || Boolean(error);
    check.textContent = cancelled ? "Check" : "Cancel";
    check.setAttribute("aria-label", `${cancelled ? "Check" : "Cancel the check of"} ${name}`);
    say(why, model.found.why);
    root.setAttribute("aria-busy", String(!known && !error && !cancelled));
  };
  drawCard(root, model, "found", draw);
  // Until the page is laid out, all cards lie in view.
  whenever(() => window.Bokeh?.documents[0]?.is_idle, () => whenSeen(root, () => model.send_msg({ seen: true })));
  return root;
}

function show({ scene, view }) {
  emit("scene", { value: scene });
  emit("view", { value: view });
}

function whenSeen(node, act) {
  const watch = new IntersectionObserver((entries) => {
    if (!entries.some((entry) => entry.isIntersecting)) return;
    watch.disconnect();
    act();
  }, { rootMargin: "120px" });
  watch.observe(node);
}
