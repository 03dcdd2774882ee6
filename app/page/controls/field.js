// Fields of the panel, which sliders, system and solver have in common.

import { element, say } from "../shared/dom.js";

export function input(type, id, name) {
  return element("input", "", "", { "aria-label": name, type, id });
}

// Why a number or a choice was refused, below it.
export function refusalOf(name) {
  const line = element("p", "refusal", "", { role: "alert", id: `vibroscope-${name}-refusal` });
  line.hidden = true;
  const draw = (shown, described, more = "") => {
    const refused = shown.refused.name === name;
    say(line, refused && shown.refused.text + more);
    if (refused) described.setAttribute("aria-describedby", line.id);
    else described.removeAttribute("aria-describedby");
    return refused;
  };
  return { element: line, draw };
}

const SHORT = 8; // digits that each field has room for

// The field of a typed value, with the reason if it was refused.
export function typedField(number, link, place) {
  const typed = input("text", `vibroscope-${number.name}-typed`, `${number.label}: ${number.hint}, typed`);
  Object.assign(typed, { inputMode: "decimal", autocomplete: "off" });
  const refusal = refusalOf(number.name);
  const unit = element("span", "unit");
  let accepted = ""; // in the numbers of the model
  let field = { text: "", factor: 1 }; // the same as it is shown
  let typing = false; // an answer must not change what is being typed
  const fill = (text) => {
    typed.value = text;
    typed.style.minWidth = text.length > SHORT ? `calc(${text.length}ch + 16px)` : ""; // or its exponent could be hidden
  };
  typed.addEventListener("input", () => { typing = true; });
  typed.addEventListener("change", () => {
    typing = false;
    link.set({ [number.name]: { typed: typed.value.trim() } }); // the server reads separators and units
  });
  typed.addEventListener("blur", () => {
    if (typing) fill(field.text); // the text equals the one before, since there was no change event
    typing = false;
  });
  typed.addEventListener("keydown", (event) => {
    if (event.key !== "Escape") return;
    typing = false;
    fill(field.text);
    link.set({ [number.name]: accepted });
  });
  place.append(refusal.element);
  const draw = (shown, isLatest) => {
    accepted = shown.texts[number.name];
    field = shown.fields[number.name];
    unit.textContent = field.unit;
    typed.disabled = Boolean(field.locked);
    typed.title = `${field.name}; ${field.locked || field.range}`;
    typed.setAttribute("aria-label", `${field.label}: ${field.name}, typed`);
    const refused = refusal.draw(shown, typed, ` Escape brings back ${field.text}.`);
    typed.setAttribute("aria-invalid", String(refused));
    if (isLatest && !refused && !typing) fill(field.text);
  };
  // A number of the model as the field shows it, until the server has answered.
  const preview = (text) => (field.factor === 1 ? text : String(Number((field.factor * Number(text)).toPrecision(6))));
  return { typed, unit, draw, preview, fill };
}
