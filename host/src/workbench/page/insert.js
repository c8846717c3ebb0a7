// A list of statements with examples: what is chosen comes into the script, at the caret's line.
import { h, action, bar } from './dom.js';

export class Insert {
	constructor(editor, statements) {
		Object.assign(this, { editor, statements });
		this.list = h('div', { className: 'examples' });
		this.find = h('input', { type: 'search', ariaLabel: 'Find a statement', placeholder: 'find', oninput: () => this.#fill(), autocomplete: 'off' });
		this.box = h('dialog', { id: 'insert', ariaLabel: 'Insert a statement' },
			bar(this.find, h('button', { onclick: () => this.box.close() }, 'Cancel')), this.list);
		document.body.append(this.box);
		this.button = action('Insert…', () => this.#open(), { id: 'insert-statement', title: 'A statement from a list, with an example' });
	}
	#open() {
		this.at = this.editor.last ?? this.editor.value.length;
		this.find.value = '';
		this.#fill();
		this.box.showModal();
		this.find.focus();
	}
	#fill() {
		const wanted = this.find.value.trim().toLowerCase(), fits = own => `${own.name} ${own.about} ${own.example}`.toLowerCase().includes(wanted);
		const found = this.statements.filter(fits), groups = [...new Set(found.map(own => own.group))];
		this.list.replaceChildren(...groups.flatMap(group => [h('h2', {}, group), ...found.filter(own => own.group === group).map(own =>
			h('button', { onclick: () => this.#take(own) }, h('b', {}, own.name), ' ', h('span', { className: 'soft' }, own.about), h('code', {}, own.example)))]),
		found.length ? '' : h('p', { className: 'soft' }, 'No statement has this word.'));
	}
	// Below the caret's line, or in its place where that is empty; a missing variable comes first.
	#take({ wants, example }) {
		this.box.close();
		const { editor } = this, n = editor.line(Math.min(this.at, editor.value.length)), first = editor.lines[n];
		const line = editor.row(n), stop = first + line.length;
		const name = wants.split(' ')[1], there = name && new RegExp(`^[^'\\n]*\\b(?:DIM|KEEP)\\b[^'\\n]*\\b${name}\\b`, 'im').test(editor.value);
		const indent = /^[ \t]*/.exec(line)[0], lines = [...wants && !there ? [wants] : [], ...example.split('\n')];
		const text = lines.map(own => indent + own).join('\n');
		editor.replace(first, stop, line.trim() ? `${line}\n${text}` : text);
		editor.reveal(editor.line(editor.caret()));
	}
}
