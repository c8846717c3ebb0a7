// What the pages have in common: the password's form, words when the tool is silent, port and helm.
import { h, $, text, lamp, tell, hear } from './dom.js';

// `words`: when the tool is gone, says nothing, has ended; `more` is called then, too.
export function frame(link, words, more) {
	const blind = own => {
		$('#blind').hidden = false;
		text($('#blind'), own);
		document.body.classList.add('blind');
		more?.();
	};
	const said = h('p', { id: 'lock-words', role: 'alert' }), password = h('input', { id: 'password', type: 'password', ariaLabel: words.password ?? 'Password', autocomplete: 'off' });
	const lock = h('form', { id: 'lock', hidden: true, onsubmit: e => { e.preventDefault(); link.connect(password.value.trim()); } },
		h('h2', {}, words.password ?? 'Password of this workbench'), said, password, ' ', h('button', { type: 'submit' }, words.enter ?? 'Enter'));
	$('#notes').before(lock);
	hear(link, 'locked', e => { lock.hidden = false; text(said, e.detail); password.focus(); });
	hear(link, 'welcome', () => { lock.hidden = true; });
	hear(link, 'lost', e => blind(e.detail ? words.ended : words.gone));
	hear(link, 'blind', () => blind(words.silent));
	hear(link, 'bye', () => blind(words.ended));
	hear(link, 'words', e => tell(e.detail, true));
	hear(link, 'state', () => { $('#blind').hidden = true; document.body.classList.remove('blind'); });
}

export function head({ picture, mine, taken }) {
	const up = picture.port === 'up';
	lamp($('#port'), up);
	text($('#port-words'), up ? 'it answers' : picture.lost ?? 'opening the port');
	$('#helm').setAttribute('aria-pressed', mine);
	text($('#helm'), mine ? 'You have the helm' : taken ? 'Take the helm (another page has it)' : 'Take the helm');
}
export const SILENT = { silent: 'No news from the tool: what this page shows may be old.', ended: 'The workbench has ended.' };
