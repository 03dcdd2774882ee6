// A measurement: the button that chooses its file, and the page as a place to drop it. The server checks the content.

import { button, choose, element, emit, listen } from "../shared/dom.js";

const PARTS = /[^]{1,1900}/g; // the server accepts no longer texts
const PER_MESSAGE = 20; // parts; the server accepts no longer messages

export function render({ model }) {
  const root = element("div", "choose");
  const field = element("input");
  Object.assign(field, { type: "file", hidden: true });
  field.dataset.measurement = "";
  field.addEventListener("change", () => {
    const [file] = field.files;
    if (file) send(model, file);
    field.value = ""; // so that the same file can be chosen again
  });
  const open = button("", "", () => field.click());
  open.append("+ CSV", element("span", "long", " measurement"));
  open.title = "Lay a measurement, or the CSV file of a code, over both solutions: choose a file, or drop it on the page";
  root.append(open, field);
  dropZone(root, (file) => {
    if (!root.checkVisibility()) emit("view", { value: "explore" }); // where it is drawn
    send(model, file);
  });
  listen("choose-measurement", () => field.click());
  return root;
}

async function send(model, file) {
  model.send_msg({ file: { name: file.name, size: file.size } });
  if (file.size > model.largest) return; // the server says so
  const bytes = new Uint8Array(await file.arrayBuffer()); // a character each: the server knows encodings and gzip
  const parts = Array.from(bytes, (byte) => String.fromCharCode(byte)).join("").match(PARTS) ?? [];
  for (let i = 0; i < parts.length; i += PER_MESSAGE) {
    model.send_msg({ part: Object.fromEntries(parts.slice(i, i + PER_MESSAGE).map((part, k) => [String(k), part])) });
  }
  model.send_msg({ end: true });
}

// A file that is dragged over the page is announced, and taken when it is dropped anywhere.
function dropZone(root, take) {
  const sign = element("div", "drop", "Drop the CSV file: it is laid over both solutions");
  sign.hidden = true;
  root.append(sign);
  const holdsFile = (event) => event.dataTransfer?.types.includes("Files");
  let leaving = 0;
  document.addEventListener("dragover", (event) => {
    if (!holdsFile(event)) return;
    event.preventDefault();
    clearTimeout(leaving);
    sign.hidden = false;
    leaving = setTimeout(() => { sign.hidden = true; }, 400); // while a file is over the page, this event keeps coming
  });
  document.addEventListener("drop", (event) => {
    if (!holdsFile(event)) return;
    event.preventDefault();
    sign.hidden = true;
    const [file] = event.dataTransfer.files;
    if (file) take(file);
  });
}
