// The steps of the set-up: for each what it says, what it asks, and what it writes into the profile.
import { h, text, tell, action, mm, refused, label, bar } from './dom.js';
import { chips } from './chips.js';
import { micrometres as um, number as of, numberField } from './fields.js';
import { rate } from './rate.js';

const p = (...words) => h('p', {}, ...words);
const number = (label, value, given = {}) => numberField({ value, ariaLabel: label, ...given });
const plain = role => role.replaceAll('_', ' ');
const whole = field => of(field, { whole: true });
const choice = (label, values, value, given = {}) => {
	const own = h('select', { ariaLabel: label, ...given }, ...values.map(one => h('option', { value: one }, String(one).replaceAll('_', ' ') || 'none')));
	own.value = value ?? '';
	return own;
};
// Without keys that say nothing, as a person writes a profile.
const lean = list => list.map(one => Object.fromEntries(Object.entries(one).filter(([, value]) => value !== null && value !== '')));
const inputs = (profile, n, given) => {
	const old = profile.input.find(one => one.n === n) ?? { n };
	return lean([...profile.input.filter(one => one.n !== n), { ...old, ...given }].sort((a, b) => a.n - b.n));
};

export const STEPS = {
	wiring: {
		title: 'Wiring and pins',
		draw: (kit, _, id) => {
			const { profile, pins } = kit.own;
			const wiring = choice('Wiring', ['chain', 'direct'], profile.wiring, { onchange: e => kit.change({ wiring: e.target.value }).catch(error => { tell(error.message, true); }) });
			const pulse = number('Pulse, us', profile.pulse_us), setup = number('DIR before STEP, us', profile.dir_setup_us);
			return { content: [
				p('Everything switched off. Wire one thing after the other as the picture has it; what drives motors, spindle and valves stays without its own supply.'),
				bar(label('Switches and outputs ', wiring), profile.wiring === 'chain' ? 'on shift registers: 16 inputs, 16 outputs, a probe' : 'on the chip’s pins: 4 inputs, 2 outputs'),
				...chips(pins, kit.chip),
				bar(label('Drivers want pulses of ', pulse, ' us'), label('and DIR ', setup, ' us before'),
					action('Keep', () => kit.change({ pulse_us: whole(pulse), dir_setup_us: whole(setup) }))),
				bar(action('It is wired like this', () => kit.next(id, `${profile.wiring} wiring, pulses of ${profile.pulse_us} us, DIR ${profile.dir_setup_us} us before`))),
			] };
		},
	},
	link: {
		title: 'Link',
		draw: (kit, _, id) => {
			const { link } = kit.own.profile;
			const address = number('Address', link.address), speed = choice('Rate', [9600, 19200, 57600, 115200], link.rate), parity = choice('Parity', ['none', 'even', 'odd'], link.parity);
			return { content: [
				p('How the board is spoken to. Several boards on one line need an address each; long lines a slower rate.'),
				bar(label('Address ', address), label('Rate ', speed, ' bit/s'), label('Parity ', parity),
					action('Keep', () => kit.change({ link: { address: whole(address), rate: +speed.value, parity: parity.value } }))),
				p('Bring the machine to the board: that it answers again is the trial.'),
				bar(action('It answers', () => {
					if (!kit.own.applied || kit.state?.picture.port !== 'up') throw new Error('bring the machine to the board first; it has to answer');
					return kit.next(id, `address ${link.address}, ${link.rate} bit/s, parity ${link.parity}: the board answers`);
				}, { id: 'link-done' })),
			] };
		},
	},
	switches: {
		title: 'Switches and other inputs',
		draw: (kit, _, id) => {
			const { profile, references, roles, board } = kit.own;
			let wanted = null, before = [];
			const told = h('p', { role: 'status', id: 'heard' });
			const all = ['reference_x', 'reference_y', 'reference_z'].filter(role => profile[role.at(-1)]).concat(roles.inputs.filter(role => !role.startsWith('reference')));
			const where = role => profile.input.filter(one => one.role === role).map(one => `input ${one.n}${one.invert ? ', on when open' : ''}`).join(' and ')
				|| (references[role] ? `input ${references[role]} (the wiring’s)` : 'none');
			const rows = all.map(role => h('tr', {}, h('th', { scope: 'row' }, plain(role)), h('td', {}, where(role)), h('td', {},
				action('Press it…', () => { kit.must(); wanted = role; before = kit.state?.picture.status?.inputs ?? []; text(told, `Press and hold the ${plain(role)} now.`); }, { ariaLabel: `Press ${plain(role)}` }),
				profile.input.some(one => one.role === role) ? action('Take out', () => kit.change({ input: lean(profile.input.filter(one => one.role !== role)) }), { ariaLabel: `Take ${plain(role)} out` }) : '')));
			const hear = async status => {
				const on = status.inputs.filter(n => !before.includes(n)), off = before.filter(n => !status.inputs.includes(n));
				if (!wanted || !on.length && !off.length) return;
				const role = wanted;
				wanted = null;
				if (on.length + off.length > 1) { text(told, 'Several inputs changed at once: look at the wiring, and press it again.'); return; }
				const n = on[0] ?? off[0], inverted = !on.length;
				const old = profile.input.find(one => one.n === n);
				const words = `${plain(role)}: input ${n}${inverted ? ', which goes off when it is pressed: it is taken the other way round' : ''}.`;
				try {
					// What the wiring has by itself needs no entry of its own.
					const given = { role, invert: (board.find(one => one.n === n)?.invert ?? false) !== inverted };
					if (references[role] === n && !inverted && !old) tell(words);
					else { await kit.change({ input: inputs(profile, n, given) }); tell(words); }
					text(told, words);
				} catch (error) { refused(error); }
			};
			return {
				content: [p('Press each by hand, one after the other; the number of its input is found, and whether it is on when open. A normally closed emergency stop goes off when it is pressed.'),
					h('table', {}, h('tbody', {}, ...rows)), told,
					bar(action('All of them answer', () => kit.next(id, all.filter(role => where(role) !== 'none').map(role => `${plain(role)}: ${where(role)}`).join('; '))))],
				show: state => { if (state.picture.status) hear(state.picture.status); },
			};
		},
	},
	stop: {
		title: 'Emergency stop',
		draw: (kit, _, id) => {
			const letters = ['X', 'Y', 'Z'].filter(letter => kit.own.profile[letter.toLowerCase()]);
			return { content: [
				p('Motors still unplugged or the drivers off. Hold a button below, so that an axis counts, and press the emergency stop meanwhile: it must cease at once, and the board must tell F14. Only then go on.'),
				bar(...letters.flatMap(kit.pad)),
				p('Let the emergency stop go again, write down what the board told, then acknowledge the fault on the right.'),
				bar(action('It told F14', () => kit.next(id, ''), { id: 'stop-done' })),
			] };
		},
	},
	outputs: {
		title: 'Outputs and safe states',
		draw: (kit, _, id) => {
			const { profile, roles, outputs } = kit.own;
			const named = new Set(profile.output.map(one => one.n));
			const row = one => {
				const name = h('input', { value: one.name ?? '', ariaLabel: `Name of output ${one.n}`, className: 'new', maxLength: 30 });
				const role = choice(`Role of output ${one.n}`, ['', ...roles.outputs], one.role);
				const invert = h('input', { type: 'checkbox', checked: one.invert, ariaLabel: `Output ${one.n} inverted` });
				const states = ['reset', 'pause', 'fault', 'end'].map(when => choice(`Output ${one.n} at ${when}`, when === 'reset' ? ['off', 'on'] : ['off', 'on', 'keep'], one[when]));
				const keep = () => {
					const [reset, pause, fault, end] = states.map(own => own.value);
					const given = { n: one.n, name: name.value.trim(), role: role.value, invert: invert.checked, reset, pause, fault, end };
					return kit.change({ output: lean([...profile.output.filter(own => own.n !== one.n), given].sort((a, b) => a.n - b.n)) });
				};
				return h('tr', {}, h('th', { scope: 'row' }, one.n), h('td', {},
					action('On', () => kit.must().move({ output: [one.n, true] }), { ariaLabel: `Output ${one.n} on` }), action('Off', () => kit.must().move({ output: [one.n, false] }), { ariaLabel: `Output ${one.n} off` })),
				h('td', {}, name), h('td', {}, role), h('td', {}, invert), ...states.map(own => h('td', {}, own)),
				h('td', {}, action('Keep', keep, { ariaLabel: `Keep output ${one.n}` }),
					named.has(one.n) ? action('Take out', () => kit.change({ output: lean(profile.output.filter(own => own.n !== one.n)) }), { ariaLabel: `Take output ${one.n} out` }) : ''));
			};
			const free = Array.from({ length: outputs }, (_, n) => n + 1).filter(n => !named.has(n));
			const other = choice('Another output', free, free[0]);
			const body = h('tbody', {}, ...profile.output.map(row));
			const head = ['', 'try', 'name', 'role', 'inverted', 'at reset', 'in a pause', 'at a fault', 'at the end', ''].map(words => h('th', {}, words));
			return { content: [
				p('What they drive stays without its own supply at first. Switch each on and off, and say what becomes of it: an output is safe when a fault leaves nothing turning, hot or open.'),
				h('div', { className: 'wide' }, h('table', {}, h('thead', {}, h('tr', {}, ...head)), body)),
				bar(other, action('Add', () => body.append(row({ n: whole(other), reset: 'off', pause: 'keep', fault: 'off', end: 'off' })), { id: 'add-output' })),
				bar(action('Each was tried', () => kit.next(id, profile.output.map(one => `output ${one.n} ${one.name ?? one.role ?? ''}: fault ${one.fault}, end ${one.end}`).join('; ') || 'no outputs'))),
			] };
		},
	},
	direction: {
		title: 'Direction',
		draw: (kit, letter, id) => {
			const low = letter.toLowerCase(), { invert } = kit.own.profile[low];
			const step = by => kit.must(true).move({ jog: { axis: letter, um: by * 1000, speed: 1000 } });
			return { content: [
				p(`Motors on, the axis away from its ends, a hand at the emergency stop. It moves 1 mm: X plus is to the right, Y plus to the back, Z plus up, unless the machine counts otherwise.`),
				bar(action(`Move ${letter} by +1 mm`, () => step(1), { id: 'plus' }), action(`and back`, () => step(-1), { id: 'minus' })),
				bar(action('Right', () => kit.next(id, `+1 mm goes the right way${invert ? ', with DIR inverted' : ''}`), { id: 'right' }),
					action('Wrong', async () => { await kit.change({ [low]: { invert: !invert } }); tell('DIR is turned round: bring it to the board, and try again.'); }, { id: 'wrong' })),
			] };
		},
	},
	scale: {
		title: 'Steps per millimetre',
		draw: (kit, letter, id) => {
			const { scale } = kit.own.profile[letter.toLowerCase()];
			const asked = number('Asked, mm', 100, { id: 'asked' }), measured = number('Measured, mm', '', { id: 'measured' });
			const move = way => {
				const length = um(asked);
				if (Math.abs(length) > 300000) throw new Error('no more than 300 mm at a time');
				return kit.must(true).move({ jog: { axis: letter, um: way * length, speed: 3000 } });
			};
			return { content: [
				p('Mark where the axis stands, let it move, and measure how far it went: over a long way, with a rule or a dial.'),
				p(`Now: ${scale.steps} steps for ${mm(scale.um / 1000)} mm.`),
				bar(label('Asked ', asked, ' mm'), action(`Move ${letter} forward`, () => move(1), { id: 'forward' }), action('back', () => move(-1), { id: 'backward' })),
				bar(label('Measured ', measured, ' mm'), action('Take this scale', async () => {
					await kit.ask({ scale: { axis: letter, asked_um: um(asked), measured_um: um(measured) } });
					tell('Bring it to the board, and measure once more.');
				}, { id: 'take-scale' }), action('It is exact', () => kit.next(id, `${scale.steps} steps for ${mm(scale.um / 1000)} mm, measured`), { id: 'exact' })),
			] };
		},
	},
	home: {
		title: 'Reference run',
		draw: (kit, letter, id) => {
			const low = letter.toLowerCase(), own = kit.own.profile[low], { home } = own;
			const direction = choice('The switch is at', ['negative', 'positive'], home.direction);
			const fast = number('Fast, steps/s', home.fast_rate), slow = number('Slow, steps/s', home.slow_rate), stroke = number('Search at most, mm', home.stroke_um / 1000);
			const position = number('Position of the switch, mm', home.position_um / 1000), clear = number('Clearance, mm', home.clearance_um / 1000);
			const keep = () => kit.change({ [low]: { home: { direction: direction.value, fast_rate: whole(fast), slow_rate: whole(slow), stroke_um: um(stroke), position_um: um(position), clearance_um: um(clear) } } });
			return { content: [
				p(`Bring ${letter} near its switch, with a hand at Stop. It must run toward it, stop, and leave it slowly until it opens.`),
				bar(...kit.pad(letter)),
				bar(label('Switch at the ', direction, ' end'), label('fast ', fast, ' steps/s'), label('slow ', slow, ' steps/s'), label('search at most ', stroke, ' mm'),
					label('there is ', position, ' mm'), label('clearance ', clear, ' mm'), action('Keep', keep, { id: 'keep-home' })),
				bar(action(`Home ${letter}`, async () => { await kit.must(true).move({ home: [letter] }); tell(`${letter} is homed.`); }, { id: 'home' }),
					action('It homes well', () => {
						if (!kit.state?.picture.status?.homed.includes(letter)) throw new Error(`${letter} is not homed: let it run`);
						return kit.next(id, `${letter} finds its switch at the ${home.direction} end, at ${mm(home.position_um / 1000)} mm`);
					}, { id: 'home-done' })),
			] };
		},
	},
	travel: {
		title: 'Travel',
		draw: (kit, letter, id) => {
			const low = letter.toLowerCase(), own = kit.own.profile[low];
			const from = number('Lowest, mm', own.min_um / 1000, { id: 'lowest' }), to = number('Highest, mm', own.max_um / 1000, { id: 'highest' });
			const here = field => action('Here', async () => {
				if (!kit.state?.picture.status?.homed.includes(letter)) throw new Error(`home ${letter} first: travel counts from its switch`);
				field.value = (await kit.place(letter)).toFixed(2);
			}, { ariaLabel: `${field.ariaLabel} is here` });
			return { content: [
				p(`Home ${letter}, then jog it carefully to each end and take the place a little before it. Nothing limits this way but the switch and your hand.`),
				bar(action(`Home ${letter}`, () => kit.must(true).move({ home: [letter] }), { id: 'home' }), ...kit.pad(letter)),
				bar(label('Lowest ', from, ' mm'), here(from), label('Highest ', to, ' mm'), here(to)),
				bar(action('Take this travel', async () => {
					await kit.change({ [low]: { min_um: um(from), max_um: um(to) } });
					await kit.next(id, `${from.value} to ${to.value} mm`);
				}, { id: 'take-travel' })),
			] };
		},
	},
	rate: { title: 'Top rate and ramp', draw: (kit, letter, id) => rate(kit, letter, id) },
	finish: {
		title: 'Profile and report',
		draw: kit => {
			const open = kit.own.steps.filter(step => !step.done);
			const told = h('p', { role: 'status', id: 'written' });
			return { content: [
				open.length ? h('p', { className: 'todo' }, `${open.length} steps were not tried with the machine as it is now; the report says so.`) : p('Every step was tried.'),
				bar(action('Write profile and report', async () => {
					const stop = kit.own.steps.find(step => step.id === 'stop'), untried = stop && !stop.done;
					if (untried && !confirm('The emergency stop was not tried. Write the profile all the same? It will say so.')) return;
					const files = await kit.link.ask({ setup: { finish: { when: new Date().toLocaleString(), untried_stop: !!untried } } });
					text(told, `${files.profile} and ${files.report} stand beside the script: a script begins with PROFILE "${kit.own.name}", the report is for the printer.`);
				}, { id: 'write' }), action('Leave the set-up', () => kit.ask('close'), { id: 'leave' })),
				told,
			] };
		},
	},
};
