// Values over time on a canvas: each in its own range, the newest at the right.

import { sheet } from './dom.js';

// Values that are kept, and the time that is shown, ms.
const KEPT = 4000, SHOWN = 30000;

export class Chart {
	#all = new Map(); #names = new Set();

	constructor(canvas) {
		this.canvas = canvas;
		new ResizeObserver(() => this.draw()).observe(canvas);
	}
	show(name, on) {
		if (on) this.#names.add(name); else this.#names.delete(name);
		this.canvas.hidden = !this.#names.size;
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
	draw() {
		const { canvas } = this, width = canvas.clientWidth, height = canvas.clientHeight;
		if (canvas.hidden || !width) return;
		const paper = sheet(canvas), now = performance.now();
		paper.font = '12px sans-serif';
		const x = at => width - (now - at) / SHOWN * width;
		let n = 0;
		for (const name of this.#names) {
			const list = this.#all.get(name) ?? [];
			const first = list.findLastIndex(([at]) => at < now - SHOWN);
			const seen = list.slice(Math.max(0, first));
			const values = seen.map(([, value]) => value);
			const low = Math.min(...values), high = Math.max(...values);
			const y = value => high > low ? height - 6 - (value - low) / (high - low) * (height - 30) : height / 2;
			const hue = 210 + 77 * n;
			paper.strokeStyle = paper.fillStyle = `hsl(${hue} 70% 50%)`;
			paper.lineWidth = 1.5;
			paper.beginPath();
			seen.forEach(([at, value], i) => {
				if (i) paper.lineTo(x(at), y(seen[i - 1][1]));
				paper[i ? 'lineTo' : 'moveTo'](x(at), y(value));
			});
			if (seen.length) paper.lineTo(width, y(seen.at(-1)[1]));
			paper.stroke();
			paper.fillText(`${name} ${low}..${high}`, 6 + 130 * n, 12);
			n++;
		}
	}
}
