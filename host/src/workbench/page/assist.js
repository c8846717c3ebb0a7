import { h, hear } from './dom.js';

const MOST = 12;
// Pause in typing after which a call's form is asked for, ms.
const FORM = 250;

export class Assist {
	#items = []; #shown = []; #at = 0; #from = 0; #wait = null; #turn = 0; #formed = null;

	constructor(editor, language) {
		Object.assign(this, { editor, language });
		this.list = h('ul', { id: 'completions', className: 'pop', role: 'listbox', hidden: true, ariaLabel: 'Completions' });
		this.hover = h('div', { className: 'pop hover', role: 'tooltip', hidden: true });
		this.sign = h('div', { id: 'signature', className: 'pop hover', role: 'status', hidden: true });
		document.body.append(this.list, this.hover, this.sign);
		hear(editor.text, 'keydown', e => this.#key(e), true);
		hear(editor.text, 'input', () => this.#typed());
		hear(editor.text, 'blur', () => { this.close(); this.sign.hidden = true; });
		hear(editor.root, 'scroll', () => { this.close(); this.hover.hidden = this.sign.hidden = true; });
		hear(editor.text, 'mousemove', e => this.#moved(e));
		hear(editor.text, 'mouseleave', () => this.#leave());
		hear(this.list, 'pointerdown', e => {
			e.preventDefault(); // the text keeps the focus
			const n = [...this.list.children].indexOf(e.target.closest('li'));
			if (n >= 0) { this.#at = n; this.#accept(); }
		});
	}
	close() {
		this.#turn++;
		this.list.hidden = true;
		this.editor.text.removeAttribute('aria-activedescendant');
	}
	get open() { return !this.list.hidden; }
	#word() {
		const at = this.editor.caret(), { value } = this.editor;
		let from = at;
		while (from > 0 && /\w/.test(value[from - 1])) from--;
		return [from, value.slice(from, at)];
	}
	#typed() {
		const [from, word] = this.#word();
		// A call's form appears behind its blank, parenthesis or comma, and stays while it is written.
		clearTimeout(this.#formed);
		if (!this.sign.hidden || /[ (,]/.test(this.editor.value[this.editor.caret() - 1] ?? '')) {
			this.#formed = setTimeout(() => this.#form(), FORM);
		}
		if (this.open && from === this.#from && word) this.#filter(word);
		else if (word.length >= 2 && /^[A-Za-z_]/.test(word)) this.ask();
		else this.close();
	}
	async #form() {
		const at = this.editor.caret();
		const help = await this.language.ask('signatureHelp', { position: this.language.place(at) });
		const form = help?.signatures?.[0];
		if (this.editor.caret() !== at) return;
		if (!form) { this.sign.hidden = true; return; }
		const [start, end] = form.parameters?.[help.activeParameter]?.label ?? [0, 0];
		const { label } = form;
		this.sign.replaceChildren(h('code', {}, label.slice(0, start), h('b', {}, label.slice(start, end)), label.slice(end)),
			form.documentation ? h('p', {}, form.documentation) : '');
		this.#put(this.sign, this.editor.box(at), true);
	}
	async ask() {
		const turn = ++this.#turn, [from] = this.#word();
		const position = this.language.place(this.editor.caret());
		const items = await this.language.ask('completion', { position });
		if (turn !== this.#turn || !items) return;
		this.#items = Array.isArray(items) ? items : items.items;
		this.#from = from;
		this.#filter(this.#word()[1]);
	}
	#filter(word) {
		const low = word.toLowerCase();
		const fits = this.#items.filter(item => item.label.toLowerCase().startsWith(low));
		this.#shown = fits.slice(0, MOST);
		if (!fits.length || fits.length === 1 && fits[0].label.toLowerCase() === low) { this.close(); return; }
		this.list.replaceChildren(...this.#shown.map((item, n) => h('li', { role: 'option', id: `completion-${n}` },
			h('b', {}, item.label), ' ', h('span', {}, item.detail ?? ''))));
		this.#at = 0;
		this.#mark();
		this.#put(this.list, this.editor.box(this.#from));
	}
	// Beside a place: below it, or where `above` says so, or no room is, over it.
	#put(pop, box, above) {
		pop.hidden = false;
		const width = Math.min(pop.offsetWidth, innerWidth - 16);
		pop.style.left = `${Math.max(8, Math.min(box.x, innerWidth - width - 8))}px`;
		const below = above ? box.top - pop.offsetHeight < 8 : box.bottom + 2 + pop.offsetHeight < innerHeight;
		pop.style.top = `${below ? box.bottom + 2 : Math.max(8, box.top - pop.offsetHeight - 2)}px`;
	}
	#mark() {
		[...this.list.children].forEach((li, n) => li.setAttribute('aria-selected', n === this.#at));
		this.editor.text.setAttribute('aria-activedescendant', `completion-${this.#at}`);
		this.list.children[this.#at]?.scrollIntoView({ block: 'nearest' });
	}
	#accept() {
		const item = this.#shown[this.#at];
		this.close();
		if (item) this.editor.replace(this.#from, this.editor.caret(), item.insertText ?? item.label);
		this.close();
	}
	#key(e) {
		if (e.key === ' ' && e.ctrlKey) { e.preventDefault(); this.ask(); return; }
		this.hover.hidden = true;
		if (e.key === 'Escape' || e.key === 'Enter' || /^Arrow(Up|Down)/.test(e.key) && !this.open) this.sign.hidden = true;
		if (!this.open) return;
		const by = { ArrowDown: 1, ArrowUp: -1 }[e.key];
		if (by) this.#at = (this.#at + by + this.#shown.length) % this.#shown.length;
		else if (e.key === 'Enter' || e.key === 'Tab') this.#accept();
		else if (e.key === 'Escape') this.close();
		else { if (/^(Arrow|Home|End|Page)/.test(e.key)) this.close(); return; }
		e.preventDefault();
		if (by) this.#mark();
	}
	#moved(e) {
		clearTimeout(this.#wait);
		this.#wait = setTimeout(() => this.#ask(e.clientX, e.clientY), 350);
	}
	#leave() { clearTimeout(this.#wait); this.hover.hidden = true; }
	async #ask(x, y) {
		const caret = document.caretPositionFromPoint?.(x, y);
		if (!caret || !this.editor.text.contains(caret.offsetNode)) return;
		const at = this.editor.offset(caret.offsetNode, caret.offset);
		const wrong = this.editor.diags.filter(d => d.start <= at && at <= d.end).map(d => d.told.message);
		const found = await this.language.ask('hover', { position: this.language.place(at) });
		const value = found?.contents?.value ?? '';
		const parts = /^```\w*\n([\s\S]*?)\n```\n?([\s\S]*)$/.exec(value) ?? [null, '', value];
		if (!wrong.length && !parts[1] && !parts[2]) { this.hover.hidden = true; return; }
		this.hover.replaceChildren(
			...wrong.map(words => h('p', { className: 'bad' }, words)),
			parts[1] ? h('code', {}, parts[1]) : '', parts[2] ? h('p', {}, parts[2]) : '');
		this.#put(this.hover, this.editor.box(at));
	}
}
