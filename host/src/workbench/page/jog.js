// Buttons that move an axis while they are held.
//
// The page says "go on" every 100 ms from its main thread, with the number of the newest state that
// it has painted: a page that hangs, hides or is gone says nothing, and the board ends by itself. What
// ends a hold here makes it end sooner, and nothing relies on it.
import { hear } from './dom.js';

const PERIOD = 100;

// What is done as long as a button is held, by pointer or key; not while `holds` says no.
export function held(button, begin, end, holds = () => true) {
	hear(button, 'pointerdown', e => {
		if (!e.isPrimary || e.button !== 0) return;
		e.preventDefault();
		button.focus({ preventScroll: true });
		if (!holds()) return;
		button.setPointerCapture(e.pointerId);
		begin();
	});
	hear(button, 'pointerup pointercancel lostpointercapture blur', end);
	hear(button, 'contextmenu', e => e.preventDefault());
	hear(button, 'keydown keyup', e => {
		if (e.key !== ' ' && e.key !== 'Enter' || !holds()) return;
		e.preventDefault();
		if (e.type === 'keyup') end(); else if (!e.repeat) begin();
	});
}

export class Jog {
	// Numbers of holds never come twice, in other pages neither.
	static #next = Date.now() * 1000;
	#held = null; #way = null; #last = 0;

	constructor(link, speed, step) {
		Object.assign(this, { link, speed, step });
		hear(window, 'blur pagehide freeze', () => this.end());
		hear(document, 'visibilitychange', () => this.end());
		hear(link, 'lost', () => this.end());
		hear(link, 'ended', e => {
			if (e.detail.id === this.#last) this.#follow();
			if (e.detail.id === this.#held?.id) this.#over();
		});
		hear(link, 'state', e => this.#look(e.detail));
	}
	get held() { return this.#held !== null; }

	// Makes a button move an axis; by a step, or as long as it is held.
	arm(button, axis, positive) {
		held(button, () => this.begin(button, axis, positive), () => this.end(), () => this.step() === 0);
		hear(button, 'click', () => {
			const step = this.step();
			if (step !== 0) this.move(axis, positive ? step : -step);
		});
	}
	// Makes a button go to a place while it is held, an axis after the other: `plan` gives
	// [[axis, machine position in steps], ...]. Who lets go stops it; at the place it rests.
	armTo(button, plan) {
		held(button, () => {
			this.#way = { button, rest: plan() };
			this.#last = 0;
			this.#follow();
		}, () => this.end());
	}
	// The next axis of the way, when the one before is at its place and its hold is over.
	#follow() {
		const way = this.#way, pos = this.link.state?.picture.status?.pos;
		if (!way || !pos) return;
		const next = way.rest.find(([axis, steps]) => pos[axis] !== steps);
		if (!next) { this.#way = null; this.arrived?.(); return; }
		way.rest = way.rest.slice(way.rest.indexOf(next));
		const [axis, steps] = next;
		this.begin(way.button, axis, steps > pos[axis], steps);
		this.#held.steps = steps;
		this.#way = way;
	}
	#look(state) {
		const held = this.#held, { status } = state.picture;
		if (!this.#way || held?.steps === undefined || status?.pos[held.axis] !== held.steps) return;
		this.#last = held.id;
		this.link.say({ release: held.id });
		this.#over();
	}
	begin(button, axis, positive, to) {
		this.end();
		const id = Jog.#next++;
		button.classList.add('held');
		const hold = { id, button, axis };
		this.#held = hold;
		hold.timer = setInterval(() => this.link.say({ keep: { id, echo: this.link.drawn } }), PERIOD);
		this.link.ask({ hold: { id, axis, positive, speed: this.speed(), to } }).catch(error => {
			if (this.#held === hold) { this.#way = null; this.#over(); }
			this.refused?.(error.message);
		});
	}
	end() {
		this.#way = null;
		if (!this.#held) return;
		this.link.say({ release: this.#held.id });
		this.#over();
	}
	#over() {
		clearInterval(this.#held.timer);
		this.#held.button.classList.remove('held');
		this.#held = null;
	}
}
