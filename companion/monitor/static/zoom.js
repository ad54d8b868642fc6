// Which part of a drawing is seen? Wheel, pinch, double click and keys change how much; dragging
// moves it. A view is in shares of the whole drawing, whose shape it has; points are shares of what
// is seen.

const WHOLE = { left: 0, top: 0, width: 1 };
const NARROWEST = 1 / 16;
const STEP = 1.5;
const DOUBLE = 2;
const MOVE = 0.2;
const LINE_PX = 16; // of a wheel that counts lines
const PER_PX = { wheel: 0.002, pinch: 0.01 }; // a pinch on a touchpad is a wheel with ctrl
const CENTRE = [0.5, 0.5];

const clamp = (value, low, high) => Math.min(Math.max(value, low), high);
const within = ({ left, top, width }) => ({
  left: clamp(left, 0, 1 - width), top: clamp(top, 0, 1 - width), width,
});

// As many times as large; the point stays where it is on the screen.
function zoomed({ left, top, width }, factor, [x, y]) {
  const after = clamp(width / factor, NARROWEST, 1);
  const gone = width - after;
  return within({ left: left + x * gone, top: top + y * gone, width: after });
}

function moved({ left, top, width }, x, y) {
  return within({ left: left - x * width, top: top - y * width, width });
}

export class Zoom {
  // `box` has the drawing and the button `whole`; `changed` is called after each change of `view`.
  constructor(box, whole, changed) {
    this.box = box;
    this.whole = whole;
    this.changed = changed;
    this.view = WHOLE;
    this.fingers = new Map();
    whole.onclick = () => { this.show(WHOLE); box.focus(); };
    box.onkeydown = (event) => this.key(event);
    box.ondblclick = (event) => event.target.closest("button") || this.zoom(event.shiftKey ? 1 / DOUBLE : DOUBLE, this.point(event));
    box.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
    box.onpointerdown = (event) => this.press(event);
    box.onpointermove = (event) => this.drag(event);
    box.onpointerup = box.onpointercancel = (event) => this.fingers.delete(event.pointerId);
  }

  // Called when somebody moves the view.
  touched() {}

  get isWhole() {
    return this.view.width === 1;
  }

  show(view) {
    this.view = view;
    this.whole.hidden = this.isWhole;
    this.box.toggleAttribute("data-zoomed", !this.isWhole);
    this.changed();
  }

  // Brings a point into the middle, by its share of the whole drawing.
  centre([x, y]) {
    const { left, top, width } = this.view;
    const view = within({ left: x - width / 2, top: y - width / 2, width });
    if (Math.hypot(view.left - left, view.top - top) > 1e-5) this.show(view);
  }

  zoom(factor, point = CENTRE) {
    this.show(zoomed(this.view, factor, point));
  }

  point({ clientX, clientY }) {
    const { left, top, width, height } = this.box.getBoundingClientRect();
    return [(clientX - left) / width, (clientY - top) / height];
  }

  // The whole drawing leaves to the page what cannot make it smaller.
  wheel(event) {
    if (this.isWhole && event.deltaY >= 0) return;
    event.preventDefault();
    const px = event.deltaY * (event.deltaMode ? LINE_PX : 1);
    this.zoom(Math.exp(-px * (event.ctrlKey ? PER_PX.pinch : PER_PX.wheel)), this.point(event));
  }

  // While the focus is in the box; the arrows are the time's while there is nothing to move.
  key(event) {
    if (event.ctrlKey || event.altKey || event.metaKey || event.target.closest("button")) return;
    const move = (x, y) => (this.isWhole ? null : () => { this.touched(); this.show(moved(this.view, x, y)); });
    const actions = {
      "+": () => this.zoom(STEP), "=": () => this.zoom(STEP), "-": () => this.zoom(1 / STEP),
      0: () => this.show(WHOLE),
      ArrowLeft: move(MOVE, 0), ArrowRight: move(-MOVE, 0),
      ArrowUp: move(0, MOVE), ArrowDown: move(0, -MOVE),
    };
    if (!actions[event.key]) return;
    event.preventDefault();
    event.stopPropagation();
    actions[event.key]();
  }

  press(event) {
    if (event.button !== 0 || event.target.closest("button")) return;
    this.box.setPointerCapture(event.pointerId);
    this.fingers.set(event.pointerId, this.point(event));
  }

  drag(event) {
    if (!this.fingers.has(event.pointerId)) return;
    const before = this.grip();
    this.fingers.set(event.pointerId, this.point(event));
    const after = this.grip();
    const [x, y] = after.middle.map((share, i) => share - before.middle[i]);
    if (x || y) this.touched();
    this.show(moved(zoomed(this.view, after.spread / before.spread, before.middle), x, y));
  }

  // Where the fingers are, and how far apart; one has no spread.
  grip() {
    const [first, second = first] = this.fingers.values();
    const { width, height } = this.box.getBoundingClientRect();
    return {
      middle: first.map((share, i) => (share + second[i]) / 2),
      spread: Math.hypot((first[0] - second[0]) * width, (first[1] - second[1]) * height) || 1,
    };
  }
}
