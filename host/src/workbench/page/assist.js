// Completion list, hover and signature beside the text.
import { h } from './dom.js';

const MOST = 12;

export class Assist {
  #items = []; #shown = []; #at = 0; #from = 0; #wait = null; #turn = 0;

  constructor(editor, language) {
    Object.assign(this, { editor, language });
    this.list = h('ul', { id: 'completions', className: 'pop', role: 'listbox', hidden: true, ariaLabel: 'Completions' });
    this.hover = h('div', { className: 'pop hover', role: 'tooltip', hidden: true });
    document.body.append(this.list, this.hover);
    editor.text.addEventListener('keydown', e => this.#key(e), true);
    editor.text.addEventListener('input', () => this.#typed());
    editor.text.addEventListener('blur', () => this.close());
    editor.root.addEventListener('scroll', () => { this.close(); this.hover.hidden = true; });
    editor.text.addEventListener('mousemove', e => this.#moved(e));
    editor.text.addEventListener('mouseleave', () => this.#leave());
    this.list.addEventListener('pointerdown', e => {
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
    if (this.open && from === this.#from && word) this.#filter(word);
    else if (word.length >= 2 && /^[A-Za-z_]/.test(word)) this.ask();
    else this.close();
  }
  // Asks the server for what may be written here.
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
  #put(pop, box) {
    pop.hidden = false;
    const width = Math.min(pop.offsetWidth, innerWidth - 16);
    pop.style.left = `${Math.max(8, Math.min(box.x, innerWidth - width - 8))}px`;
    const below = box.bottom + 2 + pop.offsetHeight < innerHeight;
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
