// Values over time on a canvas: each in its own range, all on one time axis, the newest at the right.
import { sheet } from './dom.js';

// Values that are kept, and the time that is shown, ms.
const KEPT = 4000, SHOWN = 30000;

export class Chart {
	#all = new Map(); #names = new Set(); #frozen = null;

	constructor(canvas) {
		this.canvas = canvas;
		new ResizeObserver(() => this.draw()).observe(canvas);
	}
	show(name, on) {
		if (on) this.#names.add(name); else this.#names.delete(name);
		this.canvas.hidden = !this.#names.size;
		this.draw();
	}
	// Holds the picture; what comes meanwhile is kept.
	freeze(on) {
		this.#frozen = on ? performance.now() : null;
		this.draw();
	}
	// Only changes are kept: a value holds until the next one.
	add(name, value) {
		const now = performance.now();
		if (!this.#all.has(name)) this.#all.set(name, []);
		const list = this.#all.get(name);
		if (list.length && list.at(-1)[1] === value) return;
		list.push([now, value]);
		if (list.length > KEPT) list.splice(0, KEPT / 4);
	}
	// A row for each time at which one of those shown changed, until the picture was held.
	csv() {
		const names = [...this.#names], end = this.#frozen ?? performance.now();
		const lists = names.map(name => (this.#all.get(name) ?? []).filter(([at]) => at <= end));
		const times = [...new Set(lists.flatMap(list => list.map(([at]) => at)))].sort((a, b) => a - b);
		const last = names.map(() => ''), next = names.map(() => 0);
		const rows = times.map(at => {
			lists.forEach((list, n) => { while (list[next[n]]?.[0] <= at) last[n] = list[next[n]++][1]; });
			return [((at - times[0]) / 1000).toFixed(3), ...last];
		});
		return [['seconds', ...names], ...rows].map(row => `${row.join(',')}\n`).join('');
	}
	draw() {
		const { canvas } = this, width = canvas.clientWidth, height = canvas.clientHeight;
		if (canvas.hidden || !width) return;
		const paper = sheet(canvas), now = this.#frozen ?? performance.now(), low = height - 16;
		paper.font = '12px sans-serif';
		const x = at => width - (now - at) / SHOWN * width;
		paper.fillStyle = getComputedStyle(canvas).color;
		for (let s = 5; s < SHOWN / 1000; s += 5) paper.fillText(`−${s} s`, x(now - s * 1000) - 10, height - 3);
		let n = 0;
		for (const name of this.#names) {
			const list = (this.#all.get(name) ?? []).filter(([at]) => at <= now);
			const first = list.findLastIndex(([at]) => at < now - SHOWN);
			const seen = list.slice(Math.max(0, first));
			const values = seen.map(([, value]) => value);
			const least = Math.min(...values), most = Math.max(...values);
			const y = value => most > least ? low - 4 - (value - least) / (most - least) * (low - 26) : low / 2;
			paper.strokeStyle = paper.fillStyle = `hsl(${210 + 77 * n} 70% 50%)`;
			paper.lineWidth = 1.5;
			paper.beginPath();
			seen.forEach(([at, value], i) => {
				if (i) paper.lineTo(x(at), y(seen[i - 1][1]));
				paper[i ? 'lineTo' : 'moveTo'](x(at), y(value));
			});
			if (seen.length) paper.lineTo(width, y(seen.at(-1)[1]));
			paper.stroke();
			if (seen.length) paper.fillText(`${name} ${+least.toFixed(3)}..${+most.toFixed(3)}`, 6 + 150 * (n % 4), 12 + 14 * (n >> 2));
			n++;
		}
	}
}
