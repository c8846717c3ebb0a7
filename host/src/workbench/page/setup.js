// The set-up of a machine: which step is shown, what the machine does now, and what the tool keeps.
import { h, $, text, tell, action, mm, refused, hear } from './dom.js';
import { Link } from './link.js';
import { frame, head, SILENT } from './frame.js';
import { Jog } from './jog.js';
import { STEPS } from './steps.js';

const link = new Link();
let own = null, shown = null, current = '', state = null, chip = null;

// um/s of a jog in the set-up: slow, and no faster than the axis.
const SLOW = 3000;
const jog = new Jog(link, () => SLOW, () => 0);
jog.refused = words => tell(words, true);

frame(link, { ...SILENT, gone: 'The tool does not answer: use the emergency stop at the machine.' });
hear(link, 'welcome', e => {
	text($('#board'), `${e.detail.board}:`);
	link.ask({ setup: 'look' }).then(take).catch(refused);
});
hear(link, 'state', e => show(e.detail));

hear($('#stop'), 'pointerdown click', stop);
hear($('#halt'), 'click', stop);
hear(window, 'keydown', e => { if (e.key === 'Escape' && e.shiftKey) { stop(); e.preventDefault(); } });
function stop() { jog.end(); link.say('stop'); shown?.leave?.(); }
hear($('#helm'), 'click', () => link.ask({ helm: !state?.mine }).catch(refused));

// What the tool keeps: a set-up, or those that one can begin with.
function take(value) {
	own = value.profile ? value : null;
	chip = value.chip ?? chip;
	$('#begin').hidden = !!own;
	$('#guide').hidden = !own;
	text($('#file'), own?.name ?? '');
	if (!own) {
		$('#base').replaceChildren(...[...value.profiles, ...value.built_in].map(name => h('option', { value: name }, name)));
		$('#base').value = 'mill';
		$('#begun').replaceChildren(...value.begun.map(name => action(`Go on with ${name}`, () => open(name, null))));
		return;
	}
	if (!own.steps.some(step => step.id === current)) current = own.steps.find(step => !step.done)?.id ?? 'finish';
	steps();
	draw();
}
async function open(name, base) { take(await link.ask({ setup: { open: { name, base } } })); }
hear($('#begin'), 'submit', e => {
	e.preventDefault();
	open($('#name').value.trim(), $('#base').value).catch(refused);
});

function title(id) {
	const [step, letter] = id.split('_');
	return (letter ? `${letter.toUpperCase()}: ` : '') + STEPS[step].title;
}
function steps() {
	const list = [...own.steps, { id: 'finish' }];
	$('#steps').replaceChildren(...list.map(step => h('li', {}, h('button', {
		className: step.done ? 'done' : step.stale ? 'stale' : '', ariaCurrent: step.id === current ? 'step' : 'false',
		title: step.words ?? '', onclick: () => go(step.id) }, title(step.id)))));
	const at = list.findIndex(step => step.id === current);
	text($('#of'), `${at + 1} of ${list.length}`);
	for (const [id, to] of [['#previous', list[at - 1]], ['#following', list[at + 1]]]) {
		$(id).disabled = !to;
		$(id).onclick = () => go(to.id);
		$(id).title = to ? title(to.id) : '';
	}
	$('#steps [aria-current=step]')?.scrollIntoView({ block: 'nearest', inline: 'nearest' });
}
function go(id) {
	jog.end();
	current = id;
	steps();
	draw();
}

const kit = {
	get own() { return own; },
	get state() { return state; },
	get chip() { return chip; },
	link, jog,
	async ask(wish) { take(await link.ask({ setup: wish })); },
	change: patch => kit.ask({ change: patch }),
	done: (step, words) => kit.ask({ done: { step, words } }),
	async next(step, words) {
		await kit.done(step, words);
		const at = own.steps.findIndex(one => one.id === step);
		go((own.steps.slice(at + 1).find(one => !one.done) ?? { id: 'finish' }).id);
	},
	// Nothing is tried on a board that never got this machine, or (`now`) that has another one by now.
	must(now = false) {
		if (!own.board || now && !own.applied) throw new Error('bring the machine to the board first');
		return kit;
	},
	move: wish => link.ask(wish),
	// The machine's place of an axis in mm, by the profile in the making.
	async place(letter) { return (await link.ask('place'))[letter] * kit.step(letter); },
	step(letter) { const { scale } = own.profile[letter.toLowerCase()]; return scale.um / scale.steps / 1000; },
	pad: letter => [false, true].map(positive => {
		const button = h('button', { className: 'jog', ariaLabel: `Jog ${letter} ${positive ? 'plus' : 'minus'}` }, `${letter}${positive ? '+' : '−'}`);
		jog.arm(button, letter, positive);
		return button;
	}),
};

function draw() {
	shown?.leave?.();
	const [step, letter] = current.split('_');
	const done = own.steps.find(one => one.id === current);
	const box = $('#step');
	shown = STEPS[step].draw(kit, letter?.toUpperCase(), current);
	const bring = own.applied || ['wiring', 'link'].includes(step) && !done?.done && step !== 'link' ? null
		: h('p', { className: 'todo bar' }, 'The board does not have this machine yet. ',
			action('Bring it to the board', async () => { await kit.ask('apply'); tell('The board has this machine now.'); }, { id: 'apply' }),
			h('span', { className: 'soft' }, 'It takes the place of the program that is stored there, and restarts the board.'));
	box.replaceChildren(h('h2', {}, title(current)), ...[bring].filter(Boolean),
		done?.words && (done.done || done.stale) ? h('p', { className: done.done ? 'found' : 'todo' }, done.stale ? `Tried before with other values: ${done.words}` : done.words) : '',
		...shown.content);
	if (state) show(state);
}

function show(next) {
	state = next;
	const { status } = state.picture;
	head(state);
	$('#trying').hidden = !state.trial;
	text($('#trying-words'), state.trial ?? '');
	if (!own || !status) return;
	const rows = ['X', 'Y', 'Z'].filter(letter => own.profile[letter.toLowerCase()]).map(letter =>
		[letter, `${mm(status.pos[letter] * kit.step(letter), 2)} mm${status.homed.includes(letter) ? ', homed' : ''}${status.moving.includes(letter) ? ', moves' : ''}`]);
	rows.push(['Inputs on', status.inputs.join(', ') || 'none'], ['Outputs on', status.outputs.join(', ') || 'none'],
		['State', status.state === 'fault' ? `${status.fault} ${status.text}` : status.state]);
	const key = JSON.stringify([rows, state.mine]);
	if (key !== $('#now').dataset.key) {
		$('#now').dataset.key = key;
		$('#now').replaceChildren(h('dl', {}, ...rows.flatMap(([name, value]) => [h('dt', {}, name), h('dd', {}, value)])),
			status.state === 'fault' ? action('Acknowledge', () => link.ask('start'), { id: 'acknowledge' }) : '');
	}
	for (const button of $('#step').querySelectorAll('button, input, select')) button.disabled = !state.mine;
	shown?.show?.(state);
}
