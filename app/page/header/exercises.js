// Three exercises: predict what a change of one number does, try it, and see. The answer is read from the page.

import { button, element, emit, inPage, labelled, listen, listenUntil } from "../shared/dom.js";

const EXERCISES = [
  { title: "A damper that fits", scene: "9B", change: { D: "5" },
    question: "For this K the damper is so strong that nothing rebounds. D becomes 5, a tenth of it. What becomes of the difference from the exact motion?",
    reason: "K and D have to fit each other: an overdamped contact creeps apart where the bodies should rebound, and the motion "
      + "is another one. What is left then comes from elsewhere, and the bars say from where." },
  { title: "A smaller step", scene: "14A", change: { steps: "8000" },
    question: "The marks of the penalty model lie in a cloud: it is blurred. The time step becomes a quarter of what it is. What becomes of the difference?",
    reason: "A constant step finds each contact late by a part of a step, differently each time. That blur is no motion "
      + "of the model, and goes with the step." },
  { title: "Stiffer is better?", scene: "10B", start: { steps: "500" }, change: { K: "50000", D: "45" },
    question: "A step of T/500. The contact becomes 25 times stiffer, with a damper to match. What becomes of the difference?",
    reason: "A stiff contact is short. When it lasts a few steps only, the time step does more harm than the stiffness does "
      + "good: K, D and the step must be chosen together." },
];
const CHOICES = [
  ["smaller", "it becomes less than half", (ratio) => ratio < 0.5],
  ["same", "it stays about as it is", (ratio) => ratio >= 0.5 && ratio <= 2],
  ["larger", "it more than doubles", (ratio) => ratio > 2],
];

// The difference that the page shows now, and a way to wait for the next one that is complete.
const difference = { now: null, waiting: null };
listen("findings", (content) => {
  const known = content.pending !== true && content.headline !== undefined;
  const [, , , total = null, text] = content.bars?.[0] ?? [];
  difference.now = known ? { total, text, headline: content.headline } : null;
  if (known && difference.waiting && !difference.moving) difference.waiting(difference.now);
});
listen("moving", ({ value }) => { difference.moving = value; });

function nextDifference(act) {
  return new Promise((done) => {
    emit("report-findings"); // they may have come before this component
    act();
    difference.waiting = (found) => { difference.waiting = null; done(found); };
    // Figures and findings change before the move is answered, and findings that stay the same are not sent again.
    const check = listenUntil("moving", ({ value }) => {
      if (value) return;
      check();
      if (difference.now) difference.waiting?.(difference.now);
    });
  });
}

const inWords = ({ total, text, headline }) => (total === null ? headline : `a difference of ${text}`);

export function exercises(root) {
  root.querySelector("dialog.exercise")?.close();
  const dialog = element("dialog", "exercise", "", { "aria-label": "Exercise" });
  const head = element("h2");
  const text = element("p");
  const choices = element("fieldset");
  const seen = element("p", "seen", "", { "aria-live": "polite" });
  const count = element("span", "count");
  let at = 0;
  const attempt = button("Try it", "Make the change, and see", () => see());
  const next = button("Next", "", () => (at + 1 < EXERCISES.length ? begin(at + 1) : dialog.close()));
  const row = element("div", "row", [count, button("Close", "Close the exercises", () => dialog.close()), attempt, next]);
  dialog.append(head, text, choices, seen, row);
  dialog.addEventListener("close", () => { difference.waiting = null; dialog.remove(); });
  let before = null;
  const begin = async (to) => {
    at = to;
    const { title, question, scene, start } = EXERCISES[at];
    head.textContent = `Exercise ${at + 1}: ${title}`;
    text.textContent = question;
    count.textContent = `${at + 1} of ${EXERCISES.length}`;
    seen.textContent = "";
    next.textContent = at + 1 < EXERCISES.length ? "Next" : "Done";
    attempt.disabled = next.disabled = true;
    choices.disabled = false;
    choices.replaceChildren(element("legend", "", "Predict"), ...CHOICES.map(([value, words]) =>
      labelled(element("span", "", words), { type: "radio", name: "vibroscope-prediction", value })[1]));
    before = await nextDifference(() => {
      emit("scene", { value: scene });
      if (start) emit("set", start);
    });
    seen.textContent = `Now: ${inWords(before)}.`;
    enable();
  };
  const predicted = () => choices.querySelector("input:checked")?.value;
  const enable = () => { attempt.disabled = !(predicted() && before) || choices.disabled; };
  choices.addEventListener("change", enable);
  const see = async () => {
    attempt.disabled = choices.disabled = true;
    const { change, reason } = EXERCISES[at];
    const first = before;
    seen.textContent = "Computing …";
    inPage(".findings")?.scrollIntoView({ block: "nearest" });
    const after = await nextDifference(() => emit("set", change));
    const [name, words] = CHOICES.find(([, , holds]) => holds((after.total ?? Infinity) / first.total));
    const right = name === predicted() ? "As you predicted" : "Other than you predicted";
    seen.textContent = `${right}: ${words}, from ${inWords(first)} to ${inWords(after)}. ${reason}`;
    next.disabled = false;
  };
  root.append(dialog);
  dialog.show(); // not modal: the page is there to be tried
  emit("view", { value: "explore" });
  emit("cancel-suggestion"); // that of the tour would set other numbers in the middle of an exercise
  begin(0);
}
