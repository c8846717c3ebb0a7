// A script's editor: plain text in one editable element. Colours and diagnostics are ranges of the
// highlight registry, so nothing but the user's typing ever changes the text: undo, input methods,
// spell checkers, screen readers and the clipboard see plain text.

// Height of a line in px, as in style.css, and lines beyond those in sight that are coloured.
const HEIGHT = 20, AROUND = 30;
const NAMES = ['word', 'function', 'number', 'remark', 'text', 'error', 'warning'];
// What names mean, which the language server says a moment later.
const MEANINGS = ['variable', 'constant', 'parameter', 'routine', 'label'];

export class Editor {
  breaks = new Set(); diags = []; meanings = []; running = -1; lines = [0]; nodes = []; value = ''; busy = false;

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
    this.text.addEventListener('beforeinput', e => this.before(e));
    this.text.addEventListener('input', () => this.read());
    this.text.addEventListener('keydown', e => this.key(e));
    this.gutter.addEventListener('click', e => {
      const { line } = e.target.dataset;
      if (line !== undefined) this.toggle(+line);
    });
    document.addEventListener('selectionchange', () => { if (document.activeElement === this.text) this.last = this.caret(); });
    root.addEventListener('scroll', () => this.later());
    new ResizeObserver(() => this.later()).observe(root);
  }
  // The whole text, without a way back: a file is opened.
  set(text) {
    this.busy = true;
    this.text.textContent = text.endsWith('\n') ? text : text + '\n';
    this.read();
    this.busy = false;
  }
  // A change by a program (format, fix, table): one step of undo.
  replace(start, end, text) {
    this.select(start, end);
    this.put(text);
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
  // Goes to a line, from 1.
  show(line) {
    const at = this.lines[Math.min(line, this.lines.length) - 1] ?? 0;
    this.select(at, at);
    this.reveal(line - 1);
  }
  // Scrolls until a line, from 0, is in sight.
  reveal(line) {
    const top = line * HEIGHT, { scrollTop, clientHeight } = this.root;
    if (top < scrollTop + HEIGHT || top > scrollTop + clientHeight - 3 * HEIGHT) {
      this.root.scrollTop = Math.max(0, top - clientHeight / 3);
    }
  }
  // Text, nodes and line starts as they are now; breakpoints move with their lines.
  read() {
    const old = this.value, before = this.lines;
    this.nodes = [];
    let text = '';
    const walk = document.createTreeWalker(this.text, NodeFilter.SHOW_TEXT | NodeFilter.SHOW_ELEMENT);
    for (let node; (node = walk.nextNode());) {
      if (node.nodeType === 3) {
        this.nodes.push([text.length, node]);
        text += node.data;
      } else if (node.tagName === 'BR' ? node.nextSibling : text && !text.endsWith('\n')) {
        text += '\n'; // a keyboard's commit of several lines makes DIVs
      }
    }
    this.value = text;
    this.lines = [0];
    for (let i = text.indexOf('\n'); i >= 0; i = text.indexOf('\n', i + 1)) this.lines.push(i + 1);
    if (old === text) return;
    this.follow(old, before, this.lines.length - before.length);
    this.changed(text, this.busy);
    this.paint();
  }
  // Marks behind a change move with their text; a diagnostic inside of it goes.
  follow(old, before, grown) {
    const text = this.value;
    let same = 0;
    while (same < text.length && same < old.length && text[same] === old[same]) same++;
    let end = 0;
    const most = Math.min(text.length, old.length) - same;
    while (end < most && text[text.length - 1 - end] === old[old.length - 1 - end]) end++;
    const by = text.length - old.length, last = old.length - end;
    const moved = marks => marks.flatMap(d => d.end <= same ? [d]
      : d.start >= last ? [{ ...d, start: d.start + by, end: d.end + by }] : []);
    this.diags = moved(this.diags);
    this.meanings = moved(this.meanings);
    if (!grown || !this.breaks.size) return;
    let at = 0;
    while (at + 1 < before.length && before[at + 1] <= same) at++;
    if (before[at] === same && grown > 0) at--; // typed at a line's start: the line itself moves
    this.breaks = new Set([...this.breaks].map(l => l <= at ? l : Math.max(at, l + grown)));
    this.broken();
  }
  // Node and offset of an offset in the text.
  place(at) {
    let lo = 0, hi = this.nodes.length - 1;
    while (lo < hi) {
      const m = (lo + hi + 1) >> 1;
      if (this.nodes[m][0] <= at) lo = m; else hi = m - 1;
    }
    const [start, node] = this.nodes[lo] ?? [0, this.text];
    return [node, Math.min(at - start, node.length ?? 0)];
  }
  range(start, end) {
    const [a, b] = [this.place(start), this.place(end)];
    return new StaticRange({ startContainer: a[0], startOffset: a[1], endContainer: b[0], endOffset: b[1] });
  }
  // Line, from 0, of an offset.
  line(at) {
    let lo = 0, hi = this.lines.length - 1;
    while (lo < hi) {
      const m = (lo + hi + 1) >> 1;
      if (this.lines[m] <= at) lo = m; else hi = m - 1;
    }
    return lo;
  }
  // Offset of a place in the page, such as the caret's.
  offset(node, at) {
    if (this.nodes.length === 1 && node === this.nodes[0][1]) return at;
    const range = document.createRange();
    range.setStart(this.text, 0);
    range.setEnd(node, at);
    return range.toString().length;
  }
  caret() {
    const s = getSelection();
    return this.text.contains(s.focusNode) ? this.offset(s.focusNode, s.focusOffset) : 0;
  }
  // Where an offset is on the screen.
  box(at) {
    const range = document.createRange(), [node, offset] = this.place(at);
    range.setStart(node, offset);
    range.collapse(true);
    const box = range.getClientRects()[0];
    if (box) return box;
    const root = this.text.getBoundingClientRect();
    return new DOMRect(root.x + 8, root.y + this.line(at) * HEIGHT, 0, HEIGHT);
  }
  later() {
    this.due ??= requestAnimationFrame(() => { this.due = null; this.paint(); });
  }
  // Colours, numbers and marks of the lines in sight.
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
      this.gutter.append(Object.assign(document.createElement('button'), { type: 'button', tabIndex: -1 }));
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
  }
  // Marks the line that runs, from 0; -1 for none.
  run(line) {
    this.running = line;
    this.mark.hidden = line < 0;
    this.mark.style.top = `${line * HEIGHT}px`;
    // As wide as the longest line, not as what is in sight.
    if (line >= 0) this.mark.style.width = `${this.text.scrollWidth + this.text.offsetLeft}px`;
  }
  // What names mean: [{ start, end, kind }].
  mean(list) {
    this.meanings = list;
    this.later();
  }
  diagnose(list) {
    this.diags = list;
    this.later();
  }
  toggle(line) {
    if (!this.breaks.delete(line)) this.breaks.add(line);
    this.paint();
    this.broken();
  }
  // A new line begins below the old one's first word.
  before(e) {
    if (e.inputType !== 'insertParagraph' && e.inputType !== 'insertLineBreak' || this.inside) return;
    const at = this.caret(), line = this.line(at);
    const indent = /^[ \t]*/.exec(this.value.slice(this.lines[line], at))[0];
    e.preventDefault();
    this.inside = true;
    document.execCommand('insertLineBreak');
    if (indent) document.execCommand('insertText', false, indent);
    this.inside = false;
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
  // Two blanks, or the lines of the selection in or out by two.
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
