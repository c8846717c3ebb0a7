// The simulation: what the run will be, at any time of it.
import { h, $, text, time, mm, tell, lamp, lastOf, hear } from './dom.js';
import { Pulses } from './pulses.js';
import { Timeline } from './timeline.js';
import { amount } from './values.js';

// A simulation that takes longer says so, ms.
const SOON = 300;
// How long the path of the number before may stay while one is dragged, ms.
const EASE = 150;

export class Trial {
	about = null; kept = null; us = 0; playing = false; fresh = false; runs = false; event = -1;
	came = null; beside = null;
	isNewest = () => true;
	file = () => null;

	constructor(link, view, editor) {
		Object.assign(this, { link, view, editor });
		hear(link, 'simulated', e => { this.next = e.detail; });
		hear(link, 'path', e => this.#take(e.detail));
		hear(link, 'simulating', e => this.#far(e.detail));
		for (const own of ['script', 'world']) hear($(`#show-${own}`), 'click', () => this.#shows(own === 'world'));
		hear($('#play'), 'click', () => this.play(!this.playing));
		hear($('#before'), 'click', () => this.step(-1));
		hear($('#behind'), 'click', () => this.step(1));
		hear(window, 'keydown', e => {
			const by = { ',': -1, '.': 1 }[e.key];
			if (!by || e.ctrlKey || e.metaKey || e.altKey || e.target.isContentEditable || e.target.matches?.('input:not([type=range], [type=checkbox]), select, textarea')) return;
			e.preventDefault();
			this.step(by);
		});
		hear($('#compare'), 'click', e => this.compare(e.target));
		for (const button of document.querySelectorAll('[data-view]')) {
			hear(button, 'click', () => {
				view.look(button.dataset.view);
				for (const other of document.querySelectorAll('[data-view]')) other.setAttribute('aria-pressed', other === button);
			});
		}
		view.picked = (time, line) => { this.seek(time * 1e6); editor.show(line); };
		editor.moved = line => view.mark(line);
		this.pulses = new Pulses(link, () => editor.value);
		this.pulses.changed = () => { this.last = null; this.stale(); };
		this.pulses.refused = () => { this.last = this.about; this.settle(); };
		this.timeline = new Timeline(this.pulses, us => this.seek(us));
	}
	// The text was changed: what is shown is that of another one from now on, until its own comes.
	stale() {
		if (this.view.steady) this.#ease(); else this.#dim(true);
		clearTimeout(this.waiting);
		this.waiting = setTimeout(() => this.#say('simulating…'), SOON);
	}
	#dim(on) {
		clearTimeout(this.easing);
		this.easing = null;
		this.#fresh(!on);
		this.view.dim = on;
		this.view.draw();
	}
	#fresh(on) {
		this.fresh = on;
		lamp(document.body, !on, 'stale');
		this.besides();
	}
	// While a number is dragged one path follows the other: only one that stays is dimmed.
	#ease() {
		this.#fresh(false);
		this.easing ??= setTimeout(() => this.#dim(true), EASE);
	}
	// How far a long simulation is: by its furthest line, which tells most of a job without loops.
	#far(far) {
		if (!this.isNewest(far)) return;
		clearTimeout(this.waiting);
		this.#say(`simulating… line ${far.line} of ${far.lines}, ${time(far.us)} of the run`);
		$('#sim-bar').hidden = false;
		$('#sim-bar').value = far.line / far.lines;
	}
	#say(words) {
		$('#sim-bar').hidden = true;
		text($('#sim-words'), words);
		$('#sim-words').hidden = !words;
	}
	#take(buffer) {
		const about = this.last = this.next, newest = this.isNewest(about);
		if (newest) this.#newest();
		if (about.words !== undefined) {
			this.#dim(true);
			this.came?.();
			return;
		}
		if (!newest && this.view.steady) { this.#dim(false); this.#ease(); }
		this.about = about;
		this.pulses.list = about.pulses ?? [];
		this.view.machine = about.machine;
		this.view.set(buffer);
		this.#sum();
		this.#prints();
		this.#world();
		this.us = Math.min(this.us, about.us);
		this.timeline.us = this.us;
		this.timeline.set(about);
		this.seek(this.us);
		this.dispatch?.(about);
		this.came?.();
	}
	// The tool has the editor's text: its run may have come before the answer that numbers it, or long ago.
	settle() { if (this.last && !this.fresh && this.isNewest(this.last)) this.#newest(); }
	#newest() {
		const { last } = this;
		clearTimeout(this.waiting);
		this.#dim(last.words !== undefined);
		this.#say(last.words ?? '');
		// A long job without a loop is shown as far as it is known, and then all of it.
		if (last.cut && !last.turns && !last.all) {
			this.#say('simulating on…');
			this.link.say('simulate_all');
		}
		if (last === this.about) this.newest?.(last);
	}
	// What is left of the run when so much of its statements were begun, us; null where not all of it is known.
	rest(part) {
		const { about } = this, events = about?.events ?? [];
		if (!this.fresh || !events.length || about.cut || about.heard_us || about.end.status !== 'done') return null;
		return Math.max(0, about.us - events[Math.min(events.length - 1, Math.round(part * events.length))][0]);
	}
	#sum() {
		const { about, kept } = this;
		const end = about.end;
		const faulty = end.status === 'fault';
		const how = faulty ? `${end.fault} ${end.text} in line ${end.line}`
			: about.turns ? `loops on: ${about.turns[0]} turns are shown`
			: end.why === 'idle' ? `waits in line ${end.line}, see below`
			: end.status === 'stopped' ? `stops in line ${end.line}: ${about.cut && !about.all ? 'shown up to there' : end.stopped ?? ''}` : end.onward ? `ends in line ${end.line}, where RUN begins “${end.onward}”, which is tried by itself`
			: 'runs to its end';
		const more = (value, before, words) => kept && value !== before ? ` (${value > before ? '+' : '−'}${words(Math.abs(value - before))})` : '';
		const sum = list => list.reduce((all, n) => all + n, 0), whole = n => n.toLocaleString('en');
		const steps = sum(about.steps);
		const list = [
			['Time', time(about.us) + more(about.us, kept?.us, time)], ['Steps', whole(steps) + more(steps, kept && sum(kept.steps), whole)],
			['Travel', about.travel_um.map(um => mm(um / 1000, 1)).join(' / ') + ' mm' + more(sum(about.travel_um), kept && sum(kept.travel_um), um => `${mm(um / 1000, 1)} mm`)],
			['Fastest', `${mm(this.view.fastest, 1)} mm/s`],
			['Program', `${about.bytes} of ${about.room} bytes` + more(about.bytes, kept?.bytes, whole)], ['End', how],
		];
		$('#sums').replaceChildren(...list.map(([name, value]) => h('div', {}, h('dt', {}, name), h('dd', {}, value))));
		const world = (this.file() ?? 'script.bas').replace(/\.\w+$/, '.rhai');
		$('#sim-notes').replaceChildren(...[about.world, ...about.notes ?? []].filter(Boolean).map(words => h('li', {}, words)),
			about.turns ? h('li', {}, `The loop of line ${about.turns[1]} goes on after its third turn. `,
				h('button', { id: 'more', className: 'small', onclick: () => { this.#say('simulating on…'); this.link.say('simulate_all'); } }, 'More')) : '',
			...about.pulses ? this.pulses.form(about.machine) : []);
		const card = $('#sim-fault');
		const idle = end.why === 'idle';
		card.hidden = !faulty && !about.lack && !about.failures.length && !idle;
		card.replaceChildren(
			idle ? h('p', {}, h('b', {}, `Line ${end.line} waits for an input or a button, and nobody gives it in the simulation. `),
				`A world says when it comes: draw it on the input's row above, write it to ${world} beside the script, or run the program on the board. `,
				...about.pulses ? this.pulses.reads(this.editor.value.split('\n')[end.line - 1] ?? '', about.machine).map(n => h('button', { className: 'pulse',
					onclick: () => this.pulses.add(n, about.us / 1e3 + 100) }, `Input ${n} comes`)) : [], ' ',
				h('button', { onclick: () => this.editor.show(end.line) }, `Line ${end.line}`)) : '',
			faulty ? h('p', {}, h('b', {}, `${end.fault}: ${end.text}. `), `${end.cause} `, h('i', {}, end.remedy), ' ',
				h('button', { onclick: () => this.editor.show(end.line) }, `Line ${end.line}`)) : '',
			about.lack ? h('p', {}, `The ${about.part} lacks what this program wants: ${about.lack}`) : '',
			...about.failures.map(words => h('p', {}, words)));
	}
	// The script's world with what was drawn, beside the script.
	#world() {
		const [name, words] = this.about.world_file ?? [];
		$('#files').hidden = !name;
		text($('#show-script'), this.file() ?? 'Script');
		text($('#show-world'), name ?? '');
		text($('#world'), words ?? '');
		if (!name) this.#shows(false);
	}
	#shows(world) {
		$('#editor').hidden = world;
		$('#world').hidden = !world;
		$('#show-world').ariaPressed = String(world);
		$('#show-script').ariaPressed = String(!world);
	}
	#prints() {
		const prints = this.about.events.filter(event => event[2] !== null).slice(0, 500);
		$('#prints').replaceChildren(...prints.map(([us, line, words]) => h('li', {},
			h('button', { className: 'plain', onclick: () => { this.seek(us); this.editor.show(line); } },
				`${time(us)}  ${words}`))));
		$('#prints-box').hidden = !prints.length;
	}
	// Shows the run at a time, or (`k`) at an event, which others of the same time may follow.
	seek(us, k = this.#event(us)) {
		if (!this.about) return;
		this.us = us;
		this.event = k;
		const here = this.view.at(us / 1e6);
		// Of a very long run not all events are kept: what came behind them is told by the path alone.
		const line = (us < (this.about.heard_us ?? Infinity) ? this.about.events[k]?.[1] : null) ?? here?.line ?? 0;
		text($('#now'), `${time(us)} · line ${line || '?'}` + (here ? ` · ${here.place.map(p => mm(p, 2)).join(' ')} mm` : ''));
		this.timeline.slider.setAttribute('aria-valuetext', `${time(us)}, line ${line}`);
		this.view.marker = here?.place ?? null;
		this.view.draw();
		if (!this.runs) this.editor.run(us > 0 || this.playing ? line - 1 : -1);
		this.#values(us);
		this.timeline.at(us);
	}
	step(by) {
		const { about } = this;
		if (!about) return;
		if (this.playing) this.play(false);
		const k = this.event + by;
		if (about.events[k]) this.seek(about.events[k][0], k);
		else this.seek(k < 0 ? 0 : about.us, k < 0 ? -1 : about.events.length - 1);
		if (!this.runs && about.events[this.event]) this.editor.reveal(about.events[this.event][1] - 1);
	}
	#event(us) {
		const events = this.about?.events ?? [];
		return Math.max(0, lastOf(events.length, k => events[k][0] <= us));
	}
	#values(us) {
		const cells = new Map();
		for (const [at, cell, value] of this.about.changes) {
			if (at > us) break;
			cells.set(cell, value);
		}
		// Of a very long run not all changes are kept: what came behind them is not known.
		this.cells = this.about.told_us !== null && us > this.about.told_us ? null : cells;
		this.besides();
		const rows = this.about.vars.slice(0, 40).map(v => {
			const all = Array.from({ length: Math.min(v.len, 8) }, (_, n) => this.cells ? cells.get(v.cell + n) ?? 0 : null);
			return h('tr', {}, h('th', { scope: 'row' }, v.name), h('td', {}, all.map(n => n === null ? '?' : amount(n, v.unit)).join(', ')));
		});
		$('#sim-vars').replaceChildren(...rows);
		$('#sim-vars-box').hidden = !rows.length;
	}
	// Values beside the lines: of this very text, and not while the board runs it.
	besides() {
		const { about, us, cells } = this;
		this.beside?.show(this.fresh && about && !this.runs && (us > 0 || this.playing) ? { about, us, cells } : null);
	}
	play(on) {
		if (!this.about) return;
		this.playing = on;
		text($('#play'), on ? 'Pause' : 'Play');
		if (!on) return;
		if (this.us >= this.about.us) this.us = 0;
		// So many times as fast as the machine; 0: all of it within 20 s.
		const pace = +$('#pace').value || Math.max(1, this.about.us / 20e6);
		let last = performance.now();
		const next = now => {
			if (!this.playing) return;
			this.seek(Math.min(this.about.us, this.us + (now - last) * 1000 * pace));
			last = now;
			if (this.us >= this.about.us) this.play(false); else requestAnimationFrame(next);
		};
		requestAnimationFrame(next);
	}
	// Keeps the run as it is; those that come are drawn over it and counted against it.
	compare(button) {
		if (!this.about) return;
		this.kept = this.kept ? null : this.about;
		button.setAttribute('aria-pressed', !!this.kept);
		this.view.hold(!!this.kept);
		this.#sum();
		if (this.kept) tell('What is changed now is shown over this run.');
	}
}
