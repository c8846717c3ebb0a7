// The run on the board: program, run control, breakpoints, variables, what is printed, faults.
import { h, $, text, tell, action, lamp, refused, time, hear } from './dom.js';
import { Chart } from './chart.js';
import { number, numberField } from './fields.js';

const WORDS = {
	empty: 'no program', ready: 'ready', running: 'running', paused: 'paused', fault: 'fault',
	waitstart: 'waits for Start', stopping: 'stopping', unknown: 'unknown',
};

export class Run {
	program = null; state = null;
	broken = () => false;
	// The machine's axes; time that a job of which `count` of `all` statements were begun takes by its simulation, us, or
	// null; what to mark on the drawing: places in mm.
	axes = () => []; rest = () => null; mark = () => {};

	constructor(link, editor, script, faults) {
		Object.assign(this, { link, editor, script });
		this.faults = faults;
		this.chart = new Chart($('#chart'));
		const ask = wish => () => link.ask(wish);
		const lines = () => [...editor.breaks].map(line => line + 1);
		$('#run-buttons').append(
			action('Start', () => this.start(), { id: 'start', className: 'main' }),
			action('Start what is stored', () => this.begin(), { id: 'start-stored', hidden: true }),
			action('Upload', () => this.upload(), { id: 'upload', title: 'Compile the script and bring it to the board' }),
			action('Stream', () => this.stream(), { id: 'stream', title: 'Feed the script to the board piece by piece, however long it is; nothing is stored' }),
			action('Pause', ask('pause'), { id: 'pause' }),
			action('Resume', ask('resume'), { id: 'resume' }),
			action('Debug', () => link.ask({ debug: { breaks: lines(), step: false } }), { id: 'debug', title: 'Start, and halt at breakpoints' }),
			action('Step', () => this.state?.picture.followed ? link.ask({ go: { step: true } })
				: link.ask({ debug: { breaks: lines(), step: true } }), { id: 'step', title: 'To the next effect' }),
			action('Continue', () => link.ask({ go: { step: false } }), { id: 'go' }));
		editor.broken = () => { if (this.state?.picture.followed) link.say({ breaks: lines() }); };
		for (const [id, n] of [['#feed', 0], ['#rapid', 1]]) {
			hear($(id), 'change', async () => {
				const both = [+$('#feed').value, +$('#rapid').value];
				this.setting = performance.now();
				try { await link.ask({ override: both }); } catch (error) { refused(error); }
			});
			hear($(id), 'input', () => { this.setting = performance.now(); text($(`${id}-value`), `${$(id).value} %`); });
			this.setting = n;
		}
		hear($('#freeze'), 'click', e => {
			const on = e.target.ariaPressed !== 'true';
			e.target.ariaPressed = String(on);
			this.chart.freeze(on);
		});
		hear($('#export'), 'click', () => {
			const url = URL.createObjectURL(new Blob([this.chart.csv()], { type: 'text/csv' }));
			h('a', { href: url, download: `${(script.file ?? 'run').replace(/\.\w+$/, '')}.csv` }).click();
			setTimeout(() => URL.revokeObjectURL(url), 10000);
		});
		for (const [id, run] of [['#show-way', () => this.#way()], ['#go-way', () => this.#goOn()]]) hear($(id), 'click', () => run().catch(refused));
		hear($('#from-line'), 'input', () => this.#lost());
		hear($('#clear'), 'click', () => $('#console').replaceChildren());
		hear(link, 'program', e => this.#program(e.detail));
		hear(link, 'log', e => this.#log(e.detail));
		hear(link, 'progress', e => this.#progress(e.detail.part));
	}
	async upload() {
		await this.script.sync();
		try {
			const program = await this.link.ask('upload');
			tell('The program is on the board.');
			return program;
		} catch (error) {
			$('#write-machine').hidden = !error.message.includes('Write machine');
			throw error;
		} finally { $('#upload-bar').hidden = true; }
	}
	async stream() {
		await this.script.sync();
		await this.#fed('stream');
	}
	async #fed(wish) {
		try { tell(await this.link.ask(wish)); } catch (error) {
			const [, line] = /in line (\d+)/.exec(error.message) ?? [];
			if (line) { $('#from-line').value = line; $('#middle').open = true; }
			throw error;
		}
	}
	// How the board comes to where a job goes on: told and ringed on the drawing before anything moves.
	async #way() {
		this.#lost();
		await this.script.sync();
		const line = number($('#from-line'), { whole: true }), { way, legs } = await this.link.ask({ stream_from: { line } });
		this.seen = { line, way };
		const at = this.axes().reduce((list, axis) => ({ ...list, [axis.axis]: this.state.picture.status.pos[axis.axis] * axis.step_mm }), { X: 0, Y: 0, Z: 0 });
		this.mark(legs.map(leg => ['X', 'Y', 'Z'].map((letter, n) => at[letter] = leg[n] === null ? at[letter] : leg[n] / 1000)));
		text($('#way-words'), `${way ? `With its outputs off it goes there first, ringed on the drawing: ${way} (machine positions).` : 'It stands there already.'} Then the outputs are as the job has them, and line ${line} begins.`);
		$('#go-way').hidden = false;
	}
	async #goOn() {
		const { seen } = this;
		this.#lost();
		await this.script.sync();
		await this.#fed({ stream_from: seen });
	}
	#lost() {
		this.seen = null;
		this.mark([]);
		text($('#way-words'), '');
		$('#go-way').hidden = true;
	}
	// The main button: what it is called is what it does.
	async start() {
		const { status } = this.state.picture;
		if (status.state !== 'ready' && status.state !== 'empty') await this.link.ask('start');
		else if (this.#isText()) await this.begin();
		else await this.begin(await this.upload());
	}
	async begin(program) {
		const { program_bytes: bytes, program_crc: crc } = this.state.picture.identity;
		await this.link.ask({ run: program ?? { bytes, crc } });
	}
	#isText() { return this.state.current && this.script.synced; }
	#badge() {
		const { holds, picture } = this.state, badge = $('#badge');
		const name = holds?.name?.replace(/\.bas$/i, ''), own = this.script.file?.replace(/\.bas$/i, '');
		const is = this.#isText();
		const words = !picture.identity ? '' : !holds ? 'The board holds no program.'
			: is ? `Board: ${name ?? 'this text'}, as it stands here`
			: !holds.known ? `Board: ${name ?? 'a program that is not known here'}`
			: name === own ? `Board: ${name ?? 'this script'}, older than this text` : `Board: ${name ?? 'another program'}, not this text`;
		text(badge, words);
		badge.hidden = !words;
		lamp(badge, is, 'same');
		text($('#start-stored'), name && !is && name !== own ? `Start ${name}` : 'Start what is stored');
		return is;
	}
	#job(job, own) {
		const bar = $('#upload-bar');
		if (!job && !this.fed) return;
		this.fed = !!job;
		if (!job) this.begun = null;
		bar.hidden = !job;
		bar.ariaLabel = job ? 'Streamed job' : 'Upload';
		// Without a number of all statements nothing says how far it is.
		if (job?.all) bar.value = job.count / job.all; else bar.removeAttribute('value');
		const left = job?.all ? this.#left(job, own) : null;
		text($('#job'), job ? `streamed: line ${job.line}${own ? '' : ' of another text'}` + (job.all ? `, ${Math.floor(job.count / job.all * 100)} %` : `, ${job.count} statements`) + (left === null ? '' : `, about ${time(left)} left`) : '');
	}
	// By the simulation, or where that has not all of it by what was done until now; us.
	#left(job, own) {
		const now = performance.now();
		if (!this.begun || job.count < this.begun.count) this.begun = { now, count: job.count };
		const done = job.count - this.begun.count, rest = own ? this.rest(job) : null;
		return rest !== null ? rest * 100 / (this.state.picture.overrides[0] || 100) : done > 0 ? (now - this.begun.now) * 1000 / done * (job.all - job.count) : null;
	}
	#progress(part) {
		$('#upload-bar').hidden = part >= 1;
		$('#upload-bar').value = part;
	}
	#program(program) {
		if (program && this.program && program.crc === this.program.crc) return;
		this.program = program;
		this.rows = (program?.vars ?? []).flatMap(v => Array.from({ length: Math.min(v.len, 16) }, (_, n) => {
			const name = v.array ? `${v.name}(${n})` : v.name;
			// What the operator's page asks for has the script's own words and range here, too.
			const { label, low, high } = v.operator ? v : {}, range = low > -(2 ** 31) || high < 2 ** 31 - 1;
			const value = numberField({ whole: true, ariaLabel: name, onchange: e => this.#set(v.cell + n, e.target, range ? [label, low, high] : null) });
			const about = [label && label !== v.name ? label : '', range ? `${low} to ${high}` : ''].filter(Boolean).join(', ');
			const plot = h('input', { type: 'checkbox', ariaLabel: `Plot ${name}`, onchange: e => this.#plot(name, e.target.checked) });
			const row = h('tr', {}, h('td', {}, plot), h('th', { scope: 'row' }, name), h('td', {}, value, ' ', v.unit), h('td', { className: 'soft' }, about));
			return { name, cell: v.cell + n, value, row };
		}));
		$('#vars').replaceChildren(...this.rows.map(row => row.row));
		$('#vars-box').hidden = !this.rows.length;
	}
	async #set(cell, input, limits) {
		try {
			const value = number(input, { whole: true });
			if (limits && !(value >= limits[1] && value <= limits[2])) throw new Error(`${limits[0]}: ${limits[1]} to ${limits[2]}`);
			if (value < -(2 ** 31) || value >= 2 ** 31) throw new Error('A variable is a whole number of 32 bits.');
			await this.link.ask({ set: { cell, value } });
		} catch (error) { refused(error); }
		// What the board holds stands in the field again.
		input.blur();
	}
	#log(entries) {
		const list = $('#console'), near = list.scrollTop + list.clientHeight > list.scrollHeight - 30;
		for (const entry of entries) {
			const kind = Object.keys(entry)[0], value = entry[kind];
			if (kind === 'print') list.append(h('li', {}, value));
			else if (kind === 'begun') list.append(h('li', { className: 'soft' }, `run ${value} begins`));
			else if (kind === 'port') { list.append(h('li', { className: 'soft' }, value)); }
			else if (kind === 'effect' && value.ev !== 'print') {
				list.append(h('li', { className: 'soft' }, `line ${value.line}: ${effect(value)}`));
			}
		}
		while (list.children.length > 1000) list.firstChild.remove();
		if (near) list.scrollTop = list.scrollHeight;
	}
	show(state) {
		this.state = state;
		const { picture } = state, { status } = picture;
		const active = ['running', 'paused', 'waitstart', 'stopping'].includes(status?.state);
		const halted = picture.halted;
		const line = halted ? halted.next || halted.behind : state.stream?.line ?? state.line;
		// What is fed may be another text than this one by now.
		const fed = state.stream?.number === this.script.number && this.script.synced;
		text($('#run-state'), !status ? 'no board' : halted ? (halted.exact ? `halted before line ${halted.next}` : `halted behind line ${halted.behind}`)
			: WORDS[status.state] + (line ? ` · line ${line}` : '')
			+ (!active && status.last_end && status.state === 'ready' ? ` · last run: ${status.last_end}` : ''));
		lamp($('#run-state'), status?.state === 'running', 'on');
		this.#job(state.stream, fed);
		const is = this.#badge();
		this.#line(active && (state.stream ? fed : is) ? line : null);
		const may = state.mine && status;
		const set = (id, on, label) => {
			$(id).disabled = !on;
			if (label) text($(id), label);
		};
		set('#upload', may && !active);
		set('#stream', may && !active && !this.broken());
		set('#show-way', may && !active && !this.broken());
		set('#go-way', may && !active && this.script.synced);
		const rests = status?.state === 'ready' || status?.state === 'empty';
		set('#start', may && (!active || status.state === 'waitstart') && !(rests && !is && this.broken()),
			status?.state === 'fault' ? 'Acknowledge' : rests && !is ? 'Upload and start' : 'Start');
		set('#start-stored', may && status.state === 'ready');
		$('#start-stored').hidden = is || status?.state !== 'ready' || !state.holds;
		$('#upload').title = this.broken() ? 'The script has errors: see Problems' : 'Compile the script and bring it to the board';
		set('#pause', may && status.state === 'running');
		set('#resume', may && status.state === 'paused');
		set('#debug', may && !active && is && status.state === 'ready');
		set('#step', may && is && (halted || !active && status.state === 'ready'));
		set('#go', may && !!halted);
		this.#overrides(picture.overrides, may);
		this.#fault(status);
		this.#motion(status);
		this.#values(picture.cells);
	}
	#line(line) {
		this.runs = !!line;
		if (line && line !== this.shown) {
			this.editor.run(line - 1);
			if (document.activeElement !== this.editor.text) this.editor.reveal(line - 1);
		} else if (!line && this.shown) this.editor.run(-1);
		this.shown = line;
	}
	#overrides([feed, rapid], may) {
		$('#overrides').disabled = !may || !feed;
		if (!feed || performance.now() - this.setting < 1000) return;
		for (const [id, value] of [['#feed', feed], ['#rapid', rapid]]) {
			$(id).value = value;
			text($(`${id}-value`), `${value} %`);
		}
	}
	#fault(status) {
		const card = $('#fault');
		const key = status && (status.state === 'fault' || status.last_end === 'fault') && status.fault
			? `${status.fault}/${status.line}/${status.input}/${status.state}` : '';
		card.hidden = !key && !status?.blocked_by;
		if (card.dataset.key === key + (status?.blocked_by ?? '')) return;
		card.dataset.key = key + (status?.blocked_by ?? '');
		const known = this.faults.find(fault => fault.code === status?.fault);
		const where = [];
		const line = status?.line || this.state.line;
		if (key && line) where.push(h('button', { onclick: () => this.editor.show(line) }, `Line ${line}`));
		if (key && status.input) where.push(` Input ${status.input} caused it.`);
		card.replaceChildren(
			key ? h('p', {}, h('b', {}, `${status.fault}: ${status.text}. `), `${known?.cause ?? ''} `, h('i', {}, known?.remedy ?? ''), ' ', ...where) : '',
			!status?.blocked_by ? '' : h('p', {}, status.blocked_by === 255 ? 'The board was never told how it is wired: pasapas profile set FILE says so.'
				: `Input ${status.blocked_by} keeps Start or a move from working.`));
	}
	#plot(name, on) {
		this.chart.show(name, on);
		$('#plot-tools').hidden = $('#chart').hidden;
	}
	// Places and speeds of the axes, to be plotted beside the variables.
	#motion(status) {
		const axes = this.axes(), key = axes.map(axis => axis.axis).join();
		if (key !== this.plotted) {
			this.plotted = key;
			$('#plot-axes').replaceChildren(key ? 'Plot ' : '', ...axes.flatMap(({ axis }) => [`${axis} mm`, `${axis} mm/s`]).map(name =>
				h('label', {}, h('input', { type: 'checkbox', ariaLabel: `Plot ${name}`, onchange: e => this.#plot(name, e.target.checked) }), ` ${name} `)));
		}
		const now = performance.now(), before = this.was, long = now - (before?.now ?? 0);
		if (!status || before && long < 150) return;
		this.was = { now, pos: status.pos };
		for (const { axis, step_mm } of axes) {
			this.chart.add(`${axis} mm`, +(status.pos[axis] * step_mm).toFixed(3));
			if (before && long < 2000) this.chart.add(`${axis} mm/s`, +((status.pos[axis] - before.pos[axis]) * step_mm / long * 1000).toFixed(1));
		}
	}
	#values(cells) {
		for (const row of this.rows ?? []) {
			const value = cells[row.cell];
			// The map of registers ends somewhere: what lies beyond is not known, and not 0.
			if (row.value.disabled !== (value === undefined)) {
				row.value.disabled = value === undefined;
				row.value.placeholder = value === undefined ? 'not readable' : '';
			}
			if (document.activeElement !== row.value && row.value.value !== String(value ?? '')) row.value.value = value ?? '';
			if (value !== undefined) this.chart.add(row.name, value);
		}
		this.chart.draw();
	}
}

function effect(e) {
	const to = e.to ? Object.entries(e.to).map(([axis, steps]) => `${axis} ${steps}`).join(' ') : '';
	switch (e.ev) {
		case 'move': return `${e.kind} to ${to} st`;
		case 'home': return `home ${e.axis} ${e.ok ? `at ${e.pos}` : 'failed'}`;
		case 'out': return `output ${e.n} ${e.v ? 'on' : 'off'}`;
		case 'wait': return `wait ${e.ms} ms`;
		case 'waitin': return `input ${e.n} ${e.ok ? 'came' : 'did not come'}`;
		case 'probe': return `probe ${e.axis} ${e.ok ? `at ${e.pos}` : 'met nothing'}`;
		case 'end': return `end: ${e.status}${e.fault ? ` ${e.fault} ${e.text}` : ''}`;
		default: return e.ev;
	}
}
