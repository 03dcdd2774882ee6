// Three lines of words, an error banner and a link. Only textContent is ever set.

const TITLES = {
  reference: "Reference (exact impacts)",
  penalty: "Penalty (Newmark)",
  verdict: "Do they agree?",
};

export function render({ model }) {
  const root = document.createElement("div");
  root.className = "told";
  const lines = Object.entries(TITLES).map(([name, title]) => line(root, name, title));
  const error = document.createElement("div");
  error.className = "error";
  error.setAttribute("role", "alert");
  root.append(error, speed());
  const draw = () => {
    lines.forEach((show) => show(model.told));
    error.textContent = model.error;
    error.hidden = !model.error;
  };
  model.on("told", draw);
  model.on("error", draw);
  draw();
  return root;
}

function line(root, name, title) {
  const box = document.createElement("section");
  box.className = `line ${name}`;
  const head = document.createElement("h2");
  head.textContent = title;
  const text = document.createElement("p");
  text.setAttribute("aria-live", "polite");
  box.append(head, text);
  root.append(box);
  return (told) => {
    text.textContent = told[name] ?? "computing …";
    box.dataset.agree = told.agree ?? "";
  };
}

// A figure of its own, served from assets/speed.
function speed() {
  const link = document.createElement("a");
  link.className = "speed";
  link.href = "speed/work-precision.svg";
  link.target = "_blank";
  link.rel = "noopener";
  link.textContent = "How fast, how exact";
  return link;
}
