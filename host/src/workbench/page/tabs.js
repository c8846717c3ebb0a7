// Tabs: one of them is shown, on wide screens beside the script.
import { hear } from './dom.js';
const tabs = [...document.querySelectorAll('[role=tab]')];

export function tab(name) {
	for (const own of tabs) {
		const on = own.dataset.tab === name;
		own.setAttribute('aria-selected', on);
		own.tabIndex = on ? 0 : -1;
		document.getElementById(own.getAttribute('aria-controls')).classList.toggle('shown', on);
	}
	document.body.dataset.tab = name;
	document.dispatchEvent(new Event('tab'));
}
tabs.forEach((own, n) => {
	hear(own, 'click', () => tab(own.dataset.tab));
	hear(own, 'keydown', e => {
		const by = { ArrowRight: 1, ArrowLeft: -1 }[e.key];
		if (!by) return;
		// On a wide screen the script is beside all of them, and no tab.
		let next = own, at = n;
		do next = tabs[at = (at + by + tabs.length) % tabs.length]; while (!next.checkVisibility());
		next.focus();
		tab(next.dataset.tab);
	});
});
const wide = matchMedia('(min-width: 1100px)');
tab(wide.matches ? 'simulate' : 'script');
hear(wide, 'change', () => { if (wide.matches && document.body.dataset.tab === 'script') tab('simulate'); });
