// Top rate and ramp by trial: faster and faster to and fro, until the switch says that steps were lost.
import { h, text, tell, action, mm, bar } from './dom.js';
import { micrometres, number, numberField } from './fields.js';

// From one trial to the next, and what of the last good one is taken.
const FASTER = 1.25, SAFE = 2 / 3;

export function rate(kit, letter, id) {
	const low = letter.toLowerCase(), own = kit.own.profile[low];
	const field = (label, value) => numberField({ value, ariaLabel: label });
	const first = field('First rate, steps/s', own.home.fast_rate), last = field('Fastest rate, steps/s', own.top_rate);
	const ramp = field('Ramp, steps/s2', own.accel), way = field('Way, mm', Math.min(50, Math.round((own.max_um - own.min_um) / 2000))), times = field('Times', 3);
	const list = h('ol', { id: 'trials', className: 'lines' }), told = h('p', { role: 'status', id: 'trial-words' });
	let going = false, best = null, tried = 0;
	const row = (steps, found) => list.append(h('li', { className: found.good ? '' : 'bad' }, `${Math.round(steps)} steps/s (${mm(steps * kit.step(letter), 1)} mm/s): ${found.words}`));
	const climb = async () => {
		if (going) { going = false; return; }
		kit.must(true);
		const [from, to, accel] = [first, last, ramp].map(field => number(field));
		const how = { axis: letter, accel: Math.round(accel), way_um: micrometres(way), times: number(times, { whole: true }) };
		going = true;
		text(go, 'Halt after this one');
		text(told, '');
		list.replaceChildren();
		best = null;
		try {
			for (let speed = from; going; speed = Math.min(speed * FASTER, to)) {
				text(told, `${Math.round(speed)} steps/s…`);
				const found = await kit.link.ask({ setup: { trial: { ...how, rate: Math.round(speed) } } });
				row(speed, found);
				if (!found.good) break;
				best = speed;
				tried = how.accel;
				if (speed >= to) break;
			}
			text(told, best ? `Up to ${Math.round(best)} steps/s no step was lost.` : 'Steps were lost at the first rate: begin slower, or with a flatter ramp.');
		} catch (error) {
			text(told, error.message);
			tell(error.message, true);
		} finally {
			going = false;
			text(go, 'Try faster and faster');
			take.hidden = !best;
		}
	};
	const go = action('Try faster and faster', climb, { id: 'climb' });
	const take = action('Take two thirds of it', async () => {
		const top = Math.max(own.home.fast_rate, Math.round(best * SAFE)), accel = Math.max(100, Math.round(tried * SAFE));
		await kit.change({ [low]: { top_rate: top, accel, start_rate: Math.min(own.start_rate, top) } });
		await kit.next(id, `no step lost at ${Math.round(best)} steps/s and ${tried} steps/s2, judged by the switch; two thirds are taken: ${top} steps/s, ${accel} steps/s2`);
	}, { id: 'take-rate', hidden: true });
	// Another step ends it: no faster try begins, and the one that runs stops.
	const leave = () => {
		if (going) kit.link.say('stop');
		going = false;
	};
	return { leave, content: [
		h('p', {}, `The axis homes, looks where its switch closes, runs to and fro, and looks again: steps that were lost stand between the two. Its way must be free from the switch on. Faster and faster, then a steeper ramp if you like; of what went well two thirds are taken.`),
		bar(...[['From', first, 'steps/s'], ['up to', last, 'steps/s'], ['ramp', ramp, 'steps/s²'], ['over', way, 'mm'], ['each', times, 'times']].map(([label, input, unit]) => h('label', {}, `${label} `, input, ` ${unit}`))),
		bar(go, take, action('Keep what it has', () => kit.next(id, `${own.top_rate} steps/s, ${own.accel} steps/s2, not tried to their end`), { id: 'keep-rate' })),
		told, list,
	] };
}
