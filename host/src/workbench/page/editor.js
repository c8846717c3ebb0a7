// A script's editor: plain text in one editable element. Colours and diagnostics are highlights, so nothing but the
// user's typing changes it: undo, input methods, screen readers and the clipboard see plain text.

import { enter } from './blocks.js';
import { lastOf, hear } from './dom.js';

// Height of a line in px, as in style.css, and lines beyond those in sight that are coloured.
const HEIGHT = 20, AROUND = 30;
const BLOCK = 200, PARTS = new RegExp(`(?:[^\\n]*\\n){1,${BLOCK}}`, 'g');
const NAMES = ['word', 'function', 'number', 'remark', 'text', 'error', 'warning'];
const MEANINGS = ['variable', 'constant', 'parameter', 'routine', 'label'];

export class Editor {
	locked = false; breaks = new Set(); diags = []; meanings = []; running = -1; lines = [0]; nodes = []; starts = new Map(); value = ''; busy = false;
	// Ends of blocks that Return has written: a person who writes such an end takes that one.
	made = [];

	// `lex` gives [start, end, kind] for a text; `changed` hears each new text, `broken` each new set
	// of breakpoints.
	constructor(root, lex, changed, broken) {
		Object.assign(this, { root, lex, changed, broken });
		root.classList.add('ed');
		root.innerHTML = '<div class="gutter" role="group" aria-label="Breakpoints"></div>'
			+ '<div class="text" role="textbox" aria-multiline="true" aria-label="Script" spellcheck="false"'
			+ ' autocapitalize="off" autocorrect="off"></div><div class="run" hidden></div>';
		[this.gutter, this.text, this.mark] = root.children;
		this.text.contentEditable = 'plaintext-only';
		this.high = Object.fromEntries([...NAMES, ...MEANINGS].map(name => {
			const high = new Highlight();
			if (MEANINGS.includes(name)) high.priority = 1;
			CSS.highlights.set(name, high);
			return [name, high];
		}));
		this.heard = [];
		this.watch = new MutationObserver(list => this.heard.push(...list));
		this.watch.observe(this.text, { characterData: true, childList: true, subtree: true });
		hear(this.text, 'beforeinput', e => this.before(e));
		hear(this.text, 'input', () => this.read());
		hear(this.text, 'keydown', e => this.key(e));
		hear(this.gutter, 'click', e => {
			const { line } = e.target.dataset;
			if (line !== undefined) this.toggle(+line);
		});
		hear(document, 'selectionchange', () => { if (document.activeElement !== this.text) return;
			this.last = this.caret();
			this.moved?.(this.line(this.last) + 1);
		});
		hear(root, 'scroll', () => this.later());
		new ResizeObserver(() => this.later()).observe(root);
	}
	// The whole text, without a way back: a file is opened.
	set(text) {
		this.busy = true;
		const all = text.endsWith('\n') ? text : text + '\n';
		// A key lays out its block only: a long text has many.
		const parts = all.length > BLOCK * 40 ? all.match(PARTS) : [];
		if (parts.length > 1) this.text.replaceChildren(...parts.map(own => Object.assign(document.createElement('div'), { textContent: own })));
		else this.text.textContent = all;
		this.read();
		this.busy = false;
	}
	// Whether the text can be read only: it is too long to be changed here.
	lock(on) {
		if (this.locked === on) return;
		this.locked = on;
		this.text.contentEditable = on ? 'false' : 'plaintext-only';
		this.text.tabIndex = 0;
		this.text.ariaReadOnly = String(on);
	}
	// A change by a program (format, fix, table): one step of undo.
	replace(start, end, text) {
		if (this.locked) { this.told?.('This script is too long to be changed here.'); return; }
		this.select(start, end);
		this.put(text);
	}
	// The same without a step of undo: the caller puts the old text back.
	poke(start, end, text) {
		const [a, from] = this.place(start), [b, to] = this.place(end);
		if (a !== b) return false;
		a.replaceData(from, to - from, text);
		this.read();
		return true;
	}
	// Chromium makes a DIV of each line of an `insertText` but keeps those of an `insertHTML`; Firefox
	// keeps those of `insertText` only: tried once.
	put(text) {
		this.whole ??= this.try();
		if (text === '') document.execCommand('delete');
		else if (this.whole || !text.includes('\n')) document.execCommand('insertText', false, text);
		else document.execCommand('insertHTML', false, text.replace(/[&<]/g, c => c === '&' ? '&amp;' : '&lt;'));
	}
	try() {
		const box = this.text.cloneNode(), s = getSelection();
		const was = s.rangeCount && s.getRangeAt(0).cloneRange();
		this.root.append(box);
		box.focus({ preventScroll: true });
		s.selectAllChildren(box);
		document.execCommand('insertText', false, 'a\nb');
		const plain = box.textContent === 'a\nb' && !box.firstElementChild;
		box.remove();
		this.text.focus({ preventScroll: true });
		if (was) { s.removeAllRanges(); s.addRange(was); }
		return plain;
	}
	select(start, end) {
		const [a, b] = [this.place(start), this.place(end)];
		getSelection().setBaseAndExtent(a[0], a[1], b[0], b[1]);
		this.text.focus({ preventScroll: true });
	}
	show(line) {
		const at = this.lines[Math.min(line, this.lines.length) - 1] ?? 0;
		this.select(at, at);
		this.reveal(line - 1);
	}
	reveal(line) {
		const top = line * HEIGHT, { scrollTop, clientHeight } = this.root;
		if (top < scrollTop + HEIGHT || top > scrollTop + clientHeight - 3 * HEIGHT) {
			this.root.scrollTop = Math.max(0, top - clientHeight / 3);
		}
	}
	// Text, nodes and line starts as they are now; breakpoints move with their lines.
	read() {
		const old = this.value, before = this.lines, [from, tail] = this.#again() ?? this.#whole();
		if (old === this.value) return;
		this.halts = null;
		this.follow(old, before, this.lines.length - before.length, from, tail);
		this.changed(this.value, this.busy);
		this.paint();
	}
	// A key changes one node of a long text: that alone is read. Gives how much before and behind it is the same; null:
	// more has changed.
	#again() {
		const nodes = new Set([...this.heard.splice(0), ...this.watch.takeRecords()].map(own => own.type === 'characterData' ? own.target : null));
		const [node] = nodes, start = this.starts.get(node);
		if (nodes.size !== 1 || start === undefined) return null;
		const k = lastOf(this.nodes.length, n => this.nodes[n][0] <= start), long = this.nodes[k][2], end = start + long, { data } = node;
		if (this.nodes[k][1] !== node || !data || data.endsWith('\n') !== this.value.slice(start, end).endsWith('\n')) return null;
		const by = data.length - long, { value, lines } = this, tail = value.length - end;
		this.value = value.slice(0, start) + data + value.slice(end);
		this.nodes[k] = [start, node, data.length];
		for (let n = k + 1; by && n < this.nodes.length; n++) {
			const own = this.nodes[n];
			this.nodes[n] = [own[0] + by, own[1], own[2]];
			this.starts.set(own[1], own[0] + by);
		}
		const own = [];
		for (let i = data.indexOf('\n'); i >= 0; i = data.indexOf('\n', i + 1)) own.push(start + i + 1);
		const behind = lines.slice(lastOf(lines.length, n => lines[n] <= end) + 1);
		this.lines = lines.slice(0, lastOf(lines.length, n => lines[n] <= start) + 1).concat(own, by ? behind.map(at => at + by) : behind);
		return [start, tail];
	}
	#whole() {
		this.nodes = [];
		this.starts = new Map();
		let text = '';
		const walk = document.createTreeWalker(this.text, NodeFilter.SHOW_TEXT | NodeFilter.SHOW_ELEMENT);
		for (let node; (node = walk.nextNode());) {
			if (node.nodeType === 3) {
				this.nodes.push([text.length, node, node.length]);
				this.starts.set(node, text.length);
				text += node.data;
			} else if (node.tagName === 'BR' ? node.nextSibling : text && !text.endsWith('\n')) {
				text += '\n'; // a keyboard's commit of several lines makes DIVs
			}
		}
		this.value = text;
		this.lines = [0];
		for (let i = text.indexOf('\n'); i >= 0; i = text.indexOf('\n', i + 1)) this.lines.push(i + 1);
		return [0, 0];
	}
	// Marks behind a change move with their text; a diagnostic inside of it goes.
	follow(old, before, grown, from, tail) {
		const text = this.value;
		let same = from;
		while (same < text.length && same < old.length && text[same] === old[same]) same++;
		let end = tail;
		const most = Math.min(text.length, old.length) - same;
		while (end < most && text[text.length - 1 - end] === old[old.length - 1 - end]) end++;
		const by = text.length - old.length, last = old.length - end;
		const moved = marks => marks.flatMap(d => d.end <= same ? [d]
			: d.start >= last ? [{ ...d, start: d.start + by, end: d.end + by }] : []);
		this.diags = moved(this.diags);
		this.meanings = moved(this.meanings);
		this.made = moved(this.made);
		if (!grown || !this.breaks.size) return;
		let at = 0;
		while (at + 1 < before.length && before[at + 1] <= same) at++;
		if (before[at] === same && grown > 0) at--; // typed at a line's start: the line itself moves
		this.breaks = new Set([...this.breaks].map(l => l <= at ? l : Math.max(at, l + grown)));
		this.broken();
	}
	place(at) {
		const [start, node] = this.nodes[Math.max(0, lastOf(this.nodes.length, n => this.nodes[n][0] <= at))] ?? [0, this.text];
		return [node, Math.min(at - start, node.length ?? 0)];
	}
	range(start, end) {
		const [a, b] = [this.place(start), this.place(end)];
		return new StaticRange({ startContainer: a[0], startOffset: a[1], endContainer: b[0], endOffset: b[1] });
	}
	line(at) { return Math.max(0, lastOf(this.lines.length, n => this.lines[n] <= at)); }
	row(n) { return this.value.slice(this.lines[n], (this.lines[n + 1] ?? this.value.length + 1) - 1); }
	// Offset of a place in the page, such as the caret's.
	offset(node, at) {
		if (node.nodeType !== 3) {
			const next = node.childNodes[at], inside = document.createTreeWalker(this.text, NodeFilter.SHOW_TEXT);
			inside.currentNode = next ?? node;
			if (next?.nodeType === 3) return this.offset(next, 0);
			// The first text inside or behind; without a next child that behind the node's own.
			let found = next ? inside.nextNode() : null;
			if (!next) do found = inside.nextNode(); while (found && node.contains(found));
			return found ? this.offset(found, 0) : this.value.length;
		}
		let start = this.starts.get(node);
		if (start === undefined) { this.read(); start = this.starts.get(node) ?? 0; }
		return start + at;
	}
	caret() {
		const s = getSelection();
		return this.text.contains(s.focusNode) ? this.offset(s.focusNode, s.focusOffset) : 0;
	}
	box(at) {
		const range = document.createRange(), [node, offset] = this.place(at);
		range.setStart(node, offset);
		range.collapse(true);
		const box = range.getClientRects()[0];
		if (box) return box;
		const root = this.text.getBoundingClientRect();
		return new DOMRect(root.x + 8, root.y + this.line(at) * HEIGHT, 0, HEIGHT);
	}
	glyph(at) {
		const range = document.createRange(), [node, offset] = this.place(at);
		range.setStart(node, offset);
		range.setEnd(node, Math.min(offset + 1, node.length));
		return range.getClientRects()[0] ?? this.box(at);
	}
	later() {
		this.due ??= requestAnimationFrame(() => { this.due = null; this.paint(); });
	}
	paint() {
		const { scrollTop, clientHeight } = this.root;
		const first = Math.max(0, Math.floor(scrollTop / HEIGHT) - AROUND);
		const last = Math.min(this.lines.length, Math.ceil((scrollTop + clientHeight) / HEIGHT) + AROUND);
		const from = this.lines[first] ?? 0, to = this.lines[last] ?? this.value.length;
		for (const high of Object.values(this.high)) high.clear();
		for (const [start, end, kind] of this.lex(this.value.slice(from, to))) {
			this.high[kind].add(this.range(from + start, from + end));
		}
		for (const d of this.diags) {
			if (d.end >= from && d.start <= to) this.high[d.kind].add(this.range(d.start, d.end));
		}
		for (const m of this.meanings) {
			if (m.end >= from && m.start <= to) this.high[m.kind].add(this.range(m.start, m.end));
		}
		const open = last === this.lines.length && this.value.endsWith('\n') ? 1 : 0;
		const count = Math.max(1, last - first - open);
		while (this.gutter.children.length < count) {
			this.gutter.append(Object.assign(document.createElement('button'), { tabIndex: -1 }));
		}
		while (this.gutter.children.length > count) this.gutter.lastChild.remove();
		let i = first;
		for (const b of this.gutter.children) {
			if (b.dataset.line !== String(i)) {
				b.dataset.line = i;
				b.textContent = i + 1;
				b.style.top = `${i * HEIGHT}px`;
				b.setAttribute('aria-label', `Breakpoint in line ${i + 1}`);
			}
			b.setAttribute('aria-pressed', this.breaks.has(i++));
		}
		this.gutter.style.height = `${this.lines.length * HEIGHT}px`;
		this.run(this.running);
		this.painted?.(first, Math.min(last, this.lines.length));
	}
	run(line) {
		this.running = line;
		this.mark.hidden = line < 0;
		this.mark.style.top = `${line * HEIGHT}px`;
		if (line >= 0) this.mark.style.width = `${this.text.scrollWidth + this.text.offsetLeft}px`;
	}
	mean(list) {
		this.meanings = list;
		this.later();
	}
	diagnose(list) {
		this.diags = list;
		this.later();
	}
	halt(lines) {
		this.halts = lines;
		const moved = new Set([...this.breaks].map(line => lines.find(own => own > line)).filter(Boolean).map(line => line - 1));
		if ([...moved].join() === [...this.breaks].join()) return;
		this.breaks = moved;
		this.paint();
		this.broken();
	}
	// A board halts before effects only: a mark on another line goes to the next one with an effect.
	toggle(line) {
		if (!this.breaks.delete(line)) {
			const next = this.halts ? this.halts.find(own => own > line) : line + 1;
			if (next === undefined) { this.told?.('The board halts before moves, outputs, waits and PRINT: none follows here.'); return; }
			if (next !== line + 1) this.told?.(`The board halts before effects: the mark is in line ${next}.`);
			line = next - 1;
			this.breaks.add(line);
		}
		this.paint();
		this.broken();
	}
	// Before all of a text in blocks is written over it becomes one: the last block would be empty and keep a
	// line of its own.
	join() {
		const chosen = getSelection();
		if (!this.text.firstElementChild || chosen.isCollapsed) return;
		const { startContainer, startOffset, endContainer, endOffset } = chosen.getRangeAt(0);
		if (this.offset(startContainer, startOffset) > 0 || this.offset(endContainer, endOffset) < this.value.length - 1) return;
		this.text.textContent = this.value;
		this.read();
		this.select(0, this.value.length);
	}
	// A new line begins below the old one's first word; see blocks.js.
	before(e) {
		this.join();
		if (e.inputType !== 'insertParagraph' && e.inputType !== 'insertLineBreak' || this.inside) return;
		const at = this.caret(), n = this.line(at), first = this.lines[n], stop = first + this.row(n).length;
		const text = k => this.row(k), old = text(n), plain = /^[ \t]*/.exec(this.value.slice(first, at))[0];
		e.preventDefault();
		const count = this.lines.length, made = k => this.made.some(own => this.line(own.start) === k);
		const whole = getSelection().isCollapsed && this.value.slice(at, stop).trim() === '';
		const { line, next, end, over } = whole ? enter(text, n, count, made) : { line: old, next: plain, end: '' };
		if (!end && !next && (line !== old || over)) {
			// A line break at the end of what is written would be lost.
			this.replace(first, over ? this.lines[n + 2] - 1 || this.value.length : stop, line);
			this.select(first + line.length, first + line.length);
		}
		if (!end && (!next || line === old && !over)) {
			this.inside = true;
			document.execCommand('insertLineBreak');
			if (next) document.execCommand('insertText', false, next);
			this.inside = false;
			return;
		}
		const own = line.slice(0, line.length - (stop - at)) + '\n' + next, to = over ? this.lines[n + 2] - 1 || this.value.length : stop;
		this.replace(first, to, own + (end ? '\n' + end : ''));
		const caret = first + own.length;
		this.select(caret, caret);
		// Its word: the blanks before it may be taken for those of a new line.
		if (end) this.made.push({ start: caret + 1 + end.length - end.trim().length, end: caret + 1 + end.length });
	}
	key(e) {
		if (e.isComposing || e.defaultPrevented) return;
		if (e.key === 'Escape') this.leave = true; // Escape, then Tab: out of the editor by keyboard
		else if (e.key === 'Tab' && !this.leave && !e.ctrlKey && !e.altKey) {
			e.preventDefault();
			this.tab(e.shiftKey);
		} else if (e.key === 'F9') this.toggle(this.line(this.caret()));
		else if (e.key !== 'Shift') this.leave = false;
	}
	tab(out) {
		const s = getSelection();
		if (s.isCollapsed && !out) { this.put('  '); return; }
		const range = s.getRangeAt(0), start = this.offset(range.startContainer, range.startOffset);
		const length = Math.max(0, range.toString().length - 1);
		const from = this.line(start), to = this.line(start + length);
		const first = this.lines[from], end = (this.lines[to + 1] ?? this.value.length + 1) - 1;
		const lines = this.value.slice(first, end);
		const changed = out ? lines.replace(/^ {1,2}/gm, '') : lines.replace(/^/gm, '  ');
		if (changed === lines) return;
		this.replace(first, end, changed);
		this.select(first, first + changed.length);
	}
}
