// What the page's components share. Only textContent is ever set: no text can become markup.

function element(tag, className = "", text = "") {
  const made = document.createElement(tag);
  if (className) made.className = className;
  if (text) made.textContent = text;
  return made;
}

function button(text, name, act, className = "") {
  const made = element("button", className, text);
  made.type = "button";
  if (name) {
    made.title = name;
    // Who speaks to the page says what stands on the button.
    made.setAttribute("aria-label", name.includes(text) ? name : `${text}: ${name}`);
  }
  made.addEventListener("click", act);
  return made;
}

// Components talk through the document, since each lies in a shadow root of its own.
const say = (what, detail = {}) => document.dispatchEvent(new CustomEvent(`vibroscope:${what}`, { detail }));
const hear = (what, act) => document.addEventListener(`vibroscope:${what}`, (event) => act(event.detail));

// What this browser remembers of its user; a browser that forbids it forgets.
const memory = {
  get: (name) => {
    try { return localStorage.getItem(`vibroscope-${name}`); } catch { return null; }
  },
  set: (name, value) => {
    try { localStorage.setItem(`vibroscope-${name}`, value); } catch { /* forgets */ }
  },
};

// Does something once, however often it is called before the browser comes to it.
const once = (act) => {
  let due = false;
  return () => {
    if (!due) queueMicrotask(() => { due = false; act(); });
    due = true;
  };
};

// Bokeh's models and views of this page by name; null while they are not there. Bokeh itself looks through all models.
const known = new Map();
const modelOf = (name) => {
  const doc = window.Bokeh?.documents[0];
  if (!known.has(name) || known.get(name).document !== doc) {
    const model = doc?.get_model_by_name(name);
    if (!model) return null;
    known.set(name, model);
  }
  return known.get(name);
};
const viewOf = (name) => {
  const model = modelOf(name);
  return model ? Bokeh.index.find_one_by_id(model.id) : null;
};
// What the browser changes by itself is none of the server's business.
const HERE = { sync: false };
// Columns of a source, however Bokeh keeps them.
const asObject = (data) => (data instanceof Map ? Object.fromEntries(data) : data);
