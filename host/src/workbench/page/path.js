// The tool path on a canvas: stroked once into a bitmap that pan and zoom move; marker, trail and the
// live machine are drawn on top.

// Colour classes of speed, and points of the trail that are kept.
const CLASSES = 16, TRAIL = 5000;
// Pause after which a moved bitmap is stroked anew, ms; room around the view, px.
const REST = 80, MARGIN = 200;
// 5 floats a point: time s, X, Y, Z mm, word.
const WIDTH = 5;
const VIEWS = { top: [1, 2, 'X', 'Y'], front: [1, 3, 'X', 'Z'], side: [2, 3, 'Y', 'Z'] };

// From blue (slow) over green to red (fast), of the same lightness for both themes.
const colour = n => `hsl(${250 - 250 * n / (CLASSES - 1)} 80% 50%)`;

export class PathView {
  points = new Float32Array(0); words = new Uint32Array(0); count = 0; fastest = 0;
  view = 'top'; zoom = 1; x = 0; y = 0; marker = null; live = null; trail = []; machine = null; ghost = null; dim = false; homed = false;
  #due = null; #rest = null; #bitmap = null; #made = null; #moving = false; #kept = null;

  constructor(canvas) {
    this.canvas = canvas;
    this.paper = canvas.getContext('2d');
    new ResizeObserver(() => this.#resize()).observe(canvas);
    canvas.addEventListener('wheel', e => {
      e.preventDefault();
      this.#scale(Math.exp(-e.deltaY / 500), e.offsetX, e.offsetY);
    }, { passive: false });
    const down = new Map();
    canvas.addEventListener('pointerdown', e => {
      canvas.setPointerCapture(e.pointerId);
      down.set(e.pointerId, e);
    });
    canvas.addEventListener('pointermove', e => this.#drag(down, e));
    for (const name of ['pointerup', 'pointercancel']) {
      canvas.addEventListener(name, e => down.delete(e.pointerId));
    }
    canvas.addEventListener('dblclick', () => this.fit());
    canvas.addEventListener('keydown', e => this.#key(e));
    matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => this.#stale());
  }
  // A new path: see `Trial::path` of the tool.
  set(buffer) {
    this.points = new Float32Array(buffer, 4);
    this.words = new Uint32Array(buffer, 4);
    this.count = this.points.length / WIDTH;
    this.#speeds();
    if (!this.#moving) this.fit(); else this.#stale();
  }
  // Speed class of each point: that of the way to it.
  #speeds() {
    const { points, words, count } = this;
    const speed = new Float32Array(count);
    let most = 0;
    for (let i = 1; i < count; i++) {
      if (words[i * WIDTH + 4] >>> 28 & 1) continue;
      const a = (i - 1) * WIDTH, b = i * WIDTH;
      const way = Math.hypot(points[b + 1] - points[a + 1], points[b + 2] - points[a + 2], points[b + 3] - points[a + 3]);
      const time = points[b] - points[a];
      speed[i] = time > 0 ? way / time : 0;
      if (speed[i] > most) most = speed[i];
    }
    this.fastest = most;
    this.classes = Uint8Array.from(speed, v => Math.min(CLASSES - 1, Math.floor(v / (most || 1) * CLASSES)));
  }
  // One Path2D for each class, in mm; null: all in one.
  #lines(each = true, of = this) {
    const [a, b] = VIEWS[this.view], { points, words, count, classes } = of;
    const paths = Array.from({ length: each === null ? 1 : CLASSES }, () => new Path2D());
    let last = -1, home = false;
    for (let i = 0; i < count; i++) {
      const at = i * WIDTH, word = words[at + 4];
      if (word >>> 28 & 1) { last = -1; home = word >>> 29 & 1; continue; }
      if (home) continue; // where a reference run begins is not known before
      const path = paths[each === null ? 0 : classes[i]];
      if (last !== (each === null ? 0 : classes[i])) path.moveTo(points[at - WIDTH + a], -points[at - WIDTH + b]);
      path.lineTo(points[at + a], -points[at + b]);
      last = each === null ? 0 : classes[i];
    }
    return paths;
  }
  look(view) {
    this.view = view;
    this.ghost = this.#kept && this.#lines(null, this.#kept);
    this.fit();
  }
  // Keeps the present path below those that come, or lets it go.
  hold(on) {
    const { points, words, count, classes } = this;
    this.#kept = on ? { points, words, count, classes } : null;
    this.look(this.view);
  }
  // The whole path in sight, or the machine's travel where there is none.
  fit() {
    const [a, b] = VIEWS[this.view], { points, words, count } = this;
    let [x0, y0, x1, y1] = [Infinity, Infinity, -Infinity, -Infinity], home = false;
    for (let i = 0; i < count; i++) {
      const at = i * WIDTH;
      if (words[at + 4] >>> 28 & 1) home = words[at + 4] >>> 29 & 1;
      if (home) continue;
      x0 = Math.min(x0, points[at + a]); x1 = Math.max(x1, points[at + a]);
      y0 = Math.min(y0, points[at + b]); y1 = Math.max(y1, points[at + b]);
    }
    if (!(x1 > x0 || y1 > y0)) {
      const [u, v] = this.#travel();
      [x0, x1, y0, y1] = [u[0], u[1], v[0], v[1]];
    }
    const { width, height } = this.#size();
    if (!width) return;
    this.#moving = false;
    this.zoom = Math.min((width - 80) / Math.max(x1 - x0, 1), (height - 80) / Math.max(y1 - y0, 1), 400);
    this.x = width / 2 - (x0 + x1) / 2 * this.zoom;
    this.y = height / 2 + (y0 + y1) / 2 * this.zoom;
    this.#stale();
  }
  #travel() {
    const range = letter => {
      const axis = this.machine?.axes.find(own => own.axis === letter);
      return axis ? [axis.low, axis.high] : [0, 100];
    };
    const [, , u, v] = VIEWS[this.view];
    return [range(u), range(v)];
  }
  // A bar at each end of the travel where an axis in sight has its reference switch.
  #switches(paper, thin) {
    const [, , u, v] = VIEWS[this.view], [across, up] = this.#travel(), found = [];
    paper.lineWidth = 3 * thin;
    paper.beginPath();
    for (const axis of this.machine?.axes ?? []) {
      if (!axis.switch) continue;
      const end = axis.home_low ? 0 : 1;
      if (axis.axis === u) { paper.moveTo(across[end], -up[0]); paper.lineTo(across[end], -up[1]); }
      if (axis.axis === v) { paper.moveTo(across[0], -up[end]); paper.lineTo(across[1], -up[end]); }
      found.push(`${axis.axis} ${axis.home_low ? 'lower' : 'upper'} end`);
    }
    paper.stroke();
    this.canvas.ariaLabel = `Tool path, coloured by speed. Reference switches: ${found.join(', ') || 'none'}. Arrow keys move it, plus and minus zoom, 0 shows all.`;
  }
  #size() { return { width: this.canvas.clientWidth, height: this.canvas.clientHeight }; }
  #resize() {
    const ratio = devicePixelRatio || 1, { width, height } = this.#size();
    if (!width) return;
    this.canvas.width = Math.round(width * ratio);
    this.canvas.height = Math.round(height * ratio);
    if (this.#moving) this.#stale(); else this.fit();
  }
  #scale(by, x, y) {
    const zoom = Math.max(0.01, Math.min(2000, this.zoom * by));
    by = zoom / this.zoom;
    this.zoom = zoom;
    this.x = x - (x - this.x) * by;
    this.y = y - (y - this.y) * by;
    this.#moved();
  }
  #drag(down, e) {
    const before = down.get(e.pointerId);
    if (!before) return;
    const other = [...down.values()].find(own => own.pointerId !== e.pointerId);
    if (other) {
      const far = p => Math.hypot(p.offsetX - other.offsetX, p.offsetY - other.offsetY) || 1;
      this.#scale(far(e) / far(before), other.offsetX, other.offsetY);
    } else {
      this.x += e.offsetX - before.offsetX;
      this.y += e.offsetY - before.offsetY;
      this.#moved();
    }
    down.set(e.pointerId, e);
  }
  #key(e) {
    const { width, height } = this.#size();
    const way = { ArrowLeft: [40, 0], ArrowRight: [-40, 0], ArrowUp: [0, 40], ArrowDown: [0, -40] }[e.key];
    if (way) { this.x += way[0]; this.y += way[1]; this.#moved(); }
    else if (e.key === '+' || e.key === '-') this.#scale(e.key === '+' ? 1.25 : 0.8, width / 2, height / 2);
    else if (e.key === '0') this.fit();
    else return;
    e.preventDefault();
  }
  #moved() {
    this.#moving = true; // from now on the user says what is in sight
    clearTimeout(this.#rest);
    this.#rest = setTimeout(() => this.#stale(), REST);
    this.draw();
  }
  #stale() { this.#made = null; this.draw(); }
  draw() { this.#due ??= requestAnimationFrame(() => { this.#due = null; this.#paint(); }); }

  // The slow part: grid, travel and path into a bitmap somewhat larger than the view.
  #stroke() {
    const ratio = devicePixelRatio || 1, { width, height } = this.#size();
    const style = getComputedStyle(this.canvas);
    const bitmap = new OffscreenCanvas((width + 2 * MARGIN) * ratio, (height + 2 * MARGIN) * ratio);
    const paper = bitmap.getContext('2d');
    paper.scale(ratio, ratio);
    paper.translate(this.x + MARGIN, this.y + MARGIN);
    paper.scale(this.zoom, this.zoom);
    const thin = 1 / this.zoom;
    const step = 10 ** Math.ceil(Math.log10(30 / this.zoom));
    paper.lineWidth = thin;
    paper.strokeStyle = style.getPropertyValue('--grid');
    const left = -(this.x + MARGIN) / this.zoom, top = -(this.y + MARGIN) / this.zoom;
    const right = left + (width + 2 * MARGIN) / this.zoom, bottom = top + (height + 2 * MARGIN) / this.zoom;
    paper.beginPath();
    for (let x = Math.ceil(left / step) * step; x < right; x += step) { paper.moveTo(x, top); paper.lineTo(x, bottom); }
    for (let y = Math.ceil(top / step) * step; y < bottom; y += step) { paper.moveTo(left, y); paper.lineTo(right, y); }
    paper.stroke();
    const [u, v] = this.#travel();
    paper.strokeStyle = style.getPropertyValue('--soft');
    paper.setLineDash([6 * thin, 4 * thin]);
    paper.strokeRect(u[0], -v[1], u[1] - u[0], v[1] - v[0]);
    paper.setLineDash([]);
    this.#switches(paper, thin);
    paper.lineWidth = 1.5 * thin;
    if (this.ghost) {
      paper.strokeStyle = style.getPropertyValue('--ghost');
      this.ghost.forEach(path => paper.stroke(path));
    }
    this.#lines().forEach((path, n) => {
      paper.strokeStyle = colour(n);
      paper.stroke(path);
    });
    this.#bitmap = bitmap;
    this.#made = { zoom: this.zoom, x: this.x, y: this.y };
    this.step = step;
  }
  #paint() {
    const ratio = devicePixelRatio || 1, { width, height } = this.#size();
    if (!width || !height) return;
    if (!this.#made) this.#stroke();
    const { paper } = this, made = this.#made, by = this.zoom / made.zoom;
    paper.setTransform(ratio, 0, 0, ratio, 0, 0);
    paper.clearRect(0, 0, width, height);
    // The path of another text is dimmed, never the machine.
    paper.globalAlpha = this.dim ? .35 : 1;
    paper.drawImage(this.#bitmap, this.x - (made.x + MARGIN) * by, this.y - (made.y + MARGIN) * by,
      (width + 2 * MARGIN) * by, (height + 2 * MARGIN) * by);
    paper.globalAlpha = 1;
    const style = getComputedStyle(this.canvas), [a, b] = VIEWS[this.view];
    const at = place => [this.x + place[a - 1] * this.zoom, this.y - place[b - 1] * this.zoom];
    if (this.trail.length > 1) {
      paper.strokeStyle = style.getPropertyValue('--trail');
      paper.lineWidth = 3;
      paper.lineJoin = 'round';
      paper.beginPath();
      this.trail.forEach((place, n) => paper[n ? 'lineTo' : 'moveTo'](...at(place)));
      paper.stroke();
    }
    const mark = (place, name, size) => {
      const [x, y] = at(place);
      paper.fillStyle = style.getPropertyValue(name);
      paper.beginPath();
      paper.arc(x, y, size, 0, 7);
      paper.fill();
    };
    if (this.marker) mark(this.marker, '--text', 5);
    if (this.live) {
      // Filled where its place is known; hollow before the axes are homed.
      if (this.homed) mark(this.live, '--live', 7);
      else {
        paper.strokeStyle = style.getPropertyValue('--live');
        paper.lineWidth = 2;
        paper.beginPath();
        paper.arc(...at(this.live), 7, 0, 7);
        paper.stroke();
      }
    }
    paper.fillStyle = style.getPropertyValue('--soft');
    paper.font = '12px sans-serif';
    const [, , u, v] = VIEWS[this.view];
    paper.fillText(`${u} → ${v} ↑ grid ${this.step} mm`, 8, height - 8);
  }
  // The machine itself, as the board tells it; `homed`: its place is known. The trail has no place from
  // before that: it would be of another frame.
  follow(place, runs, homed) {
    if (homed !== this.homed) this.trail = [];
    this.homed = homed;
    const last = this.trail.at(-1);
    if (runs && homed && (!last || Math.hypot(...place.map((p, n) => p - last[n])) > 0.01)) {
      this.trail.push(place);
      if (this.trail.length > TRAIL) this.trail.splice(0, 1000);
    }
    this.live = place;
    this.draw();
  }
  // Place and line at a time in s.
  at(time) {
    const { points, words, count } = this;
    let lo = 0, hi = count - 1;
    if (count === 0) return null;
    while (lo < hi) { const m = (lo + hi + 1) >> 1; if (points[m * WIDTH] <= time) lo = m; else hi = m - 1; }
    const a = lo * WIDTH, b = Math.min(lo + 1, count - 1) * WIDTH;
    const part = points[b] > points[a] ? Math.min(1, Math.max(0, (time - points[a]) / (points[b] - points[a]))) : 0;
    const place = [1, 2, 3].map(n => points[a + n] + (points[b + n] - points[a + n]) * part);
    return { place, line: words[a + 4] & 0xffffff, speed: this.classes[b / WIDTH] / CLASSES * this.fastest };
  }
}
