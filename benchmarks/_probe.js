// Records input events and painted states of a page, in its own clock.
//
// A move begins with the time stamp of a trusted input event. It ends with the frame in which the last of the watched
// figures painted the new state, which is read from the data that the figure was painted with. Bokeh paints within an
// animation frame, and a message posted there arrives when that frame is over.

window.probe = {
  inputs: [], // {type, at}
  messages: [], // {bytes, at} from the server
  painted: [], // {state, at}: from then on all watched figures show this state
  repaints: 0, // of a watched figure's curves
  first: 0, // when the first figure was there, since the page was asked for
  waiting: null,

  watch(figures, what) {
    const seen = new Map();
    let last = this.states[what]();
    for (const name of figures) {
      const view = Bokeh.index.find_one_by_id(this.model(name).id);
      view.plainPaint ??= view._actual_paint;
      view._actual_paint = () => {
        view.plainPaint();
        seen.set(name, this.states[what]());
        this.repaints += 1;
        if (seen.size < figures.length || new Set(seen.values()).size > 1 || seen.get(name) === last) return;
        last = seen.get(name);
        const state = last;
        afterThisFrame(() => this.show(state));
      };
    }
    this.inputs = [];
    this.painted = [];
  },

  // The line at the pointer is no part of a painted figure: the browser shows it with the frame after its move.
  watchLine() {
    const view = Bokeh.index.find_one_by_id(this.model("displacement").id);
    const line = view.canvas_view.overlays_el.querySelector("[data-mark=now-displacement]");
    const seen = () => requestAnimationFrame(() => afterThisFrame(() => this.show(line.dataset.x)));
    new MutationObserver(seen).observe(line, { attributeFilter: ["style"] });
    this.inputs = [];
    this.painted = [];
  },

  show(state) {
    this.painted.push({ state, at: performance.now() });
    this.waiting?.();
  },

  // Resolves once so many states have been painted.
  until(count) {
    return new Promise((done) => {
      this.waiting = () => { if (this.painted.length >= count) done(); };
      this.waiting();
    });
  },

  model: (name) => Bokeh.documents[0].get_model_by_name(name),
  column(source, column) {
    const { data } = this.model(source);
    return data instanceof Map ? data.get(column) : data[column];
  },
  states: {
    eta: () => probe.column("section_reference", "eta")[0],
  },
};

function afterThisFrame(act) {
  const { port1, port2 } = new MessageChannel();
  port1.onmessage = act;
  port2.postMessage(0);
}

for (const type of ["keydown", "pointermove", "pointerup"]) {
  const heard = (event) => { if (event.isTrusted) probe.inputs.push({ type, at: event.timeStamp }); };
  addEventListener(type, heard, true);
}

const Plain = WebSocket;
window.WebSocket = class extends Plain {
  constructor(...all) {
    super(...all);
    this.addEventListener("message", ({ data }) => {
      probe.messages.push({ bytes: data.length ?? data.byteLength ?? data.size, at: performance.now() });
    });
  }
};

const looking = setInterval(() => {
  const figure = window.Bokeh?.documents?.[0]?.get_model_by_name("phase1");
  if (!figure || !probe.column("phase_reference", "x1").length) return;
  if (!Bokeh.index.find_one_by_id(figure.id)?.has_finished()) return;
  probe.first = performance.now();
  clearInterval(looking);
}, 2);
