// The machine by hand: positions, lamps, jog, inputs and outputs.
import { h, $, text, tell, action, lamp, mm, refused, hear } from './dom.js';
import { micrometres, numberField } from './fields.js';
import { Jog } from './jog.js';

const STEPS = [[0, 'hold'], [0.01, '0.01'], [0.1, '0.1'], [1, '1'], [10, '10']];

export class Machine {
	machine = null; live = false; #step = 0; #axes = []; #inputs = []; #outputs = []; #closed = []; #folds = []; #key = '';

	constructor(link) {
		this.link = link;
		this.jog = new Jog(link, () => this.speed(), () => this.#step);
		this.jog.move = (axis, way) => this.#ask({ jog: { axis, um: Math.round(way * 1000), speed: this.speed() } });
		this.jog.refused = words => tell(words, true);
		$('#steps').append(...STEPS.map(([step, name]) => h('button', {
			ariaPressed: String(step === this.#step), onclick: e => {
				this.#step = step;
				for (const other of $('#steps').children) other.ariaPressed = String(other === e.target);
				text($('#step-words'), step ? `each press moves ${name} mm` : 'moves while held');
			} }, name)));
		hear($('#speed'), 'input', () => text($('#speed-value'), `${mm(this.speed() / 1000, 1)} mm/s`));
		$('#home-all').append(action('Home all', () => link.ask({ home: [] }), { id: 'home' }));
		hear($('#write-machine'), 'click', () => this.#ask('profile'));
	}
	// um/s: the slider goes from slow to fast by equal factors.
	speed() {
		const top = Math.max(...(this.machine?.axes ?? [{ top: 10 }]).map(axis => axis.top)) * 1000;
		return Math.max(1, Math.round(top * 10 ** (+$('#speed').value / 50 - 2) / 4));
	}
	async #ask(wish) {
		try { await this.link.ask(wish); } catch (error) { refused(error); }
	}
	build(machine, virtual) {
		const key = JSON.stringify([machine, virtual]);
		if (key === this.#key) return;
		this.#key = key;
		this.machine = machine;
		this.live = virtual;
		this.#axes = machine.axes.map(axis => this.#axis(axis));
		$('#axes').replaceChildren(...this.#axes.map(row => row.box));
		$('#tools').replaceChildren(...this.#axes.map(row => row.tools));
		$('#pad').replaceChildren(...machine.axes.flatMap(({ axis }) => [false, true].map(positive => {
			const sign = positive ? '+' : '−';
			const button = h('button', { className: `jog ${axis}${positive ? 'p' : 'm'}`,
				ariaLabel: `Jog ${axis} ${positive ? 'plus' : 'minus'}` }, `${axis}${sign}`);
			this.jog.arm(button, axis, positive);
			return button;
		})));
		this.#inputs = machine.inputs.map(input => this.#port(input, true));
		this.#outputs = machine.outputs.map(output => this.#port(output, false));
		this.#folds = [[$('#inputs'), this.#inputs], [$('#outputs'), this.#outputs]].map(([box, rows]) => this.#fold(box, rows));
		text($('#speed-value'), `${mm(this.speed() / 1000, 1)} mm/s`);
		$('#buttons').hidden = !virtual;
	}
	#axis(axis) {
		const name = axis.axis;
		const place = h('output', { className: 'place', ariaLabel: `${name} position` }, '–');
		const steps = h('span', { className: 'soft steps' });
		const lampOf = (label, title) => h('span', { className: 'lamp', title, role: 'img', ariaLabel: `${name} ${title}: off` }, label);
		const lamps = {
			homed: lampOf('H', 'homed'), low: lampOf('−', 'lower limit'), high: lampOf('+', 'upper limit'), moves: lampOf('M', 'moves'),
		};
		const go = numberField({ ariaLabel: `Go to ${name}, mm`, placeholder: 'mm' });
		const goTo = async () => this.link.ask({ go_to: { axis: name, um: micrometres(go), speed: this.speed() } });
		hear(go, 'keydown', e => { if (e.key === 'Enter' && !e.repeat) goTo().catch(refused); });
		const probe = async () => this.link.ask({ probe: { axis: name, um: micrometres($('#probe-way')), speed: this.speed() } });
		const box = h('div', { className: 'axis' },
			h('b', {}, name), place, h('span', { className: 'soft' }, 'mm'),
			h('span', { className: 'lamps' }, ...Object.values(lamps)), steps);
		const tools = h('div', { className: 'tools' }, h('b', {}, name), go, action('Go to', goTo, { ariaLabel: `Go to ${name}` }),
			action('Zero', () => this.link.ask({ zero: name }), { ariaLabel: `Zero ${name}`, title: 'The present place becomes 0' }),
			action('Home', () => this.link.ask({ home: [name] }), { ariaLabel: `Home ${name}` }),
			action('Probe', probe, { ariaLabel: `Probe ${name}` }));
		return { ...axis, box, tools, place, steps, lamps };
	}
	#port({ n, name, role }, input) {
		const label = [n, name, role].filter(Boolean).join(' ');
		const button = h('button', { className: 'port', ariaPressed: 'false',
			ariaLabel: `${input ? 'Input' : 'Output'} ${label}`,
			onclick: () => this.#press(n, input, button) }, h('i', { className: 'dot' }), label);
		return { n, button, named: !!(name || role) };
	}
	// What has a name stands first; the others are folded, and the fold says which of them are on.
	#fold(box, rows) {
		const open = box.querySelector('details')?.open, others = rows.filter(row => !row.named);
		const words = h('summary', {});
		box.replaceChildren(...rows.filter(row => row.named).map(row => row.button),
			others.length ? h('details', { className: 'more', open: !!open }, words, h('div', { className: 'ports' }, others.map(row => row.button))) : '');
		return { words, others };
	}
	#press(n, input, button) {
		if (!input) { this.#ask({ output: [n, button.ariaPressed !== 'true'] }); return; }
		if (this.live) { this.#ask({ input: [n, !this.#closed.includes(n)] }); return; }
		// A real input: forced on, forced off, free again.
		const next = { undefined: true, on: false, off: null }[button.dataset.forced];
		button.dataset.forced = { true: 'on', false: 'off', null: '' }[next];
		if (next === null) delete button.dataset.forced;
		this.#ask({ input: [n, next] });
	}
	show(state) {
		const { picture } = state, { status } = picture;
		this.#closed = state.closed;
		const may = state.mine && status;
		$('#by-hand').disabled = !may;
		if (!status) return;
		this.#axes.forEach(row => {
			const n = 'XYZ'.indexOf(row.axis);
			text(row.place, mm(picture.work[n] * row.step_mm));
			const machine = status.pos[row.axis] ?? 0;
			text(row.steps, `${picture.work[n]} st · machine ${mm(machine * row.step_mm, 2)}`);
			const set = (name, on) => {
				lamp(row.lamps[name], on);
				const label = `${row.axis} ${row.lamps[name].title}: ${on ? 'on' : 'off'}`;
				if (row.lamps[name].ariaLabel !== label) row.lamps[name].ariaLabel = label;
			};
			set('homed', status.homed.includes(row.axis));
			set('low', picture.at_low.includes(row.axis));
			set('high', picture.at_high.includes(row.axis));
			set('moves', status.moving.includes(row.axis));
		});
		const lamps = (rows, on) => rows.forEach(row => {
			const is = on.includes(row.n);
			if (row.button.ariaPressed !== String(is)) row.button.ariaPressed = String(is);
			lamp(row.button, is);
		});
		lamps(this.#inputs, status.inputs);
		lamps(this.#outputs, status.outputs);
		this.#folds.forEach(({ words, others }, k) => {
			const on = others.map(row => row.n).filter(n => (k ? status.outputs : status.inputs).includes(n));
			text(words, `${others.length} without a name${on.length ? `, on: ${on.join(', ')}` : ''}`);
		});
		this.#inputs.forEach(row => lamp(row.button, this.#closed.includes(row.n), 'closed'));
	}
	place(state) {
		const { status } = state.picture;
		if (!status || !this.machine) return null;
		return ['X', 'Y', 'Z'].map(letter => {
			const axis = this.machine.axes.find(own => own.axis === letter);
			return axis ? (status.pos[letter] ?? 0) * axis.step_mm : 0;
		});
	}
}
