// Small helpers for elements.

// An element with attributes, properties (those that it has) and children.
export function h(tag, given = {}, ...children) {
  const element = document.createElement(tag);
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

// Sets a text only when it changes, so that screen readers are not told again and again.
export function text(element, value) {
  const words = String(value);
  if (element.textContent !== words) element.textContent = words;
}

// Switches a class or a lamp.
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

// A button that does something that may be refused in words.
export function action(label, run, given = {}) {
  return h('button', { type: 'button', ...given, onclick: async e => {
    try { await run(e); } catch (error) { tell(error.message, true); }
  } }, label);
}

export const mm = (value, digits = 3) => value.toFixed(digits).replace(/^-(0\.?0*)$/, '$1');

// A time in ms, s, min or h.
export function time(us) {
  if (us < 1e6) return `${(us / 1e3).toFixed(0)} ms`;
  if (us < 6e7) return `${(us / 1e6).toFixed(2)} s`;
  const s = Math.round(us / 1e6);
  const parts = [Math.floor(s / 3600), Math.floor(s / 60) % 60, s % 60];
  return (parts[0] ? `${parts[0]}:${String(parts[1]).padStart(2, '0')}` : `${parts[1]}`) + `:${String(parts[2]).padStart(2, '0')}`;
}
