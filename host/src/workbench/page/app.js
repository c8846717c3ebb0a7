// The page: puts its parts together and shows how things stand.
import { h, $, text, tell, action, refused, hear } from './dom.js';
import { Link } from './link.js';
import { frame, head, SILENT } from './frame.js';
import { lexer } from './lexer.js';
import { Editor } from './editor.js';
import { Script } from './document.js';
import { Language } from './language.js';
import { Assist } from './assist.js';
import { PathView } from './path.js';
import { Trial } from './trial.js';
import { Run } from './run.js';
import { Machine } from './machine.js';
import { held } from './jog.js';
import { Library } from './library.js';
import { Teach } from './teach.js';
import { Pattern } from './pattern.js';
import { Drag } from './drag.js';
import { Values } from './values.js';
import { Insert } from './insert.js';
import './tabs.js';

const link = new Link();
const parts = {};
frame(link, { ...SILENT, gone: 'The tool does not answer: it was ended, or the way to it is cut.' });

hear(link, 'welcome', e => begin(e.detail));
hear(link, 'state', e => show(e.detail));

function begin(welcome) {
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
	const run = new Run(link, editor, script);
	run.broken = () => editor.diags.some(own => own.kind === 'error');
	const machine = new Machine(link);
	run.axes = () => machine.machine?.axes ?? [];
	run.rest = ({ count, all }) => trial.rest(count / all);
	run.mark = places => view.show('spots', places);
	const teach = new Teach(link, machine, script), pattern = new Pattern(link, machine, script);
	pattern.view = teach.view = view;
	const library = new Library(link);
	Object.assign(parts, { library, editor, script, language, assist, view, trial, run, machine, teach, pattern });
	trial.isNewest = about => about.number === script.number && script.synced;
	trial.file = () => script.file;
	trial.dispatch = about => {
		machine.build(about.machine, parts.welcome.virtual_board);
		pattern.begin(about.machine);
		if (trial.isNewest(about)) trial.newest(about);
	};
	trial.newest = about => editor.halt(about.effects);
	hear(script, 'synced', () => trial.settle());
	trial.beside = new Values(editor, view);
	new Drag(editor, script, view, trial, () => trial.about?.machine ?? machine.machine);
	hear(script, 'changed', title);
	const chosen = h('input', { type: 'file', id: 'own', hidden: true, onchange: e => {
		const [file] = e.target.files;
		e.target.value = '';
		if (file) take(file).catch(refused);
	} });
	$('#edit-buttons').append(
		action('Open a file…', () => chosen.click(), { id: 'open-file', title: 'A script, or a program of another system; it can be dropped on the page, too' }), chosen,
		action('Save', save, { id: 'save', title: 'Ctrl+S' }),
		new Insert(editor, welcome.words.statements ?? []).button,
		action('Format', () => language.format(), { id: 'format', title: 'Ctrl+Shift+F' }),
		action('Rename', () => language.rename(), { id: 'rename', title: 'F2', hidden: !welcome.lsp?.renameProvider }));
	hear($('#helm'), 'click', () => link.ask({ helm: !link.state?.mine }).catch(refused));
	hear($('#quit'), 'click', () => { if (confirm(parts.script?.dirty ? `${parts.script.file ?? 'The new script'} is not saved. End the workbench all the same? A copy stays beside it.` : 'End the workbench?')) link.say('quit'); });
	hear($('#theirs'), 'click', () => script.takeTheirs());
	hear($('#mine'), 'click', () => script.keepMine());
	hear($('#from-disk'), 'click', () => link.ask({ reload: true }));
	hear($('#keep-text'), 'click', () => link.ask({ reload: false }));
	for (const [id, stop] of [['#press-start', false], ['#press-stop', true]]) {
		let is = false;
		const press = down => { if (is !== down) link.say({ press: { stop, down: is = down } }); };
		held($(id), () => press(true), () => press(false));
	}
}

hear($('#stop'), 'pointerdown click', stop);
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
	$('#long').hidden = !script.fixed;
	if (script.fixed) text($('#long'), `${(script.editor.lines.length - 1).toLocaleString('en')} lines: too long to be changed here. It is simulated, and Stream runs it; another editor may change its file.`);
	$('#format').disabled = $('#rename').disabled = $('#insert-statement').disabled = script.fixed;
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
		link.ask({ open: name }).catch(refused);
	};
}

function show(state) {
	const { picture } = state;
	head(state);
	parts.run.show(state);
	parts.library.show(state);
	parts.machine.show(state);
	parts.teach.show(state);
	if (parts.trial.runs !== parts.run.runs) { parts.trial.runs = parts.run.runs; parts.trial.besides(); }
	const place = parts.machine.place(state);
	const { status } = picture;
	if (!status) return;
	if (status.runs !== parts.runs) { parts.view.trail = []; parts.runs = status.runs; }
	const homed = parts.machine.machine?.axes.every(axis => status.homed.includes(axis.axis)) ?? false;
	if (place) parts.view.follow(place, ['running', 'paused'].includes(status.state) && !picture.homing.length, homed);
}

hear(window, 'keydown', e => {
	const { language, assist } = parts;
	const ctrl = e.ctrlKey || e.metaKey;
	if (e.key === 'Escape' && e.shiftKey) stop();
	else if (ctrl && e.key === 's') save().catch(refused);
	else if (ctrl && e.shiftKey && e.key.toLowerCase() === 'f') language?.format();
	else if (e.key === 'F2' && document.activeElement === parts.editor?.text) language.rename();
	else if (e.key === 'F12' && document.activeElement === parts.editor?.text) language.definition();
	else return;
	assist?.close();
	e.preventDefault();
});

hear(window, 'dragover', e => { if (e.dataTransfer?.types.includes('Files')) e.preventDefault(); });
hear(window, 'drop', e => {
	const [file] = e.dataTransfer?.files ?? [];
	if (!file || e.target.matches?.('input[type=file]')) return;
	e.preventDefault();
	take(file).catch(refused);
});
async function take(file) {
	if (file.size > 900000) throw new Error(`${file.name} is too large for the page: open it with “pasapas workbench ${file.name}”, or run it with “pasapas stream ${file.name}”.`);
	await parts.script.sync();
	await link.ask({ take: { name: file.name, text: await file.text() } });
}

hear(window, 'beforeunload', e => { if (parts.script && (!parts.script.synced || parts.script.split)) e.preventDefault(); });
