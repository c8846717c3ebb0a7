// The language server's answers in the page: the same server as an editor's, over the same protocol.
import { h, $, tell, hear } from './dom.js';

export class Language {
	#asked = new Map(); #next = 1; #told = null; #listed = null; #marks = 0; can = {}; why = '';

	constructor(link, editor, script) {
		Object.assign(this, { link, editor, script });
		hear(link, 'lsp', e => this.#hear(e.detail));
		hear(script, 'synced', () => {
			if (this.#told !== this.#listed || this.#marks !== this.editor.diags.length) this.#diagnose(this.#told);
			this.#mean();
		});
	}
	#hear(message) {
		if (message.method === 'textDocument/publishDiagnostics') this.#diagnose(message.params);
		else if (this.#asked.has(message.id)) {
			this.why = message.error?.message ?? '';
			this.#asked.get(message.id)(message.result ?? null);
			this.#asked.delete(message.id);
		}
	}
	// Asks about the newest text; null where the server has nothing to say.
	async ask(method, params) {
		await this.script.sync();
		const id = this.#next++;
		const answer = new Promise(done => this.#asked.set(id, done));
		this.link.say({ lsp: { id, method: `textDocument/${method}`, params } });
		const late = new Promise(done => setTimeout(done, 3000, null));
		return Promise.race([answer, late]);
	}
	// Colours by meaning, of the text that the tool has.
	async #mean() {
		const legend = this.can.semanticTokensProvider?.legend;
		// Colours of the tool's words are enough for what nobody changes.
		if (!legend || this.editor.locked) return;
		const text = this.editor.value;
		const found = await this.ask('semanticTokens/full', {});
		if (!found || text !== this.editor.value) return;
		const bit = name => 1 << legend.tokenModifiers.indexOf(name);
		const [fixed, ours] = [bit('readonly'), bit('defaultLibrary')];
		const kinds = { parameter: 'parameter', property: 'constant', label: 'label', function: 'routine', variable: 'variable' };
		const list = [], { data } = found;
		let line = 0, character = 0;
		for (let n = 0; n < data.length; n += 5) {
			const [down, right, length, type, modifiers] = data.slice(n, n + 5);
			character = down ? right : character + right;
			line += down;
			const kind = modifiers & ours ? null : kinds[legend.tokenTypes[type]];
			const start = this.at({ line, character });
			if (kind) list.push({ start, end: start + length, kind: kind === 'variable' && modifiers & fixed ? 'constant' : kind });
		}
		this.editor.mean(list);
	}
	// Places: the protocol counts lines and UTF-16 units, as scripts of a page do.
	place(at) {
		const line = this.editor.line(at);
		return { line, character: at - this.editor.lines[line] };
	}
	at({ line, character }) {
		const { lines, value } = this.editor;
		if (line >= lines.length) return value.length;
		return Math.min(lines[line] + character, (lines[line + 1] ?? value.length + 1) - 1);
	}
	#diagnose(params) {
		const { diagnostics, version } = this.#told = params;
		// An answer to another text would mark the wrong words: it may be that of the next number, which
		// this page does not know to be taken yet.
		if (version !== this.script.number || !this.script.synced) return;
		this.#listed = params;
		this.#marks = diagnostics.length;
		const list = diagnostics.map(d => {
			const start = this.at(d.range.start);
			const end = Math.max(this.at(d.range.end), start + 1);
			return { start, end, kind: d.severity === 1 ? 'error' : 'warning', told: d };
		});
		this.editor.diagnose(list);
		this.#list(list);
	}
	#list(list) {
		const rows = list.slice(0, 100).map(d => {
			const [words, ...hint] = d.told.message.split('\n');
			const line = d.told.range.start.line + 1;
			const go = () => { this.editor.show(line); this.editor.select(d.start, d.end); };
			const row = h('li', { className: d.kind },
				h('button', { className: 'plain', onclick: go }, `${line}: ${words}`),
				hint.length ? h('span', { className: 'hint' }, hint.join(' ')) : null);
			this.#fixes(d, row);
			return row;
		});
		$('#problems').replaceChildren(...rows);
		const errors = list.filter(d => d.kind === 'error').length;
		const words = (n, word) => n ? `${n} ${word}${n > 1 ? 's' : ''}` : '';
		const sum = [words(errors, 'error'), words(list.length - errors, 'warning')].filter(Boolean);
		$('#problem-count').textContent = sum.join(', ') || 'no problems';
		$('#problem-count').className = errors ? 'bad' : '';
	}
	async #fixes(d, row) {
		if (!this.can.codeActionProvider) return;
		const actions = await this.ask('codeAction', { range: d.told.range, context: { diagnostics: [d.told] } });
		for (const fix of (actions ?? []).slice(0, 3)) {
			const edits = Object.values(fix.edit?.changes ?? {})[0]
				?? fix.edit?.documentChanges?.flatMap(change => change.edits ?? []);
			if (edits) row.append(h('button', { className: 'fix', onclick: () => this.apply(edits) }, fix.title));
		}
	}
	apply(edits) {
		const list = edits.map(e => [this.at(e.range.start), this.at(e.range.end), e.newText]);
		list.sort((a, b) => b[0] - a[0]);
		const caret = this.editor.caret();
		for (const [start, end, text] of list) {
			const old = this.editor.value.slice(start, end);
			let a = 0, b = 0;
			while (a < old.length && a < text.length && old[a] === text[a]) a++;
			while (b < old.length - a && b < text.length - a && old.at(-1 - b) === text.at(-1 - b)) b++;
			if (a + b < old.length || a + b < text.length) {
				this.editor.replace(start + a, end - b, text.slice(a, text.length - b));
			}
		}
		const at = Math.min(caret, this.editor.value.length);
		this.editor.select(at, at);
	}
	async format() {
		const edits = await this.ask('formatting', { options: { tabSize: 2, insertSpaces: true } });
		if (!edits) tell('It does not parse: mend the errors first.', true);
		else this.apply(edits);
	}
	async rename() {
		const position = this.place(this.editor.caret());
		const old = await this.ask('prepareRename', { position });
		if (!old) { tell('Nothing here has a name of the script\'s own.', true); return; }
		const name = prompt('New name', old.placeholder);
		if (!name || name === old.placeholder) return;
		const edit = await this.ask('rename', { position, newName: name });
		const edits = Object.values(edit?.changes ?? {})[0] ?? edit?.documentChanges?.flatMap(c => c.edits);
		if (edits) this.apply(edits); else tell(this.why || 'This cannot be renamed so.', true);
	}
	async definition() {
		const found = await this.ask('definition', { position: this.place(this.editor.caret()) });
		const place = Array.isArray(found) ? found[0] : found;
		if (place) this.editor.show(place.range.start.line + 1);
	}
}
