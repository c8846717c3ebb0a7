// The wizard for patterns. The tool writes the script; this page shows it and puts it where it belongs.
import { h, text, tell, action, hear, label, bar } from './dom.js';
import { micrometres, number, numberField, parsed } from './fields.js';

// Fields of each shape: name, label, value, and mm or a count.
const SHAPES = {
	grid: ['Grid', [['columns', 'Columns', 5], ['rows', 'Rows', 3], ['pitch_x', 'Along X', 10, 'mm'], ['pitch_y', 'Along Y', 10, 'mm']]],
	circle: ['Bolt circle', [['count', 'Points', 6], ['diameter', 'Diameter', 40, 'mm'], ['first', 'First at', 0, 'degrees']]],
	line: ['Line', [['count', 'Points', 5], ['way_x', 'To the last, X', 40, 'mm'], ['way_y', 'Y', 0, 'mm']]],
	sockets: ['Rows of sockets', [['count', 'Sockets', 2], ['apart', 'Apart', 25.4, 'mm'], ['pins', 'Pins in a row', 7], ['pitch', 'Pitch', 2.54, 'mm'], ['row', 'Between the rows', 7.62, 'mm']]],
	points: ['Points of a file', []],
};
const LARGEST = 400000;
// From the last key to the points on the drawing, ms.
const SOON = 150;

const um = value => Math.round(value * 1000);

export class Pattern {
	fields = {}; points = []; pairs = [];

	constructor(link, machine, script) {
		Object.assign(this, { link, machine, script });
		const field = (name, words, value, unit = '') => {
			this.fields[name] = numberField({ value, name });
			this.fields[name].dataset.own = value;
			return label(`${words} `, this.fields[name], unit && ` ${unit}`);
		};
		this.shape = h('select', { id: 'shape', ariaLabel: 'Pattern', onchange: () => this.#shaped() },
			...Object.entries(SHAPES).map(([value, [name]]) => h('option', { value }, name)));
		this.boxes = Object.fromEntries(Object.entries(SHAPES).map(([name, [, list]]) =>
			[name, h('span', { className: 'bar' }, ...list.map(([own, ...rest]) => field(`${name}_${own}`, ...rest)))]));
		this.zigzag = h('input', { type: 'checkbox' });
		this.boxes.grid.append(label(this.zigzag, ' zigzag'));
		this.file = h('input', { type: 'file', id: 'points-file', ariaLabel: 'File of points', onchange: () => this.#read().catch(error => this.#told(error)) });
		this.groups = h('span', { className: 'bar' });
		this.boxes.points.append(this.file, h('span', { className: 'soft' }, 'CSV, KiCad .pos, Excellon or Gerber drill'), this.groups);
		this.name = h('input', { id: 'pattern-name', value: 'holes', maxLength: 32, ariaLabel: 'Name of the points', className: 'new' });
		this.down = h('input', { type: 'checkbox', id: 'goes-down', checked: true, onchange: () => this.#shaped() });
		this.spindle = h('input', { type: 'checkbox', id: 'spindle', checked: true });
		this.depths = h('span', { className: 'bar' }, field('surface', 'Surface at Z', 0, 'mm'), this.#here('surface', 'Z'),
			field('depth', 'Depth', 2, 'mm'), field('clear', 'Clearance', 2, 'mm'), field('feed', 'Down at', 2, 'mm/s'));
		this.act = h('select', { id: 'act', ariaLabel: 'At each point', onchange: () => this.#shaped() },
			...[['nothing', 'nothing more'], ['wait', 'wait'], ['pulse', 'switch an output on for']].map(([value, label]) => h('option', { value }, label)));
		this.ms = field('ms', 'for', 500, 'ms');
		this.output = field('output', 'Output', 3);
		this.frame = h('div', { className: 'pair', id: 'frame' });
		this.mirrored = h('input', { type: 'checkbox', id: 'mirrored' });
		this.result = h('pre', { id: 'made', tabIndex: 0, ariaLabel: 'The script that comes of it', hidden: true });
		this.words = h('p', { role: 'status', id: 'pattern-words' });
		this.listed = h('datalist', { id: 'listed' });
		this.live = h('p', { id: 'pattern-live', className: 'soft' });
		const panel = document.getElementById('pattern');
		hear(panel, 'input change click', () => this.#soon());
		hear(document, 'tab', () => this.#soon());
		panel.append(
			h('fieldset', {}, h('legend', {}, 'Points'), this.shape, label('called ', this.name), ...Object.values(this.boxes),
				h('span', { className: 'bar' }, field('x', 'First point (centre, zero of the list): X', 10, 'mm'), field('y', 'Y', 10, 'mm'), this.#here(['x', 'y'], 'XY'))),
			h('fieldset', {}, h('legend', {}, 'At each point'), label(this.down, ' Z goes down'), this.depths, this.turns = label(this.spindle, ' spindle on (a drill; not for glue or a gripper)'), this.act, this.output, this.ms),
			h('fieldset', {}, h('legend', {}, 'Align to the workpiece'),
				h('span', { className: 'soft' }, 'One taught point shifts the drawing, two turn it, three show whether it is mirrored.'),
				this.frame, action('Add a taught point', () => this.#pair(), { id: 'add-pair' }), label(this.mirrored, ' mirrored (seen from below)'), this.listed),
			h('div', { className: 'foot' }, this.live, this.words, bar(action('Show the script', () => this.#make(true), { id: 'show-pattern' }),
				action('Insert at the caret', () => this.#insert(), { id: 'insert-pattern', className: 'main' }), action('As a new script', () => this.#fresh(), { id: 'new-pattern' }))),
			this.result);
		this.#shaped();
	}
	#here(names, letters) {
		const all = [names].flat();
		return action('Here', async () => (await this.#place([...letters])).forEach((value, n) => { this.fields[all[n]].value = value; }),
			{ ariaLabel: `Here: ${[...letters].join(' and ')} of the present place` });
	}
	async #place(letters) {
		const place = await this.link.ask('place');
		return letters.map(letter => {
			const axis = this.machine.machine?.axes.find(own => own.axis === letter);
			if (!axis) throw new Error(`the machine has no axis ${letter}`);
			return +(place[letter] * axis.step_mm).toFixed(3);
		});
	}
	#shaped() {
		for (const [name, box] of Object.entries(this.boxes)) box.hidden = name !== this.shape.value;
		this.depths.hidden = this.turns.hidden = !this.down.checked;
		this.begin(this.machine.machine);
		this.ms.hidden = this.act.value === 'nothing';
		this.output.hidden = this.act.value !== 'pulse';
	}
	// Begins within the machine's travel: the pattern round its middle, the surface below Z's upper end.
	// What a person wrote or took from the machine stays.
	begin(machine) {
		if (!machine) return;
		const of = letter => machine.axes.find(own => own.axis === letter), set = (name, value) => {
			const field = this.fields[name];
			if (field.value === field.dataset.own) field.value = field.dataset.own = String(+value.toFixed(3));
		};
		const size = { grid: ['columns', 'pitch_x', 'rows', 'pitch_y'], line: ['way_x', 'way_y'] }[this.shape.value] ?? [];
		const [a, b, c, d] = size.map(name => parsed(this.fields[`${this.shape.value}_${name}`].value) ?? 0);
		const wide = { grid: [(a - 1) * b, (c - 1) * d], line: [a, b] }[this.shape.value] ?? [0, 0];
		['X', 'Y'].forEach((letter, n) => { const own = of(letter); if (own) set(letter.toLowerCase(), (own.low + own.high - wide[n]) / 2); });
		const z = of('Z');
		if (!z) { this.down.checked = false; this.depths.hidden = this.turns.hidden = true; return; }
		// Where Z counts downward its upper end is the lower number.
		const room = Math.min(10, (z.high - z.low) / 3);
		set('surface', z.down ? z.low + room : z.high - room);
	}
	#told(error) {
		text(this.words, error.message);
		this.words.className = 'bad';
		this.result.hidden = true;
	}
	async #read() {
		const [file] = this.file.files;
		if (!file) return;
		this.points = [];
		this.groups.replaceChildren();
		if (file.size > LARGEST) throw new Error(`${file.name} is too large for a list of points`);
		const list = await this.link.ask({ points: { name: file.name, text: await file.text() } });
		this.points = list.points;
		const groups = [...new Set(list.points.map(point => point.group))];
		// The two sides of a board are not placed at a time.
		const sides = groups.every(group => ['top', 'bottom'].includes(group.toLowerCase()));
		if (groups.length > 1) {
			this.groups.append(...groups.map(group => label(h('input', { type: 'checkbox', checked: !sides || group === groups[0], value: group }), ` ${group || 'others'}`)));
		}
		this.fields.x.value = this.fields.y.value = 0;
		this.listed.replaceChildren(...list.points.filter(point => point.name).slice(0, 500).map(point => h('option', { value: point.name })));
		this.words.className = '';
		text(this.words, [`${file.name}: ${list.what}, ${list.points.length} points.`, ...list.notes].join(' '));
	}
	// A taught point: where it was drawn, or its name in the list, and where the machine found it.
	#pair() {
		if (this.pairs.length >= 8) return;
		const place = (label, value = '') => numberField({ value, ariaLabel: label });
		const n = this.pairs.length + 1;
		const pair = { drawn: [place(`Drawn X of point ${n}`), place(`Drawn Y of point ${n}`)], taught: [place(`Taught X of point ${n}`), place(`Taught Y of point ${n}`)] };
		const name = h('input', { list: 'listed', placeholder: 'point', ariaLabel: `Name of taught point ${n}`, className: 'new', onchange: e => {
			const found = this.points.find(point => point.name === e.target.value);
			if (found) pair.drawn.forEach((own, k) => { own.value = found.at[k] / 1000; });
		} });
		pair.box = h('div', { className: 'pair' }, name, 'drawn X ', pair.drawn[0], 'Y ', pair.drawn[1], 'is at X ', pair.taught[0], 'Y ', pair.taught[1],
			action('Here', async () => (await this.#place(['X', 'Y'])).forEach((value, k) => { pair.taught[k].value = value; }), { ariaLabel: `Taught point ${n} is here` }),
			action('✕', () => { pair.box.remove(); this.pairs = this.pairs.filter(own => own !== pair); }, { ariaLabel: `Taught point ${n} out` }));
		this.pairs.push(pair);
		this.frame.append(pair.box);
	}
	#wish() {
		const of = name => number(this.fields[name]), count = name => number(this.fields[name], { whole: true });
		const kind = this.shape.value, f = name => of(`${kind}_${name}`), whole = name => count(`${kind}_${name}`);
		const shape = {
			grid: () => ({ count: [whole('columns'), whole('rows')], pitch: [um(f('pitch_x')), um(f('pitch_y'))], zigzag: this.zigzag.checked }),
			circle: () => ({ count: whole('count'), diameter: um(f('diameter')), first_mdeg: um(f('first')) }),
			line: () => ({ count: whole('count'), way: [um(f('way_x')), um(f('way_y'))] }),
			sockets: () => ({ count: whole('count'), apart: um(f('apart')), pins: whole('pins'), pitch: um(f('pitch')), rows: um(f('row')) }),
			points: () => {
				const out = [...this.groups.querySelectorAll('input:not(:checked)')].map(own => own.value);
				return this.points.filter(point => !out.includes(point.group));
			},
		}[kind]();
		const ms = () => count('ms');
		const act = { nothing: () => 'nothing', wait: () => ({ wait: { ms: ms() } }), pulse: () => ({ pulse: { output: count('output'), ms: ms() } }) }[this.act.value]();
		const down = this.down.checked ? { surface: um(of('surface')), depth: um(of('depth')), clear: um(of('clear')), feed: um(of('feed')) } : null;
		const place = pair => ({ drawn: pair.drawn.map(micrometres), taught: pair.taught.map(micrometres) });
		return { shape: { [kind]: shape }, origin: [um(of('x')), um(of('y'))], work: { down, act, spindle: this.down.checked && this.spindle.checked }, name: this.name.value.trim(),
			frame: this.pairs.length ? { pairs: this.pairs.map(place), mirrored: this.mirrored.checked } : null };
	}
	#soon() {
		clearTimeout(this.waiting);
		this.waiting = setTimeout(() => this.#preview(), SOON);
	}
	// The points on the drawing, as one types. What is half typed shows none, and nothing is said of it.
	async #preview() {
		const turn = this.turn = (this.turn ?? 0) + 1;
		let made = null, z = 0;
		if (document.body.dataset.tab === 'pattern') {
			try {
				made = await this.link.ask({ pattern: { pattern: this.#wish(), into: false } });
				z = this.down.checked ? number(this.fields.surface) : 0;
			} catch { made = null; }
		}
		if (turn !== this.turn) return;
		const outside = made?.notes.filter(note => note.includes('outside')) ?? [];
		this.view?.show('spots', made?.places.map(([x, y]) => [x / 1000, y / 1000, z]) ?? []);
		text(this.live, made ? [`${made.count} points, ringed on the drawing.`, ...outside.map(note => `${note}.`)].join(' ') : '');
		this.live.className = outside.length ? 'bad' : 'soft';
	}
	async #make(whole) {
		try {
			await this.script.sync();
			const made = await this.link.ask({ pattern: { pattern: this.#wish(), into: !whole } });
			const outside = made.notes.some(note => note.includes('outside'));
			this.words.className = outside ? 'bad' : '';
			text(this.words, [`${made.count} points.`, ...made.notes.map(note => `${note}.`)].join(' '));
			text(this.result, made.text);
			this.result.hidden = false;
			return made;
		} catch (error) {
			this.#told(error);
			return null;
		}
	}
	async #insert() {
		const made = await this.#make(false);
		if (!made) return;
		const { editor } = this.script;
		const at = editor.last === undefined ? editor.value.length : editor.lines[editor.line(editor.last)];
		editor.replace(at, at, at > 0 && editor.value[at - 1] !== '\n' ? `\n${made.text}` : made.text);
		await this.script.sync();
		tell('It is in the script; Ctrl+Z takes it out again.');
	}
	async #fresh() {
		const made = await this.#make(true);
		const name = made && prompt('Name of the new script', `${this.name.value.trim()}.bas`);
		if (!name) return;
		await this.script.sync();
		await this.link.ask({ new: { name, text: made.text } });
		tell(`${name} is open.`);
	}
}
