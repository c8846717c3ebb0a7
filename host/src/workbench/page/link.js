// The socket to the tool. Says who we are, numbers what is asked, and tells at once when it is lost.
import { hear } from './dom.js';
import { hmac } from './sha1.js';

// The key comes behind # and leaves the address bar; a reload of this tab still knows it.
function takeKey() {
	const key = decodeURIComponent(location.hash.slice(1));
	if (key) {
		sessionStorage.setItem('key', key);
		history.replaceState(null, '', location.pathname);
	}
	return sessionStorage.getItem('key') ?? '';
}

// How long without a state until the page says that it is blind, ms.
const BLIND = 1500;

export class Link extends EventTarget {
	open = false; known = false; state = null; drawn = 0;
	#asked = new Map(); #next = 1; #heard = 0; #bye = false;

	constructor() {
		super();
		this.key = takeKey();
		hear(this, 'state', e => this.#see(e.detail));
		setInterval(() => this.#watch(), 250);
		if (this.key) this.connect(); else queueMicrotask(() => this.#tell('locked', ''));
	}
	// Opens the socket anew, with another password if one is given.
	connect(password) {
		if (password !== undefined) { this.key = password; sessionStorage.setItem('key', password); }
		const scheme = location.protocol === 'https:' ? 'wss' : 'ws';
		const socket = new WebSocket(`${scheme}://${location.host}/ws`);
		socket.binaryType = 'arraybuffer';
		socket.onmessage = e => this.#hear(e.data);
		socket.onclose = () => this.#lose(socket);
		this.socket = socket;
	}
	ask(wish) {
		return new Promise((done, refused) => {
			if (!this.known) { refused(new Error('the tool does not answer')); return; }
			const ask = this.#next++;
			this.#asked.set(ask, { done, refused });
			this.socket.send(JSON.stringify({ ask, do: wish }));
		});
	}
	say(wish) {
		if (this.open) this.socket.send(JSON.stringify({ do: wish }));
	}
	#tell(name, detail) { this.dispatchEvent(new CustomEvent(name, { detail })); }
	#hear(data) {
		if (typeof data !== 'string') { this.#tell('path', data); return; }
		const message = JSON.parse(data);
		const name = Object.keys(message)[0], value = message[name];
		if (name === 'challenge') {
			this.open = true;
			this.socket.send(JSON.stringify({ do: { hello: { proof: hmac(this.key, value) } } }));
		} else if (name === 'done' || name === 'answer' || name === 'refused') {
			const asked = this.#asked.get(value.ask);
			this.#asked.delete(value.ask);
			if (!this.known && name === 'refused') { this.#tell('locked', value.words); this.key = ''; }
			else if (name === 'done') asked?.done(value.words);
			else if (name === 'answer') asked?.done(value.value);
			else if (asked) asked.refused(new Error(value.words));
			else this.#tell('words', value.words);
		} else {
			if (name === 'welcome') { this.known = true; this.#heard = performance.now(); }
			if (name === 'bye') this.#bye = true;
			this.#tell(name, value);
		}
	}
	#see(state) {
		this.#heard = performance.now();
		this.state = state;
		// Only what was painted counts as drawn: a hidden page paints nothing.
		requestAnimationFrame(() => { this.drawn = state.n; });
	}
	#watch() {
		if (this.known && performance.now() - this.#heard > BLIND) this.#tell('blind');
	}
	#lose(socket) {
		if (socket !== this.socket) return;
		const was = this.known;
		this.open = this.known = false;
		for (const { refused } of this.#asked.values()) refused(new Error('the tool is gone'));
		this.#asked.clear();
		if (was) this.#tell('lost', this.#bye);
		if (this.key && !this.#bye) setTimeout(() => this.connect(), 1000);
	}
}
