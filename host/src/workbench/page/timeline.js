// The timeline, which is the slider: statements, inputs, outputs, what is printed and the fault on one scale, all of
// the run or a part of it.
import { $, inks, sheet, text, time, hear } from './dom.js';

// px left and right of the scale; the shortest part that is shown, us; what a step of zoom makes of it.
const LEFT = 90, RIGHT = 8, LEAST = 2000, STEP = 0.5;

export class Timeline {
	about = null; us = 0; span = 0; from = 0; to = 0; shown = [];

	constructor(pulses, seek) {
		Object.assign(this, { pulses, seek });
		this.slider = $('#scrub');
		hear(this.slider, 'input', () => this.#show(this.from + this.slider.value / 1e4 * (this.to - this.from)));
		hear(this.slider, 'keydown', e => {
			const by = { '+': STEP, '-': 1 / STEP, 0: Infinity }[e.key];
			if (by) { e.preventDefault(); this.zoom(by); }
		});
		for (const [id, by] of [['in', STEP], ['out', 1 / STEP], ['all', Infinity]]) hear($(`#zoom-${id}`), 'click', () => this.zoom(by));
		const rows = this.rows = $('#rows');
		hear(rows, 'wheel', e => {
			// A wheel alone scrolls the panel.
			if (!this.about || !e.ctrlKey && !e.shiftKey) return;
			e.preventDefault();
			if (e.ctrlKey) this.zoom(Math.exp(e.deltaY / 300), this.#time(e)); else this.#part(this.from + (e.deltaX + e.deltaY) / 500 * (this.to - this.from), this.to - this.from);
		}, { passive: false });
		hear(rows, 'pointerdown', e => this.#down(e));
		hear(rows, 'pointermove', e => { if (e.buttons) this.#moved(e); else this.#hover(e); });
		hear(rows, 'pointerup', e => { if (pulses.draft) pulses.end(Math.abs(e.offsetX - this.pressed)); });
		hear(rows, 'pointercancel', () => { pulses.draft = null; this.draw(); });
		new ResizeObserver(() => this.draw()).observe(rows);
	}
	// Another run. The part that is shown stays, as far as it is in it.
	set(about) {
		const whole = this.from <= 0 && this.to >= this.span;
		this.about = about;
		// A run that waits for an input may go on where it stands: there is room to draw.
		this.span = about.end.why === 'idle' ? about.us * 1.2 + 1e6 : about.us;
		if (whole) this.#part(0, this.span); else this.#part(this.from, this.to - this.from);
	}
	// Shows so many times as much, round a time or what is shown of the run.
	zoom(by, at = this.us) {
		if (!this.about) return;
		const long = this.to - this.from, next = Math.max(Math.min(LEAST, this.span), Math.min(this.span, long * by));
		const part = long ? Math.max(0, Math.min(1, (at - this.from) / long)) : 0;
		this.#part(at - part * next, next);
	}
	#part(from, long) {
		const most = Math.min(long, this.span);
		this.from = Math.max(0, Math.min(from, this.span - most));
		this.to = this.from + most;
		const whole = most >= this.span;
		text($('#zoom-words'), whole ? '' : `${time(this.from)} to ${time(this.to)}`);
		$('#zoom-out').disabled = $('#zoom-all').disabled = whole;
		$('#zoom-in').disabled = most <= Math.min(LEAST, this.span);
		this.draw();
		this.#knob();
	}
	// The run is at this time now: it comes in sight.
	at(us) {
		const moved = us !== this.us;
		this.us = us;
		if (moved && (us < this.from || us > this.to)) this.#part(us - (this.to - this.from) / 4, this.to - this.from); else this.#knob();
	}
	#knob() {
		this.slider.value = this.to > this.from ? (this.us - this.from) / (this.to - this.from) * 1e4 : 0;
		this.#cursor();
	}
	#x(at, width = this.rows.clientWidth) { return LEFT + Math.max(0, Math.min(1, (at - this.from) / (this.to - this.from || 1))) * (width - LEFT - RIGHT); }
	draw() {
		const canvas = this.rows, { us, events, end } = this.about ?? { us: 0, events: [] };
		const prints = events.filter(event => event[2] !== null), faulty = end?.status === 'fault';
		// [name, is an output, spans]; marks are spans without a length.
		const rows = [...events.length ? [['line', false, []]] : [], ...this.about?.rows ?? []];
		if (this.about?.pulses) rows.push(...this.pulses.more(rows, this.about.machine));
		this.shown = rows;
		if (prints.length || faulty) rows.push(['PRINT, fault', false, []]);
		canvas.ariaLabel = `Inputs and outputs over time; ${prints.length} lines printed; ${faulty ? `${end.fault} at ${time(us)}` : 'no fault'}`;
		const height = Math.max(1, rows.length) * 18 + 6, width = canvas.clientWidth;
		canvas.hidden = !rows.length;
		if (!rows.length || !width) return;
		canvas.style.height = `${height}px`;
		const paper = sheet(canvas, width, height, { willReadFrequently: true }), ink = inks(canvas);
		paper.font = '11px sans-serif';
		const x = at => this.#x(at, width), seen = (from, to = from) => to >= this.from && from <= this.to, { draft, list } = this.pulses;
		rows.forEach(([name, output, spans, input], n) => {
			const y = 4 + n * 18;
			paper.fillStyle = ink('--soft');
			paper.fillText(name, 4, y + 11);
			paper.fillStyle = ink('--grid');
			paper.fillRect(LEFT, y + 6, width - LEFT - RIGHT, 2);
			paper.fillStyle = ink(output ? '--on' : '--in');
			for (const [from, to] of spans) if (seen(from, to)) paper.fillRect(x(from), y + 1, Math.max(2, x(to) - x(from)), 12);
			if (n === 0 && events.length) this.#lines(paper, ink, x, y);
			if (output || !input) return;
			paper.strokeStyle = ink('--accent');
			for (const one of draft ? [...list, draft] : list) {
				const [from, to] = [one.from * 1e3, one.to * 1e3];
				if (one.input === input && seen(from, to)) paper.strokeRect(x(from), y + .5, Math.max(3, x(to) - x(from)), 13);
			}
		});
		if (prints.length || faulty) {
			const y = 4 + (rows.length - 1) * 18;
			paper.fillStyle = ink('--accent');
			for (const [at] of prints) if (seen(at)) paper.fillRect(x(at) - 1, y + 1, 2, 12);
			paper.fillStyle = ink('--bad');
			if (faulty && seen(us)) paper.fillRect(x(us) - 4, y + 1, 8, 12);
		}
		this.picture = paper.getImageData(0, 0, canvas.width, canvas.height);
		this.#cursor();
	}
	// Which line runs when, with its number where there is room.
	#lines(paper, ink, x, y) {
		const { events, us, heard_us } = this.about;
		let last = -1, drawn = 0;
		for (let k = 0; k < events.length; k++) {
			const begin = events[k][0], end = events[k + 1]?.[0] ?? heard_us ?? us, line = events[k][1];
			if (end < this.from) continue;
			if (begin > this.to) break;
			const from = x(begin), to = x(end);
			if (line === last && from - drawn < 1 || to - from < .5 && from - drawn < 1) continue;
			paper.fillStyle = ink(line % 2 ? '--ghost' : '--line');
			paper.fillRect(from, y + 1, Math.max(1, to - from - 1), 12);
			if (to - from > 7 * String(line).length + 6) {
				paper.fillStyle = ink('--text');
				paper.fillText(line, from + 3, y + 11);
			}
			[last, drawn] = [line, from];
		}
	}
	#cursor() {
		if (!this.picture || this.rows.hidden) return;
		const paper = this.rows.getContext('2d');
		paper.putImageData(this.picture, 0, 0);
		if (this.us < this.from || this.us > this.to) return;
		paper.fillStyle = inks(this.rows)('--text');
		paper.fillRect(this.#x(this.us), 0, 1, this.rows.height);
	}
	#time(e) { return this.from + Math.max(0, Math.min(1, (e.offsetX - LEFT) / (this.rows.clientWidth - LEFT - RIGHT))) * (this.to - this.from); }
	#show(us) { if (this.about) this.seek(Math.min(this.about.us, us)); }
	#input(e) {
		const row = this.about?.pulses && this.shown[Math.floor((e.offsetY - 4) / 18)];
		return row && !row[1] && e.offsetX >= LEFT ? row[3] : undefined;
	}
	#hover(e) {
		const input = this.#input(e);
		this.rows.style.cursor = input ? 'crosshair' : 'pointer';
		this.rows.title = `${input ? 'Click or drag: the input is on then. Click what you drew: it goes away. ' : ''}Ctrl with the wheel zooms, Shift moves.`;
	}
	#down(e) {
		const input = this.#input(e);
		if (!input) { this.#show(this.#time(e)); return; }
		this.rows.setPointerCapture(e.pointerId);
		this.pressed = e.offsetX;
		this.pulses.begin(input, Math.round(this.#time(e) / 1e3));
	}
	#moved(e) {
		if (!this.pulses.draft) { this.#show(this.#time(e)); return; }
		this.pulses.move(Math.round(this.#time(e) / 1e3));
		this.draw();
	}
}
