// Beside the lines of the script: values of their variables at the slider's time, where a move goes to, and what PRINT
// wrote. Only of the very text that was simulated.
import { h, mm, lastOf } from './dom.js';
import { WIDTH } from './strokes.js';

// Values beside a line; points and events that are looked back through for a line's last one.
const MOST = 4, BACK = 20000;

export class Values {
	#now = null;

	constructor(editor, view) {
		Object.assign(this, { editor, view });
		this.box = h('div', { className: 'values', ariaHidden: 'true' });
		editor.root.append(this.box);
		editor.painted = (first, last) => this.#draw(first, last);
	}
	show(now) {
		this.#now = now;
		if (now) this.editor.later(); else if (this.box.firstChild) this.box.replaceChildren();
	}
	#draw(first, last) {
		const { editor } = this, now = this.#now;
		if (!now) return;
		const vars = new Map(), told = this.#told(now, first, last), found = [], inside = this.#routines();
		// Two of one name: which one a line means is not known here.
		for (const own of now.about.vars) vars.set(own.name.toLowerCase(), vars.has(own.name.toLowerCase()) ? null : own);
		const from = editor.lines[first], to = editor.lines[last] ?? editor.value.length;
		const meant = editor.meanings.filter(own => own.start >= from && own.end <= to && ['variable', 'constant', 'parameter'].includes(own.kind));
		for (let n = first; n < last; n++) {
			const line = this.editor.row(n), words = bare(line), start = editor.lines[n], end = start + line.length;
			if (/^\s*(DIM|KEEP|CONST|TABLE|INPUT|OUTPUT|PROFILE)\b/i.test(words)) continue;
			// Without what a SUB has for itself: that lives in no cell of its own.
			const names = [...new Set(words.toLowerCase().match(/[a-z_]\w*/g) ?? [])].filter(name => vars.get(name) && !vars.get(name).array && !inside[n]?.has(name));
			const list = now.cells ? names.slice(0, MOST).map(name => `${vars.get(name).name} = ${amount(now.cells.get(vars.get(name).cell) ?? 0, vars.get(name).unit)}`) : [];
			if (told.has(n + 1) && meant.some(own => own.start >= start && own.end <= end)) list.push(told.get(n + 1));
			if (list.length) found.push([n, end, list.join('   ')]);
		}
		const root = editor.root.getBoundingClientRect(), { scrollLeft, scrollTop, clientLeft, clientTop } = editor.root;
		const places = found.map(([, end]) => editor.glyph(end - 1));
		this.box.replaceChildren(...found.map(([n, , words], k) => h('span', { 'data-line': n + 1,
			style: `left:${places[k].right - root.x - clientLeft + scrollLeft + 24}px;top:${places[k].y - root.y - clientTop + scrollTop}px` }, words)));
	}
	// By line: names that a SUB around it has for itself.
	#routines() {
		if (this.text === this.editor.value) return this.found;
		this.text = this.editor.value;
		this.found = [];
		let names = null;
		for (let n = 0; n < this.editor.lines.length; n++) {
			const line = bare(this.editor.row(n)), own = line.toLowerCase().match(/[a-z_]\w*/g) ?? [];
			if (/^\s*(SUB|FUNCTION)\b/i.test(line)) names = new Set(own.slice(2));
			else if (/^\s*END\s+(SUB|FUNCTION)\b/i.test(line)) names = null;
			else if (names && /^\s*DIM\b/i.test(line)) for (const name of own.slice(1)) names.add(name);
			if (names) this.found[n] = names;
		}
		return this.found;
	}
	// By line: where its last move until then went, or what it printed.
	#told({ about, us }, first, last) {
		const { points, words, count } = this.view, found = new Map();
		const event = lastOf(about.events.length, k => about.events[k][0] <= us);
		for (let k = us < (about.heard_us ?? Infinity) ? event : -1; k >= Math.max(0, event - BACK); k--) {
			const [, line, print] = about.events[k];
			if (print !== null && line > first && line <= last && !found.has(line)) found.set(line, `“${print}”`);
		}
		const point = lastOf(count, k => points[k * WIDTH] <= us / 1e6 + 1e-6);
		for (let k = point; k >= Math.max(0, point - BACK); k--) {
			const word = words[k * WIDTH + 4], line = word & 0xffffff;
			// The last point of a line's piece is where it goes to; one that is under way is not there yet.
			if (line <= first || line > last || found.has(line) || word >>> 28 & 1) continue;
			const next = k === point && k + 1 < count ? words[(k + 1) * WIDTH + 4] : 0, under = (next & 0xffffff) === line && !(next >>> 28 & 1);
			if (!under) found.set(line, `→ ${[1, 2, 3].map(n => mm(points[k * WIDTH + n], 2)).join(' ')} mm`);
		}
		return found;
	}
}

const bare = line => line.replace(/"[^"]*"?/g, '""').replace(/'.*$/, '');

export function amount(value, unit) {
	if (unit === 'um') return `${+(value / 1000).toFixed(3)} mm`;
	if (unit === 'um/s') return `${+(value / 1000).toFixed(3)} mm/s`;
	return unit ? `${value} ${unit}` : String(value);
}
