// The page without a tool: script, simulation and player of the workbench over a module of this page.
import { h, $, text, tell, action } from './dom.js';
import { Local } from './local.js';
import { lexer } from './lexer.js';
import { Editor } from './editor.js';
import { Script } from './document.js';
import { Language } from './language.js';
import { Assist } from './assist.js';
import { PathView } from './path.js';
import { Trial } from './trial.js';
import { Drag } from './drag.js';
import { Values } from './values.js';
import { Insert } from './insert.js';
import { examples, worlds } from './examples.js';
import './tabs.js';

// What a visitor sees first, and the text's place in this browser.
const FIRST = 'pocket.bas', KEPT = 'script';

const link = new Local(examples);
const parts = {};

link.addEventListener('welcome', e => begin(e.detail).catch(error => tell(error.message, true)));
link.addEventListener('broken', e => {
  $('#blind').hidden = false;
  text($('#blind'), `The simulator failed (${e.detail}). The script is kept: change it, and load this page again.`);
});

async function begin(welcome) {
  const editor = new Editor($('#editor'), lexer(welcome.words), (words, busy) => {
    if (!busy) localStorage.setItem(KEPT, editor.value);
    script.typed(words, busy);
    parts.trial?.stale();
  }, () => {});
  const script = new Script(link, editor);
  const language = new Language(link, editor, script);
  language.can = welcome.lsp;
  const view = new PathView($('#path'));
  const trial = new Trial(link, view, editor);
  trial.isNewest = about => about.number === script.number && script.synced;
  trial.file = () => script.file;
  script.addEventListener('synced', () => trial.settle());
  trial.beside = new Values(editor, view);
  new Drag(editor, script, view, trial, () => trial.about?.machine);
  link.addEventListener('path', () => performance.mark('path'), { once: true });
  const assist = new Assist(editor, language);
  Object.assign(parts, { editor, script, language, assist, view, trial });
  script.addEventListener('changed', title);
  $('#edit-buttons').append(
    action('Open a file…', () => $('#own').click()),
    action('Save', save, { id: 'save', title: 'Ctrl+S' }),
    new Insert(editor, welcome.words.statements).button,
    action('Format', () => language.format(), { id: 'format', title: 'Ctrl+Shift+F' }),
    action('Rename', () => language.rename(), { id: 'rename', title: 'F2' }),
    h('input', { type: 'file', id: 'own', hidden: true, onchange: e => own(e.target) }));
  const list = $('#open');
  list.replaceChildren(h('option', { value: '' }, 'Examples…'),
    ...welcome.files.map(name => h('option', { value: name }, name)));
  list.onchange = () => {
    if (list.value) example(list.value).catch(error => tell(error.message, true));
    list.value = '';
  };
  const kept = localStorage.getItem(KEPT);
  if (kept === null) await example(FIRST);
  else await link.ask({ open: { name: '', text: kept, world: '' } });
}

async function read(path) {
  const answer = await fetch(path);
  if (!answer.ok) throw new Error(`${path}: ${answer.status}`);
  return answer.text();
}

async function example(name) {
  const world = name.replace(/\.\w+$/, '.rhai');
  const texts = [read(`examples/${name}`), worlds.includes(world) ? read(`examples/${world}`) : ''];
  const [program, around] = await Promise.all(texts);
  await parts.script.sync();
  await link.ask({ open: { name: name.replace(/.*\//, ''), text: program, world: around } });
  localStorage.removeItem(KEPT);
}

// A file of the visitor's: a script, or the program of another system.
async function own(input) {
  const [file] = input.files;
  input.value = '';
  if (!file) return;
  try {
    await parts.script.sync();
    await link.ask({ open: { name: file.name, text: await file.text(), world: '' } });
    localStorage.setItem(KEPT, parts.editor.value);
  } catch (error) { tell(error.message, true); }
}

function save() {
  const { script, editor } = parts;
  const at = URL.createObjectURL(new Blob([editor.value], { type: 'text/plain' }));
  h('a', { href: at, download: (script.file ?? 'script.bas').replace(/\.\w+$/, '.bas') }).click();
  URL.revokeObjectURL(at);
}

function title() {
  const { script } = parts;
  text($('#file'), script.file ?? 'new script');
  document.title = script.file ?? 'Pasapas';
}

addEventListener('keydown', e => {
  const { language, assist, editor } = parts;
  const ctrl = e.ctrlKey || e.metaKey, inside = document.activeElement === editor?.text;
  if (ctrl && e.key === 's') save();
  else if (ctrl && e.shiftKey && e.key.toLowerCase() === 'f') language?.format();
  else if (e.key === 'F2' && inside) language.rename();
  else if (e.key === 'F12' && inside) language.definition();
  else return;
  assist?.close();
  e.preventDefault();
});
