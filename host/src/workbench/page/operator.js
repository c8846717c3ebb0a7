// What a person at the machine needs. What is named as the program is what the board holds: a choice takes its place
// when it has been loaded, and not before.
import { h, $, text, tell, lamp, hear } from './dom.js';
import { number, numberField } from './fields.js';
import { Link } from './link.js';
import { frame } from './frame.js';
import { language, words as say } from './words.js';

const link = new Link();
for (const name of ['start', 'pause', 'stop']) text($(`#${name}`), say[name]);
text($('.program span'), say.program);
text($('h1'), say.machine);
$('#bar').ariaLabel = say.progress;
text($('#helm'), say.control);
document.documentElement.lang = language;
const ACTIVE = ['running', 'paused', 'waitstart', 'stopping'];
let files = [], rows = [], state = null, program = null;
// The script that the tool was started with; the program that is being loaded; the power was off.
let offer = null, loading = null, power = false, before = null, lost = false;

const short = name => name.replace(/\.bas$/i, '');
const refuse = error => tell(error.message, true);
frame(link, { ...say, gone: say.toolGone, silent: say.noNews, ended: say.ended }, () => {
	text($('#lamp'), say.noAnswer);
	$('#lamp').dataset.state = 'lost';
	text($('#hint'), '');
	$('#start').disabled = $('#pause').disabled = $('#program').disabled = true;
	lamp(document.body, false, 'runs');
});

hear(link, 'welcome', e => {
	({ files } = e.detail);
	offer ??= e.detail.text.file;
});

// The file of the program that the board holds, if its script is here.
const held = () => {
	const { holds } = state ?? {};
	return holds?.known ? files.find(name => name === holds.name || short(name) === holds.name) : undefined;
};
const heldWords = () => state?.holds ? state.holds.name ? short(state.holds.name) : say.other : say.none;

hear($('#program'), 'change', e => load(e.target.value));
hear($('#load'), 'click', () => load(offer));
async function load(name) {
	if (!name || loading) { list(); return; }
	loading = name;
	part = 0;
	$('#refused').hidden = true;
	text($('#message'), '');
	show();
	try {
		await seen(await link.ask({ bring: name }));
		offer = null;
	} catch (error) {
		$('#refused').hidden = false;
		$('#refused').replaceChildren(say.refused(short(name), heldWords()), h('small', {}, error.message));
	} finally {
		loading = null;
		show();
	}
}
// A program counts as loaded when a state names it: Start would ask for the old one before.
const seen = program => new Promise(done => {
	const look = () => {
		const { identity } = state?.picture ?? {};
		if (identity?.program_bytes !== program.bytes || identity.program_crc !== program.crc) return false;
		link.removeEventListener('state', look);
		clearTimeout(late);
		done();
		return true;
	};
	// The board may be lost or have another program by now: the state tells.
	const late = setTimeout(() => { link.removeEventListener('state', look); done(); }, 5000);
	if (!look()) hear(link, 'state', look);
});
function list() {
	const own = held(), other = own ? [] : [['', state?.holds ? say.notHere(heldWords()) : '–']];
	const all = [...other, ...files.map(name => [name, short(name)])], key = JSON.stringify(all);
	const box = $('#program');
	if (box.dataset.key !== key) {
		box.dataset.key = key;
		box.replaceChildren(...all.map(([value, label]) => h('option', { value }, label)));
	}
	box.value = loading ?? own ?? '';
}

hear(link, 'program', e => {
	if (program && e.detail && program.crc === e.detail.crc) return;
	program = e.detail;
	text($('#message'), '');
	rows = (program?.vars ?? []).filter(v => v.operator && v.len === 1).map(quantity);
	$('#quantities').replaceChildren(...rows.map(row => row.box));
	if (state) show();
});
function quantity(v) {
	const { label, low, high, cell } = v, range = low > -(2 ** 31) || high < 2 ** 31 - 1;
	const input = numberField({ whole: true, ariaLabel: label });
	const set = async value => {
		if (value < low || value > high) {
			tell(range ? `${label}: ${say.range(low, high)}` : `${label}: 32 bit`, true);
			return;
		}
		power = false;
		try { await link.ask({ set: { cell, value } }); } catch (error) { refuse(error); }
	};
	hear(input, 'change', () => {
		try { set(number(input, { whole: true })); } catch (error) { refuse(error); }
		// What the board holds stands in the field again.
		input.blur();
	});
	const step = by => h('button', { ariaLabel: by > 0 ? say.more(label) : say.less(label),
		onclick: () => set(Math.max(low, Math.min(high, (state?.picture.cells[cell] ?? 0) + by))) }, by > 0 ? '+' : '−');
	const box = h('div', { className: 'quantity' }, h('span', { className: 'label' }, label, range ? h('span', { className: 'range soft' }, ` (${say.range(low, high)})`) : ''),
		step(-1), input, step(1), h('span', {}, v.unit));
	return { ...v, input, box };
}
// Feeds in per cent of what is written; slower, and back.
const pace = h('output', { className: 'number' }), paces = [-10, 10].map(by => h('button', { ariaLabel: by > 0 ? say.more(say.speed) : say.less(say.speed), onclick: () => {
	const [feed, rapid] = state.picture.overrides;
	link.ask({ override: [Math.max(10, Math.min(100, feed + by)), rapid] }).catch(refuse);
} }, by > 0 ? '+' : '−'));
$('#speed').append(h('span', { className: 'label' }, say.speed), paces[0], pace, paces[1]);

const value = row => state?.picture.cells[row.cell];
// What the program keeps by itself (KEEP) is set while it runs, and not asked for before.
const wrong = row => row.before && (value(row) < row.low || value(row) > row.high);

hear(link, 'log', e => {
	for (const entry of e.detail) {
		if (entry.print !== undefined) { text($('#message'), entry.print); printed = performance.now(); }
		// What a short run prints is heard before its beginning is seen.
		else if (entry.begun !== undefined && performance.now() - printed > 1000) text($('#message'), '');
	}
});
let printed = 0;
// The bar: of an upload, or of a program that prints how far it is, as “Piece 3 of 5” or “3/5”.
let part = null;
hear(link, 'progress', e => { part = e.detail.part; bar(); });
function bar() {
	const [, n, all] = /(\d+)\s*(?:of|von|sur|de|\/)\s*(\d+)/i.exec($('#message').textContent) ?? [];
	const far = loading ? part : +n <= +all && +all > 0 ? n / all : null;
	$('#bar').hidden = far === null;
	if (far !== null) $('#bar').value = far;
}

hear(link, 'state', e => {
	state = e.detail;
	look();
	show();
});
// Whether the power was off: the board counts its runs anew, or quantities are zero that were not.
function look() {
	const { status, cells } = state.picture;
	if (!status) { lost = true; return; }
	const zeroed = rows.some(row => before?.cells[row.cell] && !cells[row.cell]);
	if (lost && before && rows.length && (status.runs < before.runs || zeroed)) power = true;
	if (before && before.active && status.state === 'ready' && status.last_end === 'stopped') text($('#message'), '');
	lost = false;
	before = { runs: status.runs, cells: [...cells], active: ACTIVE.includes(status.state) };
}
function show() {
	if (!state) return;
	const { picture, mine } = state, { status } = picture, at = status?.state, active = ACTIVE.includes(at);
	list();
	const bad = rows.find(wrong), ready = at === 'ready';
	const may = !ready || held() && !bad && !loading;
	text($('#lamp'), loading ? say.loading : status ? say[at] ?? at : say.silent);
	$('#lamp').dataset.state = at ?? 'lost';
	text($('#start'), at === 'fault' ? say.acknowledge : at === 'paused' ? say.resume : say.start);
	$('#start').disabled = !mine || !status || at === 'running' || at === 'stopping' || at === 'empty' || !may;
	$('#pause').disabled = !mine || at !== 'running';
	$('#program').disabled = !mine || active || !!loading;
	$('#load').hidden = !offer || offer === held() || active || !status;
	$('#load').disabled = !mine || !!loading;
	text($('#load'), say.load(short(offer ?? '')));
	$('#helm').hidden = mine;
	hint(status, mine, ready || at === 'empty', bad);
	for (const row of rows) {
		const shown = String(value(row) ?? '');
		if (document.activeElement !== row.input && row.input.value !== shown) row.input.value = shown;
		if (row.box.classList.contains('wrong') !== wrong(row)) {
			row.box.classList.toggle('wrong', wrong(row));
			row.input.setAttribute('aria-invalid', wrong(row));
		}
	}
	const [feed] = picture.overrides;
	$('#speed').hidden = !status || !feed;
	text(pace, `${feed} %`);
	paces.forEach((own, n) => { own.disabled = !mine || (n ? feed >= 100 : feed <= 10); });
	fault(status, at, active);
	lamp(document.body, at === 'running', 'runs');
	bar();
}
function hint(status, mine, rests, bad) {
	const load = offer && offer !== held() ? say.pressLoad(short(offer)) : say.choose;
	let words = '';
	if (!status || loading) words = '';
	else if (!mine) words = state.taken ? say.taken : say.free;
	else if (rests && !held()) words = state.holds ? `${say.holds(heldWords())} ${load}` : load;
	else if (power) words = say.power;
	else if (rests && bad) words = say.between(bad.label, bad.low, bad.high);
	const key = words + (status ? '' : picture());
	if ($('#hint').dataset.key === key) return;
	$('#hint').dataset.key = key;
	$('#hint').replaceChildren(words, ...status ? [] : [h('small', {}, picture())]);
}
const picture = () => state.picture.lost ?? '';
// A fault in words for whoever stands at the machine; the technical ones are folded.
function fault(status, at, active) {
	const own = status && (at === 'fault' || status.last_end === 'fault' && !active) && status.fault;
	const card = $('#fault'), key = own ? `${own}/${status.text}/${status.input}/${at}` : `/${status?.blocked_by ?? ''}`;
	card.hidden = !own && !status?.blocked_by;
	if (card.dataset.key === key) return;
	card.dataset.key = key;
	const named = n => {
		const name = program?.machine?.inputs.find(one => one.n === n)?.name;
		return name ? `${say.input(n)}, ${name},` : say.input(n);
	};
	if (!own) { card.replaceChildren(!status?.blocked_by ? '' : status.blocked_by === 255 ? say.unwired : say.blocks(named(status.blocked_by))); return; }
	const input = status.input ? named(status.input) : '';
	const what = own === 'F13' ? input ? say.late(input) : say.signal
		: own === 'F14' && status.text === 'emergency stop' ? say.stopped : `${language === 'en' ? status.text : `${say.fault} ${own}`}.${input ? ` ${input.replace(/,$/, '')}.` : ''}`;
	card.replaceChildren(h('div', {}, what, ' ', at === 'fault' ? say.thenAcknowledge : say.thenStart),
		h('details', {}, h('summary', {}, say.service), `${own}: ${status.text}. ${status.advice.join(' ')}${status.line ? ` ${say.line(status.line)}` : ''}`));
}
hear($('#start'), 'click', () => {
	$('#refused').hidden = true;
	const { status, identity } = state?.picture ?? {};
	if (status?.state === 'paused') link.ask('resume').catch(refuse);
	else if (identity) link.ask({ run: { bytes: identity.program_bytes, crc: identity.program_crc } }).catch(refuse);
});
hear($('#pause'), 'click', () => link.ask('pause').catch(refuse));
hear($('#stop'), 'pointerdown click', () => link.say('stop'));
hear($('#helm'), 'click', () => link.ask({ helm: true }).catch(refuse));
hear(window, 'keydown', e => { if (e.key === 'Escape') link.say('stop'); });
