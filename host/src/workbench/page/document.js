// The script that the tool and all pages share: this page's copy, and how it goes back and forth.
import { tell } from './dom.js';

// Pause in typing after which the tool gets the text, ms.
const PAUSE = 250;

export class Script extends EventTarget {
	number = 0; file = null; dirty = false; conflict = false;
	// Too long to be changed by a page.
	fixed = false;
	#sent = ''; #timer = null; #flight = null; #theirs = null;

	constructor(link, editor) {
		super();
		Object.assign(this, { link, editor });
		link.addEventListener('text', e => this.hear(e.detail));
	}
	// The tool's text when the page begins; what was typed while it was away stays.
	begin(text) {
		const own = this.editor.value;
		if (this.number && own !== this.#sent && own !== text.text) {
			this.#theirs = text;
			this.#note(text);
			this.#changed();
			return;
		}
		this.#take(text);
	}
	#note({ number, file, dirty, conflict, fixed = false }) {
		Object.assign(this, { number, file, dirty, conflict, fixed });
		this.editor.lock(fixed);
	}
	#take(text) {
		this.#note(text);
		this.#theirs = null;
		if (text.text !== this.editor.value) this.editor.set(text.text);
		this.#sent = this.editor.value;
		this.dispatchEvent(new Event('synced'));
		this.#changed();
	}
	#changed() { this.dispatchEvent(new Event('changed')); }

	// Another page, or another program on the file, changed it; or it was saved.
	hear(text) {
		const own = this.editor.value;
		if (text.text === own || own === this.#sent) { this.#take(text); return; }
		this.#theirs = text;
		this.#note(text);
		this.#changed();
	}
	// Whether the tool has exactly this text.
	get synced() { return this.editor.value === this.#sent; }
	// Two texts at once: the user decides.
	get split() { return this.#theirs !== null; }
	takeTheirs() { this.#take(this.#theirs); }
	keepMine() {
		this.number = this.#theirs.number;
		this.#theirs = null;
		this.#changed();
		return this.sync();
	}
	// The user typed.
	typed(text, busy) {
		if (busy) return;
		this.dirty = true;
		clearTimeout(this.#timer);
		this.#timer = setTimeout(() => this.sync(), PAUSE);
		this.#changed(text);
	}
	// Resolves when the tool has the newest text.
	async sync() {
		clearTimeout(this.#timer);
		while (this.#flight) await this.#flight;
		const text = this.editor.value;
		if (text === this.#sent || this.split || !this.link.known) return;
		const base = this.number;
		this.#flight = this.link.ask({ text: { base, text } }).then(
			() => {
				this.#sent = text;
				this.number = base + 1;
				this.dispatchEvent(new Event('synced'));
			},
			error => { if (!this.split) tell(error.message, true); },
		).finally(() => { this.#flight = null; });
		await this.#flight;
		if (this.editor.value !== text) return this.sync();
	}
	async save(name) {
		await this.sync();
		await this.link.ask({ save: name ?? null });
	}
}
