// The script that the tool and all pages share: this page's copy, and how it goes back and forth.
import { tell, hear } from './dom.js';

// Pause in typing after which the tool gets the text, ms.
const PAUSE = 250;

export class Script extends EventTarget {
	number = 0; file = null; dirty = false; conflict = false;
	// Too long to be changed by a page.
	fixed = false;
	#sent = ''; #flying = null; #touched = false; #timer = null; #flight = null; #theirs = null;

	constructor(link, editor) {
		super();
		Object.assign(this, { link, editor });
		hear(link, 'text', e => this.hear(e.detail));
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
		this.#has(this.editor.value);
		this.#changed();
	}
	#has(text) {
		this.#sent = text;
		this.#touched = false;
		this.dispatchEvent(new Event('synced'));
	}
	#changed() { this.dispatchEvent(new Event('changed')); }

	// Another page, or another program on the file, changed it; or it was saved.
	hear(text) {
		const own = this.editor.value;
		if (text.number < this.number) return;
		// What this page had sent before the newest keys was saved, say.
		if (own !== text.text && (text.number === this.number && text.text === this.#sent || text.text === this.#flying)) {
			this.#note({ ...text, number: this.number, dirty: true });
			this.#changed();
			return;
		}
		if (text.text === own || own === this.#sent) { this.#take(text); return; }
		this.#theirs = text;
		this.#note(text);
		this.#changed();
	}
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
	typed(text, busy) {
		if (busy) return;
		this.dirty = this.#touched = true;
		clearTimeout(this.#timer);
		this.#timer = setTimeout(() => this.sync(), PAUSE);
		this.#changed(text);
	}
	async sync() {
		clearTimeout(this.#timer);
		while (this.#flight) await this.#flight;
		const text = this.editor.value;
		if (text === this.#sent && this.#touched) this.#has(text); // a key and its undoing
		if (text === this.#sent || this.split || !this.link.known) return;
		const base = this.number;
		this.#flying = text;
		this.#flight = this.link.ask({ text: { base, text } }).then(
			() => {
				this.number = base + 1;
				this.#has(text);
			},
			error => { if (!this.split) tell(error.message, true); },
		).finally(() => { this.#flight = this.#flying = null; });
		await this.#flight;
		if (this.editor.value !== text) return this.sync();
	}
	async save(name) {
		await this.sync();
		await this.link.ask({ save: name ?? null });
	}
}
