export function h(tag, given = {}, ...children) {
	const element = document.createElement(tag);
	if (tag === 'button') element.type = 'button';
	for (const [name, value] of Object.entries(given)) {
		if (value === undefined || value === null || value === false) continue;
		if (name.startsWith('on')) element.addEventListener(name.slice(2), value);
		else if (name in element && name !== 'list' && name !== 'form') element[name] = value;
		else element.setAttribute(name, value === true ? '' : value);
	}
	element.append(...children.flat().filter(child => child !== null && child !== undefined));
	return element;
}

export const $ = selector => document.querySelector(selector);

// Listens to events, by their names with blanks between.
export const hear = (target, names, run, given) => { for (const name of names.split(' ')) target.addEventListener(name, run, given); };

// Sets a text only when it changes, so that screen readers are not told again and again.
export function text(element, value) {
	const words = String(value);
	if (element.textContent !== words) element.textContent = words;
}

export function lamp(element, on, kind = 'on') {
	if (element.classList.contains(kind) !== on) element.classList.toggle(kind, on);
}

// Tells words to the user for a while; errors stay longer and are read out.
export function tell(words, bad = false) {
	const place = $('#notes');
	const note = h('div', { className: bad ? 'note bad' : 'note', role: bad ? 'alert' : 'status' }, words);
	place.append(note);
	while (place.children.length > 3) place.firstChild.remove();
	setTimeout(() => note.remove(), bad ? 12000 : 4000);
}

export const refused = error => tell(error.message, true);

export function action(label, run, given = {}) {
	return h('button', { ...given, onclick: async e => {
		try { await run(e); } catch (error) { refused(error); }
	} }, label);
}

export const bar = (...parts) => h('div', { className: 'bar' }, ...parts);
export const label = (...parts) => h('label', {}, ...parts);

// The last of `count` for which `fits` holds, where it holds for all before it, too; -1: for none.
export function lastOf(count, fits) {
	let lo = -1, hi = count - 1;
	while (lo < hi) { const m = (lo + hi + 1) >> 1; if (fits(m)) lo = m; else hi = m - 1; }
	return lo;
}

// A canvas of so many px of the page, ready to be drawn on.
export function sheet(canvas, width = canvas.clientWidth, height = canvas.clientHeight, given = {}) {
	const ratio = devicePixelRatio || 1;
	canvas.width = width * ratio;
	canvas.height = height * ratio;
	const paper = canvas.getContext('2d', given);
	paper.scale(ratio, ratio);
	return paper;
}

// The page's colours at an element, by name.
export function inks(element) {
	const style = getComputedStyle(element);
	return name => style.getPropertyValue(name);
}

export const mm = (value, digits = 3) => value.toFixed(digits).replace(/^-(0\.?0*)$/, '$1');

export function time(us) {
	if (us < 1e6) return `${(us / 1e3).toFixed(0)} ms`;
	if (us < 6e7) return `${(us / 1e6).toFixed(2)} s`;
	const s = Math.round(us / 1e6);
	const parts = [Math.floor(s / 3600), Math.floor(s / 60) % 60, s % 60];
	return (parts[0] ? `${parts[0]}:${String(parts[1]).padStart(2, '0')}` : `${parts[1]}`) + `:${String(parts[2]).padStart(2, '0')}`;
}
