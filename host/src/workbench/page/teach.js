// Points by jogging: rows of a TABLE of the script, recorded, named, corrected, put in another order,
// and tried one by one. Each change is written into the script at once, one step of undo each.
import { h, text, tell, action, refused, hear, bar } from './dom.js';
import { micrometres, numberField } from './fields.js';

export class Teach {
	tables = []; name = ''; rows = []; letters = []; #due = null; #busy = false; #tail = Promise.resolve();

	constructor(link, machine, script) {
		Object.assign(this, { link, machine, script });
		this.choice = h('select', { id: 'table', ariaLabel: 'Table of points', onchange: () => this.#choose(this.choice.value) });
		this.list = h('ol', { ariaLabel: 'Points' });
		this.head = h('div', { className: 'head soft', ariaHidden: 'true', hidden: true });
		this.words = h('p', { className: 'soft' });
		this.label = h('input', { id: 'point-name', className: 'new', placeholder: 'name', ariaLabel: 'Name of the next point', maxLength: 60 });
		document.getElementById('teach').append(
			bar(this.choice, action('New table', () => this.#fresh(), { id: 'new-table' })),
			bar(this.label, action('Record this place', () => this.#record(), { id: 'record', className: 'main' })),
			this.words, this.head, this.list);
		hear(document, 'tab', () => this.#picture());
		hear(this.label, 'keydown', e => { if (e.key === 'Enter') this.#record().catch(refused); });
		hear(script, 'synced changed', () => this.#later());
		machine.jog.arrived = () => tell('There.');
	}
	#later() {
		clearTimeout(this.#due);
		this.#due = setTimeout(() => this.#read().catch(() => {}), 300);
	}
	async #read() {
		if (!this.script.synced || this.#busy) return;
		this.tables = (await this.link.ask('tables')).filter(own => own.columns === this.#columns() || own.rows.length);
		const names = this.tables.map(own => own.name);
		if (!names.includes(this.name) && (this.rows.length || !this.name)) this.name = names[0] ?? 'points';
		this.#options();
		this.#choose(this.name);
	}
	#options() {
		const names = this.tables.map(own => own.name);
		if (!names.includes(this.name)) names.push(this.name);
		this.choice.replaceChildren(...names.map(name => h('option', { value: name }, name)));
		this.choice.value = this.name;
	}
	#columns() { return Math.min(3, this.machine.machine?.axes.length ?? 3); }
	#choose(name) {
		const own = this.tables.find(table => table.name === name);
		this.name = name;
		this.columns = own?.columns ?? this.#columns();
		this.remark = own?.remark ?? '';
		this.letters = (this.machine.machine?.axes ?? []).map(axis => axis.axis).slice(0, this.columns);
		const rows = own?.rows ?? [];
		if (JSON.stringify(rows) !== JSON.stringify(this.rows) || !this.list.children.length) { this.rows = rows; this.#draw(); } else this.#picture();
		text(this.words, rows.length ? '' : `No points yet: jog to a place and record it. They become TABLE ${name} of the script.`);
	}
	#fresh() {
		const name = prompt('Name of the table', this.tables.some(own => own.name === 'points') ? 'points_2' : 'points');
		if (!name) return;
		this.name = name.trim();
		this.#options();
		this.#choose(this.name);
	}
	// Where the machine stands, um; while it moves it says so.
	async place() {
		const place = await this.link.ask('place');
		return this.letters.map(letter => {
			const axis = this.machine.machine.axes.find(own => own.axis === letter);
			return Math.round(place[letter] * axis.step_mm * 1000);
		});
	}
	async #record() {
		const at = await this.place();
		const loose = this.letters.filter(letter => !this.link.state.picture.status.homed.includes(letter));
		if (loose.length) tell(`${loose.join(', ')} not homed: this place counts from where the machine was switched on.`, true);
		const name = this.label.value.trim();
		await this.#edit(rows => [...rows, { name, at }]);
		this.label.value = '';
	}
	#edit(change) {
		const done = this.#tail.then(() => this.#write(change(this.rows)));
		this.#tail = done.catch(() => {});
		return done;
	}
	async #write(rows) {
		this.#busy = true;
		try {
			await this.script.sync();
			if (!rows.length) throw new Error('a table keeps one point at least: take the TABLE out of the script instead');
			const made = await this.link.ask({ table: { name: this.name, columns: this.columns, remark: this.remark, rows } });
			if (made.number !== this.script.number || !this.script.synced) throw new Error('the script was changed meanwhile: once more');
			const { editor } = this.script, focus = document.activeElement;
			editor.replace(made.start, made.end, made.text);
			focus?.focus({ preventScroll: true });
			this.rows = rows;
			this.#draw();
			await this.script.sync();
		} catch (error) {
			this.#draw();
			throw error;
		} finally { this.#busy = false; }
		await this.#read();
	}
	#swap(n, by) {
		return this.#edit(old => {
			const rows = [...old];
			[rows[n], rows[n + by]] = [rows[n + by], rows[n]];
			return rows;
		});
	}
	#picture() {
		const places = document.body.dataset.tab !== 'machine' ? [] : this.rows.map((row, n) => ({
			name: row.name || String(n + 1), at: ['X', 'Y', 'Z'].map(letter => (row.at[this.letters.indexOf(letter)] ?? 0) / 1000) }));
		this.view?.show('taught', places);
	}
	// Whoever goes through the list by keyboard stays where they are.
	#draw() {
		this.#picture();
		const at = this.list.contains(document.activeElement) ? document.activeElement.ariaLabel : null;
		this.#rows();
		if (at) [...this.list.querySelectorAll('input, button')].find(own => own.ariaLabel === at)?.focus();
	}
	#rows() {
		this.head.replaceChildren(...['name', ...this.letters.map(letter => `${letter} mm`)].map(words => h('span', {}, words)));
		this.head.hidden = !this.rows.length;
		this.list.replaceChildren(...this.rows.map((row, n) => {
			const change = given => this.#edit(rows => rows.map((own, m) => m === n ? { ...own, ...given } : own))
				.catch(refused);
			const what = row.name || `point ${n + 1}`;
			const name = h('input', { className: 'name', value: row.name, ariaLabel: `Name of point ${n + 1}`, maxLength: 60,
				onchange: e => change({ name: e.target.value.trim() }) });
			const places = row.at.map((um, k) => numberField({ value: um / 1000,
				ariaLabel: `${this.letters[k] ?? 'Column'} of ${what}, mm`, onchange: e => {
					let value;
					try { value = micrometres(e.target); } catch (error) { tell(error.message, true); e.target.value = um / 1000; return; }
					this.#edit(rows => rows.map((own, m) => m === n ? { ...own, at: own.at.map((old, l) => l === k ? value : old) } : own)).catch(refused);
				} }));
			const go = h('button', { ariaLabel: `Go to ${what} while held`, title: 'Goes there while it is held' }, 'Go');
			this.machine.jog.armTo(go, () => this.#way(row));
			return h('li', {}, h('div', {}, name, ...places), h('div', {}, go,
				action('Here', async () => change({ at: await this.place() }), { ariaLabel: `${what} is here`, title: 'The present place becomes this point' }),
				action('↑', () => this.#swap(n, -1), { ariaLabel: `${what} up`, disabled: n === 0 }),
				action('↓', () => this.#swap(n, 1), { ariaLabel: `${what} down`, disabled: n === this.rows.length - 1 }),
				action('✕', () => this.#edit(rows => rows.filter((_, m) => m !== n)), { ariaLabel: `${what} out`, disabled: this.rows.length === 1 })));
		}));
	}
	// X and Y first, Z up before them and down behind them: the way to a point, axis by axis.
	#way(row) {
		const { axes } = this.machine.machine, pos = this.link.state?.picture.status?.pos ?? {};
		const to = this.letters.map((letter, k) => {
			const axis = axes.find(own => own.axis === letter);
			return [letter, Math.round(row.at[k] / 1000 / axis.step_mm)];
		});
		const z = to.find(([letter]) => letter === 'Z');
		if (!z) return to;
		const axis = axes.find(own => own.axis === 'Z'), k = this.letters.indexOf('Z');
		const up = axis.down ? Math.min : Math.max;
		const top = up(...this.rows.map(own => own.at[k]), Math.round((pos.Z ?? 0) * axis.step_mm * 1000));
		return [['Z', Math.round(top / 1000 / axis.step_mm)], ...to.filter(own => own !== z), z];
	}
	show(state) {
		const { status } = state.picture;
		if (!status) return;
		[...this.list.children].forEach((item, n) => {
			const row = this.rows[n];
			const here = row && this.letters.every((letter, k) => {
				const axis = this.machine.machine.axes.find(own => own.axis === letter);
				return Math.abs(status.pos[letter] * axis.step_mm * 1000 - row.at[k]) < axis.step_mm * 1000;
			});
			if (item.classList.contains('here') !== !!here) item.classList.toggle('here');
		});
	}
}

