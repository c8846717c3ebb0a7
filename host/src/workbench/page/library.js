// The programs that the board holds: which of them Start runs, and which go.
import { h, $, action, text } from './dom.js';

export class Library {
	#seen = ''; #mine = false;

	constructor(link) {
		this.link = link;
		this.list = h('tbody', {});
		this.free = h('p', { className: 'soft' });
		$('#library').append(h('h2', {}, 'Programs on the board'), h('table', {}, this.list), this.free);
	}
	// Read again whenever the board's program or its room is another one.
	show({ picture, mine }) {
		const { identity } = picture;
		const now = identity ? [identity.program_crc, identity.program_bytes, identity.free_bytes].join() : '';
		if (now === this.#seen && mine === this.#mine) return;
		[this.#seen, this.#mine] = [now, mine];
		if (now) this.#ask('library').catch(() => { this.#seen = ''; });
		else $('#library').hidden = true;
	}
	async #ask(wish) {
		const found = await this.link.ask(wish);
		$('#library').hidden = !found?.programs.length;
		this.list.replaceChildren(...(found?.programs ?? []).map(own => {
			const chosen = own.number === found.selected, name = own.name || `program ${own.number}`;
			const choose = chosen ? h('strong', {}, 'Start runs it')
				: action('Choose', () => this.#ask({ choose: own.number }), { ariaLabel: `Choose ${name}`, disabled: !this.#mine });
			const erase = action('Erase', () => confirm(`Erase ${name}?`) && this.#ask({ erase: own.number }), { ariaLabel: `Erase ${name}`, disabled: !this.#mine });
			return h('tr', {}, h('td', {}, String(own.number)), h('th', { scope: 'row' }, name),
				h('td', {}, `${own.bytes} bytes`), h('td', {}, choose), h('td', {}, erase));
		}));
		text(this.free, found ? `${found.free} bytes are free for another one.` : '');
	}
}
