// Pictures of what hangs on which pin, from the tables of the firmware's manual.
import { h } from './dom.js';

const COLOURS = [['STEP', '#1f6feb'], ['DIR', '#0a8f5b'], ['UART', '#7a4fd0'], ['Stop', '#c0262d'], ['Start', '#0a8f5b'], ['output', '#b35900'], ['latch', '#b35900'], ['SPI', '#7a4fd0']];
// The name of SVG's elements, as the page's parser knows it.
const SPACE = new DOMParser().parseFromString('<svg></svg>', 'text/html').body.firstChild.namespaceURI;

function svg(name, given, ...children) {
	const own = document.createElementNS(SPACE, name);
	for (const [key, value] of Object.entries(given)) own.setAttribute(key, value);
	own.append(...children);
	return own;
}

// A chip with a row for each line of its table: pins in the chip, what they do beside it.
function picture({ chip, pins }) {
	const half = Math.ceil(pins.length / 2), high = 30 * half + 30;
	const parts = pins.flatMap(([names, words], n) => {
		const left = n < half, y = 30 + 30 * (left ? n : n - half);
		const colour = COLOURS.find(([start]) => words.includes(start))?.[1] ?? '#46536b';
		return [
			svg('rect', { x: left ? 200 : 540, y: y - 8, width: 20, height: 16, fill: colour }),
			svg('text', { x: left ? 226 : 534, y: y + 5, 'text-anchor': left ? 'start' : 'end', class: 'pin' }, names),
			svg('text', { x: left ? 192 : 568, y: y + 5, 'text-anchor': left ? 'end' : 'start' }, words),
		];
	});
	return svg('svg', { viewBox: `-70 0 900 ${high}`, class: 'chip', role: 'img', 'aria-label': `Pins of the ${chip}` },
		svg('rect', { x: 220, y: 8, width: 320, height: high - 16, rx: 6, fill: '#23272e' }), ...parts);
}

export function chips(tables, connected) {
	const own = tables.find(table => table.chip === connected) ?? tables[0];
	return [own, ...tables.filter(table => table !== own)].map(table => h('details', { open: table === own }, h('summary', {}, table.chip), picture(table),
		h('details', {}, h('summary', {}, 'as a table'), h('table', {}, h('tbody', {}, ...table.pins.map(([names, words]) => h('tr', {}, h('th', { scope: 'row' }, names), h('td', {}, words))))))));
}
