// Shared by the components of the page. They set textContent only, so that no text can become markup.

function element(tag, className = "", text = "") {
  const made = document.createElement(tag);
  if (className) made.className = className;
  if (text) made.textContent = text;
  return made;
}

function svgElement(tag, attributes = {}, text = "") {
  const made = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  if (text) made.textContent = text;
  return made;
}

function button(text, name, act, className = "") {
  const made = element("button", className, text);
  made.type = "button";
  if (name) {
    made.title = name;
    // Users of voice control say the text on the button, so the accessible name must contain it.
    made.setAttribute("aria-label", name.includes(text) ? name : `${text}: ${name}`);
  }
  made.addEventListener("click", act);
  return made;
}

// Each component lies in a shadow root of its own, so components exchange events through the document.
const emit = (name, detail = {}) => document.dispatchEvent(new CustomEvent(`vibroscope:${name}`, { detail }));
const listen = (name, act) => document.addEventListener(`vibroscope:${name}`, (event) => act(event.detail));

// Like `listen`, until the function that it returns is called.
const listenUntil = (name, act) => {
  const heard = (event) => act(event.detail);
  document.addEventListener(`vibroscope:${name}`, heard);
  return () => document.removeEventListener(`vibroscope:${name}`, heard);
};

// Preferences that this browser keeps; a browser may forbid storage, and then they are not kept.
const preferences = {
  get: (name) => {
    try { return localStorage.getItem(`vibroscope-${name}`); } catch { return null; }
  },
  set: (name, value) => {
    try { localStorage.setItem(`vibroscope-${name}`, value); } catch { /* not kept */ }
  },
};

// A function that calls `act` once for all its calls in the present task.
const oncePerTask = (act) => {
  let due = false;
  return () => {
    if (!due) queueMicrotask(() => { due = false; act(); });
    due = true;
  };
};

// Shows a cue at the lower edge of a box that scrolls, as long as there is more below (`scroll_cue.css`). The box is
// ``content`` itself, or else the host of its component.
function cueScroll(content, itself = false) {
  const cue = element("div", "cue", "▾ more");
  cue.ariaHidden = "true";
  content.append(cue);
  let box = null;
  const draw = () => box.toggleAttribute("data-more", box.scrollHeight - box.scrollTop - box.clientHeight > 12);
  const sizes = new ResizeObserver(() => {
    if (!box) {
      box = itself ? content : content.getRootNode().host;
      box.addEventListener("scroll", draw, { passive: true });
      sizes.observe(box);
    }
    draw();
  });
  for (const each of [content, ...content.children]) sizes.observe(each);
}

// Models and views of Bokeh by name; null while there are none. Bokeh itself searches all models at each call.
const modelCache = new Map();
const modelOf = (name) => {
  const doc = window.Bokeh?.documents[0];
  if (modelCache.get(name)?.document !== doc || !doc) {
    const model = doc?.get_model_by_name(name);
    if (!model) return null;
    modelCache.set(name, model);
  }
  return modelCache.get(name);
};
const viewOf = (name) => {
  const model = modelOf(name);
  return model ? Bokeh.index.find_one_by_id(model.id) : null;
};
// Option of changes that are not sent to the server.
const LOCAL = { sync: false };
// Columns of a source; Bokeh keeps them as a Map or as an object.
const asObject = (data) => (data instanceof Map ? Object.fromEntries(data) : data);
