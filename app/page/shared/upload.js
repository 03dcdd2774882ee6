// A file for the server: the button that chooses it, and the page as a place to drop it. The server checks the content.

import { element, emit, fileField } from "./dom.js";

const PARTS = /[^]{1,1900}/g; // the server accepts no longer texts
const PER_MESSAGE = 20; // parts; the server accepts no longer messages

// A box with a button that chooses a file of at most `largest` bytes. A file that is dropped goes to the box that can be
// seen, else to the first one, after `show`; parameters go where "Parameters from a file" reads them.
export function chooser(model, open, { largest, drop, show }) {
  const take = (file) => sendFile(model, file, largest);
  const field = fileField(take);
  open.addEventListener("click", () => field.click());
  const sign = element("div", "drop", drop);
  sign.hidden = true;
  const root = element("div", "choose", [open, field, sign]);
  boxes.push({ root, sign, take, show });
  if (boxes.length === 1) watchDrops();
  return { root, field };
}

export async function sendFile(model, file, largest) {
  model.send_msg({ file: { name: file.name, size: file.size } });
  if (file.size > largest) return; // the server says so
  const bytes = new Uint8Array(await file.arrayBuffer()); // a character each: the server knows encodings and gzip
  const parts = Array.from(bytes, (byte) => String.fromCharCode(byte)).join("").match(PARTS) ?? [];
  for (let i = 0; i < parts.length; i += PER_MESSAGE) {
    model.send_msg({ part: Object.fromEntries(parts.slice(i, i + PER_MESSAGE).map((part, k) => [String(k), part])) });
  }
  model.send_msg({ end: true });
}

const boxes = [];
const seen = () => boxes.find(({ root }) => root.checkVisibility());

// A file that is dragged over the page is announced, and taken when it is dropped anywhere.
function watchDrops() {
  const holdsFile = (event) => event.dataTransfer?.types.includes("Files");
  const hide = () => boxes.forEach(({ sign }) => { sign.hidden = true; });
  let leaving = 0;
  document.addEventListener("dragover", (event) => {
    if (!holdsFile(event)) return;
    event.preventDefault();
    clearTimeout(leaving);
    (seen() ?? boxes[0]).sign.hidden = false;
    leaving = setTimeout(hide, 400); // while a file is over the page, this event keeps coming
  });
  document.addEventListener("drop", (event) => {
    if (!holdsFile(event)) return;
    event.preventDefault();
    hide();
    const [file] = event.dataTransfer.files;
    if (/\.toml$/i.test(file?.name)) { emit("load-parameters", { file }); return; } // of a system, or of the page
    const box = seen() ?? boxes[0];
    if (!seen()) box.show?.();
    if (file) box.take(file);
  });
}
