// The page: puts its parts together and shows how things stand.
import { h, $, text, tell, action, lamp } from './dom.js';
import { Link } from './link.js';
import { lexer } from './lexer.js';
import { Editor } from './editor.js';
import { Script } from './document.js';
import { Language } from './language.js';
import { Assist } from './assist.js';
import { PathView } from './path.js';
import { Trial } from './trial.js';
import { Run } from './run.js';
import { Machine } from './machine.js';
import { Library } from './library.js';
import { Teach } from './teach.js';
import { Pattern } from './pattern.js';
import './tabs.js';

const link = new Link();
const parts = {};

link.addEventListener('locked', e => lock(e.detail));
link.addEventListener('welcome', e => begin(e.detail));
link.addEventListener('state', e => show(e.detail));
link.addEventListener('lost', e => blind(e.detail ? 'The workbench has ended.' : 'The tool does not answer: it was ended, or the way to it is cut.'));
link.addEventListener('blind', () => blind('No news from the tool: what this page shows may be old.'));
link.addEventListener('words', e => tell(e.detail, true));
link.addEventListener('bye', () => blind('The workbench has ended.'));

// The password's form: this page has no key, or a wrong one.
function lock(words) {
  $('#lock').hidden = false;
  text($('#lock-words'), words);
  $('#password').focus();
}
$('#lock').addEventListener('submit', e => {
  e.preventDefault();
  link.connect($('#password').value.trim());
});

function blind(words) {
  $('#blind').hidden = false;
  text($('#blind'), words);
  document.body.classList.add('blind');
}

function begin(welcome) {
  $('#lock').hidden = true;
  if (!parts.editor) build(welcome);
  parts.welcome = welcome;
  parts.language.can = welcome.lsp;
  parts.script.begin(welcome.text);
  files(welcome.files);
  parts.machine.build(parts.trial.about?.machine ?? welcome.machine, welcome.virtual_board);
  parts.view.machine ??= welcome.machine;
  parts.pattern.begin(parts.machine.machine);
  text($('#board'), welcome.virtual_board ? `emulated board (${welcome.board}):` : `${welcome.board}:`);
}

function build(welcome) {
  const editor = new Editor($('#editor'), lexer(welcome.words), (words, busy) => { parts.script.typed(words, busy); parts.trial?.stale(); }, () => {});
  editor.told = words => tell(words);
  const script = new Script(link, editor);
  const language = new Language(link, editor, script);
  const view = new PathView($('#path'));
  const trial = new Trial(link, view, editor);
  const assist = new Assist(editor, language);
  const run = new Run(link, editor, script, welcome.words.faults);
  run.broken = () => editor.diags.some(own => own.kind === 'error');
  const machine = new Machine(link);
  const teach = new Teach(link, machine, script), pattern = new Pattern(link, machine, script);
  pattern.view = view;
  const library = new Library(link);
  Object.assign(parts, { library, editor, script, language, assist, view, trial, run, machine, teach, pattern });
  trial.isNewest = about => about.number === script.number && script.synced;
  trial.file = () => script.file;
  trial.dispatch = about => {
    machine.build(about.machine, parts.welcome.virtual_board);
    pattern.begin(about.machine);
    if (trial.isNewest(about)) editor.halt(about.effects);
  };
  script.addEventListener('changed', title);
  const chosen = h('input', { type: 'file', id: 'own', hidden: true, onchange: e => {
    const [file] = e.target.files;
    e.target.value = '';
    if (file) take(file).catch(error => tell(error.message, true));
  } });
  $('#edit-buttons').append(
    action('Open a file…', () => chosen.click(), { id: 'open-file', title: 'A script, or a program of another system; it can be dropped on the page, too' }), chosen,
    action('Save', save, { id: 'save', title: 'Ctrl+S' }),
    action('Format', () => language.format(), { id: 'format', title: 'Ctrl+Shift+F' }),
    action('Rename', () => language.rename(), { id: 'rename', title: 'F2', hidden: !welcome.lsp?.renameProvider }));
  $('#helm').addEventListener('click', () => link.ask({ helm: !link.state?.mine }).catch(error => tell(error.message, true)));
  $('#quit').addEventListener('click', () => { if (confirm(parts.script?.dirty ? `${parts.script.file ?? 'The new script'} is not saved. End the workbench all the same? A copy stays beside it.` : 'End the workbench?')) link.say('quit'); });
  $('#theirs').addEventListener('click', () => script.takeTheirs());
  $('#mine').addEventListener('click', () => script.keepMine());
  $('#from-disk').addEventListener('click', () => link.ask({ reload: true }));
  $('#keep-text').addEventListener('click', () => link.ask({ reload: false }));
  for (const [id, stop] of [['#press-start', false], ['#press-stop', true]]) {
    let held = false;
    const press = down => { if (held !== down) link.say({ press: { stop, down: held = down } }); };
    const key = e => e.key === ' ' || e.key === 'Enter';
    $(id).addEventListener('pointerdown', () => press(true));
    for (const name of ['pointerup', 'pointercancel', 'pointerleave', 'blur']) $(id).addEventListener(name, () => press(false));
    $(id).addEventListener('keydown', e => { if (key(e)) press(true); });
    $(id).addEventListener('keyup', e => { if (key(e)) press(false); });
  }
}

// Stop is said before anything else, and works from every page.
$('#stop').addEventListener('pointerdown', stop);
$('#stop').addEventListener('click', stop);
function stop() {
  parts.machine?.jog.end();
  link.say('stop');
}

async function save() {
  const { script } = parts;
  const name = script.file ? undefined : prompt('Name of the script', 'script.bas');
  if (name === null) return;
  await script.save(name);
  tell('Saved.');
}

function title() {
  const { script } = parts;
  text($('#file'), (script.file ?? 'new script') + (script.dirty ? ' •' : ''));
  document.title = `${script.file ?? 'Pasapas'}${script.dirty ? ' •' : ''}`;
  $('#split').hidden = !script.split;
  $('#conflict').hidden = !script.conflict || script.split;
}

function files(names) {
  const list = $('#open');
  list.replaceChildren(h('option', { value: '' }, 'Open…'), ...names.map(name => h('option', { value: name }, name)));
  list.onchange = async () => {
    const name = list.value;
    list.value = '';
    if (!name) return;
    await parts.script.sync();
    link.ask({ open: name }).catch(error => tell(error.message, true));
  };
}

function show(state) {
  $('#blind').hidden = true;
  document.body.classList.remove('blind');
  const { picture } = state;
  const up = picture.port === 'up';
  lamp($('#port'), up);
  text($('#port-words'), up ? 'it answers' : picture.lost ?? 'opening the port');
  $('#helm').setAttribute('aria-pressed', state.mine);
  text($('#helm'), state.mine ? 'You have the helm' : state.taken ? 'Take the helm (another page has it)' : 'Take the helm');
  parts.run.show(state);
  parts.library.show(state);
  parts.machine.show(state);
  parts.teach.show(state);
  parts.trial.runs = parts.run.runs;
  const place = parts.machine.place(state);
  const { status } = picture;
  if (!status) return;
  if (status.runs !== parts.runs) { parts.view.trail = []; parts.runs = status.runs; }
  const homed = parts.machine.machine?.axes.every(axis => status.homed.includes(axis.axis)) ?? false;
  if (place) parts.view.follow(place, ['running', 'paused'].includes(status.state) && !picture.homing.length, homed);
}

addEventListener('keydown', e => {
  const { language, assist } = parts;
  const ctrl = e.ctrlKey || e.metaKey;
  if (e.key === 'Escape' && e.shiftKey) stop();
  else if (ctrl && e.key === 's') save().catch(error => tell(error.message, true));
  else if (ctrl && e.shiftKey && e.key.toLowerCase() === 'f') language?.format();
  else if (e.key === 'F2' && document.activeElement === parts.editor?.text) language.rename();
  else if (e.key === 'F12' && document.activeElement === parts.editor?.text) language.definition();
  else return;
  assist?.close();
  e.preventDefault();
});

// A file that is dropped on the page is taken as a new script.
addEventListener('dragover', e => { if (e.dataTransfer?.types.includes('Files')) e.preventDefault(); });
addEventListener('drop', e => {
  const [file] = e.dataTransfer?.files ?? [];
  if (!file || e.target.matches?.('input[type=file]')) return;
  e.preventDefault();
  take(file).catch(error => tell(error.message, true));
});
async function take(file) {
  if (file.size > 900000) throw new Error(`${file.name} is too large for the page: open it with “pasapas workbench ${file.name}”, or run it with “pasapas stream ${file.name}”.`);
  await parts.script.sync();
  await link.ask({ take: { name: file.name, text: await file.text() } });
}

// Leaving with work that the tool does not have asks first.
addEventListener('beforeunload', e => { if (parts.script && (!parts.script.synced || parts.script.split)) e.preventDefault(); });
