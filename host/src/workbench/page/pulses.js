// Pulses of inputs that a person draws on the timeline. The tool keeps them in the script's world.
import { h, time, tell, refused } from './dom.js';

// A click makes a pulse of this length, ms; one that is dragged shorter is taken for a click, px.
const USUAL = 200, CLICK = 4;
const READS = /\b(?:WaitIn\??|ON\s+IN|IN\s*\(|Probe\??\s+\w+\s*,[^,\n]*,[^,\n]*,)\s*([A-Za-z_]\w*|\d+)/gi;

export class Pulses {
	list = [];
	// What is being drawn: { input, from, to } in ms.
	draft = null;

	constructor(link, script) { Object.assign(this, { link, script }); }

	// Inputs that a piece of the script reads: numbers, in the order in which they come.
	reads(text, machine) {
		const named = name => machine.inputs.find(own => own.name?.toLowerCase() === name.toLowerCase())?.n;
		const found = [...text.replace(/'.*$/gm, '').matchAll(READS)].map(([, word]) => +word || named(word));
		return [...new Set(found)].filter(n => machine.inputs.some(own => own.n === n));
	}
	// Rows of inputs that the script reads and that never change in the run: they can be drawn on, too.
	more(rows, machine) {
		const there = new Set(rows.filter(row => !row[1] && row[3]).map(row => row[3]));
		const name = n => { const own = machine.inputs.find(input => input.n === n)?.name; return `in ${n}${own ? ` ${own.toLowerCase()}` : ''}`.slice(0, 13); };
		const read = [...this.reads(this.script(), machine), ...this.list.map(pulse => pulse.input)];
		return [...new Set(read)].filter(n => !there.has(n)).map(n => [name(n), false, [], n]);
	}
	at(input, ms) { return this.list.find(own => own.input === input && ms >= own.from && ms < own.to); }
	// A hand on an input's row: down at a time, moved to another one, up after so many pixels.
	begin(input, ms) { this.draft = { input, from: ms, to: ms, start: ms }; }
	move(ms) {
		const { start } = this.draft;
		Object.assign(this.draft, { from: Math.min(start, ms), to: Math.max(start, ms) });
	}
	end(pixels) {
		const { input, start, from, to } = this.draft;
		this.draft = null;
		const hit = this.at(input, start);
		if (pixels > CLICK && to > from) this.add(input, from, to);
		else if (hit) this.remove(hit);
		else this.add(input, start, start + USUAL);
	}
	add(input, from, to = from + USUAL) { this.#say([...this.list, { input, from: Math.max(0, Math.round(from)), to: Math.max(1, Math.round(to)) }]); }
	remove(pulse) { this.#say(this.list.filter(own => own !== pulse)); }
	#say(list) {
		this.changed?.();
		this.link.ask({ pulses: list }).catch(error => { refused(error); this.refused?.(); });
	}
	// The same without a pointer: what is drawn, each with a button, and fields for another one.
	form(machine) {
		const field = (name, value) => h('input', { type: 'number', className: 'number', min: 0, step: 1, value, ariaLabel: name });
		const inputs = this.reads(this.script(), machine);
		if (!inputs.length && !this.list.length) return [];
		const named = n => machine.inputs.find(own => own.n === n)?.name ?? '';
		const which = h('select', { ariaLabel: 'Input of the pulse' }, machine.inputs.map(({ n }) => h('option', { value: n, selected: n === inputs[0] }, `${n} ${named(n)}`)));
		const from = field('Begin of the pulse, ms', 1000), long = field('Length of the pulse, ms', USUAL);
		return [
			...this.list.map(pulse => h('li', {}, `Input ${pulse.input} ${named(pulse.input)} is on from ${time(pulse.from * 1e3)} to ${time(pulse.to * 1e3)} `,
				h('button', { className: 'small', onclick: () => this.remove(pulse) }, 'Remove'))),
			h('li', { id: 'pulse-form' }, 'Pulse of input ', which, ' at ', from, ' ms for ', long, ' ms ',
				h('button', { className: 'small', id: 'pulse-add', onclick: () => this.add(+which.value, +from.value, +from.value + Math.max(1, +long.value)) }, 'Add'),
				' A click on an input’s row does the same.')];
	}
}
