// The tool path on a canvas: stroked once into a bitmap that pan and zoom move; the line of the caret, marker,
// trail and the live machine are drawn on top.
import { inks, lastOf, hear } from './dom.js';
import { WIDTH, CLASSES, classify, colour, extent, nearest, piecesOf, strokes } from './strokes.js';

const TRAIL = 5000;
// Pause after which a moved bitmap is stroked anew, ms; room around the view, px; how near a click must be, px.
const REST = 80, MARGIN = 200, NEAR = 8;
const TURNING = 20000;
const VIEWS = { top: ['X', 'Y'], front: ['X', 'Z'], side: ['Y', 'Z'], space: null };

const dark = () => matchMedia('(prefers-color-scheme: dark)').matches;

export class PathView {
	points = new Float32Array(0); words = new Uint32Array(0); count = 0; fastest = 0;
	view = 'top'; zoom = 1; x = 0; y = 0; marker = null; live = null; trail = []; machine = null; ghost = null; dim = false; homed = false; spots = []; taught = []; steady = false;
	// Turn and tilt of the view in space, radians; what a click on the path tells: time in s and line.
	turn = -0.6; tilt = 0.6; picked = null;
	#due = null; #rest = null; #bitmap = null; #made = null; #moving = false; #kept = null; #marked = null; #line = 0; #turning = false; #came = null;

	constructor(canvas) {
		this.canvas = canvas;
		this.paper = canvas.getContext('2d');
		new ResizeObserver(() => this.#resize()).observe(canvas);
		hear(canvas, 'wheel', e => {
			e.preventDefault();
			this.#scale(Math.exp(-e.deltaY / 500), e.offsetX, e.offsetY);
		}, { passive: false });
		const down = new Map();
		hear(canvas, 'pointerdown', e => {
			canvas.setPointerCapture(e.pointerId);
			down.set(e.pointerId, e);
			this.#came = e;
		});
		hear(canvas, 'pointermove', e => this.#drag(down, e));
		for (const name of ['pointerup', 'pointercancel']) {
			hear(canvas, name, e => {
				const still = this.#came && Math.hypot(e.offsetX - this.#came.offsetX, e.offsetY - this.#came.offsetY) < 4;
				if (name === 'pointerup' && still && down.size === 1) this.#pick(e.offsetX, e.offsetY);
				down.delete(e.pointerId);
				if (this.#turning) { this.#turning = false; this.#stale(); }
			});
		}
		hear(canvas, 'dblclick', () => this.fit());
		hear(canvas, 'keydown', e => this.#key(e));
		hear(matchMedia('(prefers-color-scheme: dark)'), 'change', () => this.#stale());
	}
	set(buffer) {
		this.points = new Float32Array(buffer, 4);
		this.words = new Uint32Array(buffer, 4);
		this.count = this.points.length / WIDTH;
		Object.assign(this, classify(this));
		this.box = extent(this);
		this.#marked = null;
		// A number that is dragged moves the path, not the paper.
		if (!this.#moving && !this.steady) this.fit(); else this.#stale();
	}
	// Two rows of three: across and up on the paper, of X, Y and Z. Where Z counts downward its numbers grow
	// downward here, too.
	get project() {
		const z = this.#isDown() ? -1 : 1;
		if (this.view !== 'space') {
			const row = letter => ['X', 'Y', 'Z'].map(own => own !== letter ? 0 : own === 'Z' ? z : 1);
			return VIEWS[this.view].map(row);
		}
		const [s, c, st, ct] = [Math.sin(this.turn), Math.cos(this.turn), Math.sin(this.tilt), Math.cos(this.tilt)];
		return [[c, -s, 0], [s * st, c * st, z * ct]];
	}
	#isDown() {
		return this.machine?.axes.find(own => own.axis === 'Z')?.down ?? false;
	}
	// Places that are marked, in mm: `spots`, where a pattern would go to; `taught`, [{ name, at }].
	show(kind, places) {
		if (JSON.stringify(this[kind]) === JSON.stringify(places)) return;
		this[kind] = places;
		if (this.#moving) this.draw(); else this.fit();
	}
	mark(line) {
		if (line === this.#line) return;
		this.#line = line;
		this.#marked = null;
		this.draw();
	}
	#pick(x, y) {
		const at = nearest(this, this.project, (x - this.x) / this.zoom, (y - this.y) / this.zoom, NEAR / this.zoom);
		if (at >= 0) this.picked?.(this.points[at * WIDTH], this.words[at * WIDTH + 4] & 0xffffff);
	}
	look(view) {
		this.view = view;
		this.#turned();
		this.fit();
	}
	#turned() {
		this.#marked = null;
		this.ghost = this.#kept && strokes(this.#kept, this.project, { all: true }).work[0];
	}
	// Keeps the present path below those that come, or lets it go.
	hold(on) {
		const { points, words, count, classes } = this;
		this.#kept = on ? { points, words, count, classes } : null;
		this.look(this.view);
	}
	fit() {
		const [low, high] = (this.box ?? this.#room()).map(own => [...own]);
		for (const spot of [...this.spots, ...this.taught.map(own => own.at)]) spot.forEach((own, n) => { low[n] = Math.min(low[n], own); high[n] = Math.max(high[n], own); });
		const corners = this.#corners(low, high);
		const across = corners.map(own => own[0]), up = corners.map(own => -own[1]);
		const [x0, x1, y0, y1] = [Math.min(...across), Math.max(...across), Math.min(...up), Math.max(...up)];
		const { width, height } = this.#size();
		if (!width) return;
		this.#moving = false;
		this.zoom = Math.min((width - 80) / Math.max(x1 - x0, 1), (height - 110) / Math.max(y1 - y0, 1), 400);
		this.x = width / 2 - (x0 + x1) / 2 * this.zoom;
		this.y = height / 2 + 8 + (y0 + y1) / 2 * this.zoom; // below the buttons
		this.#stale();
	}
	// The machine's travel: least and greatest place by axis.
	#room() {
		const of = (letter, end, other) => this.machine?.axes.find(own => own.axis === letter)?.[end] ?? other;
		return [['low', 0], ['high', 100]].map(([end, other]) => ['X', 'Y', 'Z'].map((letter, n) => of(letter, end, n < 2 ? other : 0)));
	}
	#corners(low, high) {
		const at = this.#on();
		return [0, 1, 2, 3, 4, 5, 6, 7].map(n => at([0, 1, 2].map(k => (n >> k & 1 ? high : low)[k])));
	}
	#on() {
		const [[a, b, c], [d, e, f]] = this.project;
		return ([x, y, z]) => [a * x + b * y + c * z, -(d * x + e * y + f * z)];
	}
	// The travel as a dashed box, and a bar at each end where an axis in sight has its reference switch.
	#frame(paper, thin, ink) {
		const [low, high] = this.#room(), corners = this.#corners(low, high), found = [];
		paper.strokeStyle = ink('--soft');
		paper.lineWidth = thin;
		paper.setLineDash([6 * thin, 4 * thin]);
		paper.beginPath();
		for (let n = 0; n < 8; n++) {
			for (const k of [1, 2, 4]) if (!(n & k)) { paper.moveTo(...corners[n]); paper.lineTo(...corners[n | k]); }
		}
		paper.stroke();
		paper.setLineDash([]);
		paper.lineWidth = 3 * thin;
		paper.beginPath();
		for (const axis of this.machine?.axes ?? []) {
			if (!axis.switch) continue;
			found.push(`${axis.axis} ${axis.home_low ? 'lower' : 'upper'} end`);
			const k = 'XYZ'.indexOf(axis.axis), seen = VIEWS[this.view];
			if (!seen?.includes(axis.axis)) continue;
			const at = [...low], to = [...high];
			at[k] = to[k] = axis.home_low ? low[k] : high[k];
			paper.moveTo(...this.#on()(at)); paper.lineTo(...this.#on()(to));
		}
		paper.stroke();
		this.#words(found);
	}
	#words(switches) {
		const mm = this.box && [0, 1, 2].map(n => (this.box[1][n] - this.box[0][n]).toFixed(1)).join(' by '), holes = this.drawn?.rings.length;
		const path = mm ? `It takes ${mm} mm${holes ? `, with ${holes} places where the tool goes straight down` : ''}. ` : '';
		this.canvas.ariaLabel = `Tool path, coloured by speed, travel dashed. ${path}Reference switches: ${switches.join(', ') || 'none'}. Arrow keys move or turn it, plus and minus zoom, 0 shows all.`;
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
		} else if (this.view === 'space' && !e.shiftKey) this.#rotate((e.offsetX - before.offsetX) / 150, (e.offsetY - before.offsetY) / 150);
		else {
			this.x += e.offsetX - before.offsetX;
			this.y += e.offsetY - before.offsetY;
			this.#moved();
		}
		down.set(e.pointerId, e);
	}
	#key(e) {
		const { width, height } = this.#size();
		const way = { ArrowLeft: [40, 0], ArrowRight: [-40, 0], ArrowUp: [0, 40], ArrowDown: [0, -40] }[e.key];
		if (way && this.view === 'space' && !e.shiftKey) { this.#rotate(way[0] / 400, -way[1] / 400); this.#turning = false; this.#stale(); }
		else if (way) { this.x += way[0]; this.y += way[1]; this.#moved(); }
		else if (e.key === '+' || e.key === '-') this.#scale(e.key === '+' ? 1.25 : 0.8, width / 2, height / 2);
		else if (e.key === '0') this.fit();
		else return;
		e.preventDefault();
	}
	#rotate(turn, tilt) {
		const [low, high] = this.box ?? this.#room(), middle = low.map((own, n) => (own + high[n]) / 2), before = this.#on()(middle);
		this.turn -= turn;
		this.tilt = Math.max(0, Math.min(Math.PI / 2, this.tilt + tilt));
		const after = this.#on()(middle);
		this.x += (before[0] - after[0]) * this.zoom;
		this.y += (before[1] - after[1]) * this.zoom;
		this.#turning = this.#moving = true;
		this.#turned();
		this.#stale();
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
		const ink = inks(this.canvas);
		const bitmap = new OffscreenCanvas((width + 2 * MARGIN) * ratio, (height + 2 * MARGIN) * ratio);
		const paper = bitmap.getContext('2d');
		paper.scale(ratio, ratio);
		paper.translate(this.x + MARGIN, this.y + MARGIN);
		paper.scale(this.zoom, this.zoom);
		const thin = 1 / this.zoom, night = dark();
		// 1, 2 or 5 of a power of ten, some 70 px apart.
		const ten = 10 ** Math.floor(Math.log10(70 / this.zoom)), step = ten * [1, 2, 5, 10].find(n => n * ten * this.zoom >= 70);
		if (this.view !== 'space') {
			paper.lineWidth = thin;
			paper.strokeStyle = ink('--grid');
			const left = -(this.x + MARGIN) / this.zoom, top = -(this.y + MARGIN) / this.zoom;
			const right = left + (width + 2 * MARGIN) / this.zoom, bottom = top + (height + 2 * MARGIN) / this.zoom;
			paper.beginPath();
			for (let x = Math.ceil(left / step) * step; x < right; x += step) { paper.moveTo(x, top); paper.lineTo(x, bottom); }
			for (let y = Math.ceil(top / step) * step; y < bottom; y += step) { paper.moveTo(left, y); paper.lineTo(right, y); }
			paper.stroke();
		}
		paper.lineWidth = 1.5 * thin;
		paper.strokeStyle = ink('--ghost');
		if (this.ghost) paper.stroke(this.ghost);
		const every = this.#turning ? Math.max(1, Math.ceil(this.count / TURNING)) : 1;
		this.drawn = strokes(this, this.project, { every });
		this.#frame(paper, thin, ink);
		paper.lineWidth = thin;
		paper.strokeStyle = ink('--soft');
		paper.setLineDash([5 * thin, 4 * thin]);
		paper.stroke(this.drawn.travel);
		paper.setLineDash([]);
		paper.lineWidth = 1.8 * thin;
		this.drawn.work.forEach((path, n) => {
			paper.strokeStyle = colour(n, night);
			paper.stroke(path);
		});
		for (const [u, v, n] of this.drawn.rings) {
			paper.strokeStyle = colour(n, night);
			paper.beginPath();
			paper.arc(u, v, 4.5 * thin, 0, 7);
			paper.stroke();
		}
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
		const ink = inks(this.canvas), on = this.#on();
		const at = place => { const [u, v] = on(place); return [this.x + u * this.zoom, this.y + v * this.zoom]; };
		if (this.#line && !this.#turning) {
			this.#marked ??= piecesOf(this, this.project, this.#line) ?? new Path2D();
			paper.save();
			paper.translate(this.x, this.y);
			paper.scale(this.zoom, this.zoom);
			paper.lineWidth = 5 / this.zoom;
			paper.lineCap = 'round';
			paper.strokeStyle = ink('--accent');
			paper.globalAlpha = .55;
			paper.stroke(this.#marked);
			paper.restore();
		}
		paper.fillStyle = paper.strokeStyle = ink('--accent');
		paper.lineWidth = 2;
		paper.font = '12px sans-serif';
		for (const spot of this.spots) {
			const [x, y] = at(spot);
			paper.beginPath();
			paper.arc(x, y, 6, 0, 7);
			paper.stroke();
		}
		for (const { name, at: place } of this.taught) {
			const [x, y] = at(place);
			paper.strokeRect(x - 4, y - 4, 8, 8);
			paper.fillText(name, x + 8, y - 6);
		}
		if (this.trail.length > 1) {
			paper.strokeStyle = ink('--trail');
			paper.lineWidth = 3;
			paper.lineJoin = 'round';
			paper.beginPath();
			this.trail.forEach((place, n) => paper[n ? 'lineTo' : 'moveTo'](...at(place)));
			paper.stroke();
		}
		const mark = (place, name, size) => {
			const [x, y] = at(place);
			paper.fillStyle = ink(name);
			paper.beginPath();
			paper.arc(x, y, size, 0, 7);
			paper.fill();
		};
		if (this.marker) mark(this.marker, '--text', 5);
		if (this.live) {
			// Filled where its place is known; hollow before the axes are homed.
			if (this.homed) mark(this.live, '--live', 7);
			else {
				paper.strokeStyle = ink('--live');
				paper.lineWidth = 2;
				paper.beginPath();
				paper.arc(...at(this.live), 7, 0, 7);
				paper.stroke();
			}
		}
		this.#legend(paper, width, height, ink);
	}
	#legend(paper, width, height, ink) {
		paper.fillStyle = ink('--soft');
		paper.font = '12px sans-serif';
		const { step } = this, round = value => +value.toFixed(4), seen = VIEWS[this.view];
		if (seen && step) {
			paper.textAlign = 'center';
			for (let x = Math.ceil((24 - this.x) / this.zoom / step) * step; x * this.zoom + this.x < width - 150; x += step) paper.fillText(round(x), x * this.zoom + this.x, height - 6);
			paper.textAlign = 'left';
			const down = seen[1] === 'Z' && this.#isDown() ? -1 : 1;
			for (let y = Math.ceil((this.y - height + 24) / this.zoom / step) * step; this.y - y * this.zoom > 56; y += step) paper.fillText(round(y * down), 6, this.y - y * this.zoom + 4);
			paper.fillText(`${seen[0]} →  ${seen[1]} ↑  mm`, 6, height - 22);
		}
		if (!this.feed) return;
		const night = dark(), wide = 6, left = width - CLASSES * wide - 10, top = height - 30;
		for (let n = 0; n < CLASSES; n++) {
			paper.fillStyle = colour(this.laser ? CLASSES + n : n, night);
			paper.fillRect(left + n * wide, top, wide, 8);
		}
		paper.fillStyle = ink('--soft');
		paper.textAlign = 'left';
		paper.fillText('0', left, height - 8);
		paper.textAlign = 'right';
		paper.fillText(this.laser ? 'laser, 100 %' : `${this.feed.toFixed(1)} mm/s`, width - 10, height - 8);
		paper.textAlign = 'left';
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
	at(time) {
		const { points, words, count } = this;
		if (count === 0) return null;
		const lo = Math.max(0, lastOf(count, n => points[n * WIDTH] <= time));
		const a = lo * WIDTH, b = Math.min(lo + 1, count - 1) * WIDTH;
		const part = points[b] > points[a] ? Math.min(1, Math.max(0, (time - points[a]) / (points[b] - points[a]))) : 0;
		const place = [1, 2, 3].map(n => points[a + n] + (points[b + n] - points[a + n]) * part);
		return { place, line: words[a + 4] & 0xffffff, speed: this.speed[b / WIDTH] };
	}
}
