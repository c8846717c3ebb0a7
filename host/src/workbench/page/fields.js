// Fields for numbers, and how what stands in them is read: by every button and key in the same way.
import { h } from './dom.js';

// A field that takes a point or a comma. Browsers drop what does not fit from fields of type number
// without a word: "20,5" became 205 there.
export function numberField(given = {}) {
	return h('input', { type: 'text', inputMode: given.whole ? 'numeric' : 'decimal', autocomplete: 'off', ...given,
		whole: undefined, className: `number ${given.className ?? ''}`.trim() });
}

export function parsed(text) {
	const words = text.trim().replace('−', '-').replace(',', '.');
	return /^[+-]?(\d+\.?\d*|\.\d+)$/.test(words) ? +words : null;
}

// The number in a field. Throws words and goes to the field where it is empty, half-typed, or no whole
// number where one is wanted.
export function number(field, { whole = false, unit = '' } = {}) {
	const value = parsed(field.value);
	if (value !== null && (!whole || Number.isInteger(value))) return value;
	field.focus();
	const name = field.ariaLabel || field.closest('label')?.firstChild?.textContent?.trim() || 'this field';
	const what = whole ? 'a whole number' : `a number${unit && ` of ${unit}`}`;
	throw new Error(field.value.trim() ? `${name}: “${field.value.trim()}” is not ${what}.` : `${name}: write ${what}.`);
}

export const micrometres = field => Math.round(number(field, { unit: 'mm' }) * 1000);
