// Numbers of the script that are dragged: the text and its run follow at once. A drag is one step of undo; Escape
// leaves the number as it was.
import { h, text, hear } from './dom.js';

// px of a step; ms until a number with the caret has a handle, and until the next number goes to the tool.
const PACE = 4, LATER = 200, PATIENCE = 600;
const NUMBER = /(?<![\w.])([XYZIJKRPQFS]?)(-?)(\d[\d_]*(?:\.\d*)?|\.\d+)((?:mm|um|in|st)(?:\/(?:s2|s|min))?|ms|s|min)?(?![\w.])/gi;
const BLOCK = /^\s*(?:N\d+\s+)?[GMTFSXYZ]-?[\d.]/i;

export function numberAt(line, column, lex) {
	for (const match of line.matchAll(NUMBER)) {
		const [all, letter, sign, digits, unit = ''] = match;
		let from = match.index;
		if (from > column || from + all.length < column) continue;
		for (const [start, end, kind] of lex(line)) {
			if ((kind === 'remark' || kind === 'text') && start <= from && from < end) return null;
		}
		if (letter && !BLOCK.test(line)) return null;
		const minus = sign && (letter || !/[\w)\]]\s*$/.test(line.slice(0, from)));
		from += letter.length + (sign && !minus ? 1 : 0);
		const places = digits.split('.')[1]?.length ?? 0;
		return { from, to: match.index + all.length, letter: letter.toUpperCase(), unit, places,
			value: (minus ? -1 : 1) * +digits.replaceAll('_', ''), digits: digits.replace(/\D/g, '').length - places };
	}
	return null;
}

// Least and greatest value that a number may get, by what the machine can, and null where nothing says so.
export function bounds(found, line, machine, script) {
	const { letter, unit, value } = found, axes = machine?.axes ?? [], rate = unit.split('/')[1]?.toLowerCase(), base = unit.split('/')[0].toLowerCase();
	const name = 'XYZ'.includes(letter) && letter || /\b(?:MoveAxe|MoveRel|MoveSpeed|Probe\??|SetPos)\s+([XYZ])\b/i.exec(line)?.[1].toUpperCase();
	const own = axes.filter(axis => axis.axis === name), some = own.length ? own : axes;
	const span = Math.max(0, ...some.map(axis => axis.high - axis.low)), top = Math.max(0, ...some.map(axis => axis.top));
	const inches = letter && /^[^'\n]*\bG20\b/im.test(script), step = some[0]?.step_mm || 1;
	const of = mm => base === 'in' || inches ? mm / 25.4 : base === 'um' ? mm * 1000 : base === 'st' ? mm / step : mm;
	let range;
	if (rate === 's' || rate === 'min' || letter === 'F') range = [0, of(top) * (rate === 's' ? 1 : 60)];
	else if (rate) range = [0, Infinity];
	else if (letter ? 'XYZIJKRQ'.includes(letter) : ['mm', 'um', 'in', 'st'].includes(base)) {
		// Places of an axis lie in its travel; other lengths are as long at most.
		const place = own.length && !/\bMoveRel\b/i.test(line) && !/^[^'\n]*\b(?:G91|G92|G5[4-9]|SetPos)\b/im.test(script);
		range = place ? [of(own[0].low), of(own[0].high)] : [-of(span), of(span)];
	} else if (/^\s*(?:SetOut|Pulse)\s+\d+$/i.test(line.slice(0, found.to))) range = [1, machine?.outputs.length ?? 1];
	else if (/\b(?:WaitIn\??\s+|IN\s*\(\s*|INPUT\s+\w+\s*=\s*)\d+$/i.test(line.slice(0, found.to))) range = [1, machine?.inputs.length ?? 1];
	else range = [value < 0 ? -Infinity : 0, Infinity];
	return [Math.min(range[0], value), Math.max(range[1], value)];
}

// The step of a drag: the last digit that is written, or of a large whole number its second one.
export const stepOf = ({ places, digits, unit }) => places ? 10 ** -places : /^(mm|in|s)$|^mm\/s$/i.test(unit) ? 1 : 10 ** Math.max(0, digits - 2);

export class Drag {
	#found = null; #due = null; #held = null; #busy = false; #x = 0;
	#drawn = null;

	constructor(editor, script, view, trial, machine) {
		Object.assign(this, { editor, script, view, machine });
		this.handle = h('button', { id: 'drag', className: 'pop', hidden: true, tabIndex: -1,
			title: 'Drag: the path follows. Alt with the arrow up or down does the same; Shift makes smaller steps.' });
		document.body.append(this.handle);
		trial.came = () => this.#drawn?.();
		const { text, root } = editor;
		hear(document, 'selectionchange', () => { if (document.activeElement === text && !this.#held) this.#later(() => this.#offer(editor.caret())); });
		hear(text, 'input', () => this.#hide());
		hear(text, 'blur', () => this.#hide());
		hear(root, 'scroll', () => this.#hide());
		hear(text, 'keydown', e => {
			const by = { ArrowUp: 1, ArrowDown: -1 }[e.key];
			if (!by || !e.altKey || e.ctrlKey || e.metaKey) return;
			e.preventDefault();
			this.#nudge(by * (e.shiftKey ? 0.1 : 1));
		});
		hear(this.handle, 'pointerdown', e => this.#down(e));
		hear(this.handle, 'pointermove', e => this.#moved(e));
		hear(this.handle, 'pointerup', () => this.#end(true));
		hear(this.handle, 'pointercancel', () => this.#end(false));
		hear(window, 'keydown', e => { if (e.key === 'Escape' && this.#held) { e.preventDefault(); e.stopPropagation(); this.#end(false); } }, true);
	}
	#later(run) { clearTimeout(this.#due); this.#due = setTimeout(run, LATER); }
	#hide() { clearTimeout(this.#due); if (!this.#held) this.handle.hidden = true; }
	#at(at) {
		if (this.editor.locked) return null;
		const { editor } = this, n = editor.line(at), first = editor.lines[n], line = editor.row(n);
		const found = numberAt(line, at - first, editor.lex);
		if (!found || editor.meanings.some(own => own.start < first + found.to && own.end > first + found.from)) return null;
		const [low, high] = bounds(found, line, this.machine(), editor.value);
		return { ...found, low, high, start: first + found.from, text: line.slice(found.from, found.to) };
	}
	#offer(at) {
		if (this.#held) return;
		const found = this.#found = this.#at(at);
		this.handle.hidden = !found;
		if (!found) return;
		const box = this.editor.glyph(found.start), end = n => Number.isFinite(n) ? String(+n.toFixed(3)) : '…';
		text(this.handle, Number.isFinite(found.high) ? `↔ ${end(found.low)} to ${end(found.high)} ${found.unit}` : '↔');
		this.handle.style.left = `${box.x}px`;
		this.handle.style.top = `${box.bottom + 1}px`;
	}
	#written(found, value, step) {
		const places = Math.max(found.places, step < 1 ? Math.ceil(-Math.log10(step) - 1e-9) : 0), unit = 10 ** places;
		const low = Math.ceil(found.low * unit - 1e-6) / unit, high = Math.floor(found.high * unit + 1e-6) / unit;
		const own = Math.min(high, Math.max(low, value)).toFixed(places).replace(/^-(0\.?0*)$/, '$1');
		return own + found.unit;
	}
	#fine({ unit, letter, places }) { return !places && !letter && !/^(mm|in|s|mm\/s|mm\/min|in\/min)$/i.test(unit) ? 1 : 0.1; }
	#nudge(by) {
		const found = this.#at(this.editor.caret());
		if (!found) return;
		const step = stepOf(found) * (Math.abs(by) < 1 ? this.#fine(found) : 1);
		this.#keep(found, this.#written(found, found.value + Math.sign(by) * step, step));
	}
	#keep({ start, text: old }, own) {
		if (own === old) return;
		this.editor.replace(start, start + old.length, own);
		this.editor.select(start + own.length, start + own.length);
	}
	#down(e) {
		if (!this.#found || e.button) return;
		e.preventDefault();
		const { editor } = this, found = this.#found;
		if (editor.value.slice(found.start, found.start + found.text.length) !== found.text) { this.#hide(); return; }
		this.handle.setPointerCapture(e.pointerId);
		this.#held = { ...found, now: found.text };
		this.#x = e.clientX;
		this.view.steady = true;
		document.body.classList.add('dragging');
	}
	#moved(e) {
		const held = this.#held;
		if (!held) return;
		const step = stepOf(held) * (e.shiftKey ? this.#fine(held) : 1);
		this.#write(this.#written(held, held.value + Math.round((e.clientX - this.#x) / PACE) * step, step));
	}
	#write(own) {
		const held = this.#held, { editor } = this;
		if (own === held.now) return true;
		const there = editor.value.slice(held.start, held.start + held.now.length) === held.now;
		if (!there || !editor.poke(held.start, held.start + held.now.length, own)) { this.#drop(); return false; }
		held.now = own;
		this.#follow();
		return true;
	}
	#drop() {
		this.#held = null;
		this.view.steady = false;
		document.body.classList.remove('dragging');
		this.#hide();
	}
	#end(keep) {
		const held = this.#held, own = held?.now;
		if (!held) return;
		const back = this.#write(held.text);
		if (back) this.#drop();
		if (back && keep) this.#keep(held, own);
		this.script.sync();
	}
	// One text after the other goes to the tool; the next one when the run of the one before is drawn.
	async #follow() {
		if (this.#busy) return;
		this.#busy = true;
		try {
			for (let sent = null; this.#held && sent !== this.editor.value;) {
				sent = this.editor.value;
				const drawn = new Promise(done => { this.#drawn = done; setTimeout(done, PATIENCE); });
				await this.script.sync();
				await drawn;
			}
		} finally { this.#busy = false; }
	}
}
