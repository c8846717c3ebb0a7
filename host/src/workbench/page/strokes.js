// A path as lines on paper: travel apart from work, work in classes of speed, and a ring where the tool
// goes straight down. Coordinates are mm; a projection makes two of three.

// 5 floats a point: time s, X, Y, Z mm, word (line, style, bit 28: first of a piece, bit 29: reference run,
// bits 26, 27, 30, 31: a laser's power in fourteenths and one more, or 0).
export const WIDTH = 5, CLASSES = 16;
const RAPID = 0, CUT = 2;

// Even steps of viridis; on dark paper without its dark end, on light without its pale one.
const VIRIDIS = ['#440154', '#481467', '#482576', '#453781', '#404688', '#39558c', '#33638d', '#2d718e', '#287d8e', '#238a8d',
	'#1f968b', '#20a386', '#29af7f', '#3dbc74', '#56c667', '#75d054', '#95d840', '#bade28', '#dde318', '#fde725'];
// A laser's power is grey: nothing is like the paper.
export const colour = (n, dark) => n < CLASSES ? VIRIDIS[n + (dark ? 4 : 0)] : `hsl(218 12% ${dark ? 25 + 4.5 * (n - CLASSES) : 88 - 5 * (n - CLASSES)}%)`;

const styleOf = word => word >>> 24 & 3, power = word => word >>> 26 & 3 | word >>> 30 << 2, first = word => word >>> 28 & 1, homes = word => word >>> 29 & 1;

// Class of speed, or of a laser's power, of each point (that of the way to it), the fastest work and the fastest, mm/s.
export function classify({ points, words, count }) {
	const speed = new Float32Array(count);
	let feed = 0, fastest = 0;
	for (let i = 1; i < count; i++) {
		const a = (i - 1) * WIDTH, b = i * WIDTH, word = words[b + 4];
		if (first(word)) continue;
		const way = Math.hypot(points[b + 1] - points[a + 1], points[b + 2] - points[a + 2], points[b + 3] - points[a + 3]);
		const time = points[b] - points[a];
		speed[i] = time > 0 ? way / time : 0;
		if (speed[i] > fastest) fastest = speed[i];
		if (styleOf(word) !== RAPID && speed[i] > feed) feed = speed[i];
	}
	const top = feed || fastest || 1;
	let laser = false;
	const classes = Uint8Array.from(speed, (v, i) => {
		const own = styleOf(words[i * WIDTH + 4]) === CUT && power(words[i * WIDTH + 4]);
		if (own) laser = true;
		return own ? CLASSES + own : Math.min(CLASSES - 1, Math.floor(v / top * CLASSES));
	});
	return { classes, feed, fastest, speed, laser };
}

// Lines of a path: `travel`, `work` by class, `rings` [u, v, class, point]; null for what it does not have.
// `every`: only each so many points, for a path that is being turned. `all`: everything in one line.
export function strokes(of, project, { every = 1, all = false } = {}) {
	const { points, words, count, classes } = of, [[a, b, c], [d, e, f]] = project;
	const travel = new Path2D(), work = Array.from({ length: all ? 1 : 2 * CLASSES }, () => new Path2D());
	const rings = new Map(), u = at => a * points[at + 1] + b * points[at + 2] + c * points[at + 3];
	const v = at => -(d * points[at + 1] + e * points[at + 2] + f * points[at + 3]);
	let last = null, home = false, from = 0;
	for (let i = 0; i < count; i++) {
		const at = i * WIDTH, word = words[at + 4];
		if (first(word)) { last = null; home = homes(word); from = at; continue; }
		if (home) continue; // where a reference run begins is not known before
		const end = i + 1 === count || first(words[at + WIDTH + 4]);
		if (every > 1 && i % every && !end) continue;
		const rapid = styleOf(word) === RAPID, path = all ? work[0] : rapid ? travel : work[classes[i]];
		if (last !== path) path.moveTo(u(from), v(from));
		path.lineTo(u(at), v(at));
		if (!rapid && !c && !f && points[at + 1] === points[from + 1] && points[at + 2] === points[from + 2] && points[at + 3] !== points[from + 3]) {
			const key = `${points[at + 1].toFixed(3)}/${points[at + 2].toFixed(3)}`;
			if (!rings.has(key)) rings.set(key, [u(at), v(at), classes[i], i]);
		}
		last = path;
		from = at;
	}
	return { travel, work, rings: [...rings.values()] };
}

export function piecesOf(of, project, line) {
	const { points, words, count } = of, path = new Path2D(), [[a, b, c], [d, e, f]] = project;
	let found = false;
	for (let i = 1; i < count; i++) {
		const at = i * WIDTH, word = words[at + 4];
		if ((word & 0xffffff) !== line || first(word) || homes(word)) continue;
		const [x0, y0, z0, x1, y1, z1] = [1, 2, 3, 6, 7, 8].map(n => points[at - WIDTH + n]);
		path.moveTo(a * x0 + b * y0 + c * z0, -(d * x0 + e * y0 + f * z0));
		path.lineTo(a * x1 + b * y1 + c * z1, -(d * x1 + e * y1 + f * z1));
		found = true;
	}
	return found ? path : null;
}

// The point of a path whose way is nearest to a place on the paper, within `reach`; -1 for none.
export function nearest(of, project, x, y, reach) {
	const { points, words, count } = of, [[a, b, c], [d, e, f]] = project;
	let best = reach, found = -1, u0 = 0, v0 = 0, home = false;
	for (let i = 0; i < count; i++) {
		const at = i * WIDTH, word = words[at + 4];
		const u = a * points[at + 1] + b * points[at + 2] + c * points[at + 3], v = -(d * points[at + 1] + e * points[at + 2] + f * points[at + 3]);
		if (first(word)) home = homes(word);
		else if (!home) {
			const du = u - u0, dv = v - v0, long = du * du + dv * dv;
			const part = long ? Math.max(0, Math.min(1, ((x - u0) * du + (y - v0) * dv) / long)) : 0;
			const far = Math.hypot(x - u0 - part * du, y - v0 - part * dv);
			if (far < best) { best = far; found = i; }
		}
		u0 = u; v0 = v;
	}
	return found;
}

// Least and greatest place of what is drawn, mm, by axis; null: nothing is.
export function extent({ points, words, count }) {
	const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
	let home = false;
	for (let i = 0; i < count; i++) {
		const at = i * WIDTH;
		if (first(words[at + 4])) home = homes(words[at + 4]);
		if (home) continue;
		for (let n = 0; n < 3; n++) {
			const p = points[at + 1 + n];
			if (p < low[n]) low[n] = p;
			if (p > high[n]) high[n] = p;
		}
	}
	return low[0] === Infinity ? null : [low, high];
}
