// Tabs: one of them is shown, on wide screens beside the script.
const tabs = [...document.querySelectorAll('[role=tab]')];

export function tab(name) {
  for (const own of tabs) {
    const on = own.dataset.tab === name;
    own.setAttribute('aria-selected', on);
    own.tabIndex = on ? 0 : -1;
    document.getElementById(own.getAttribute('aria-controls')).classList.toggle('shown', on);
  }
  document.body.dataset.tab = name;
}
tabs.forEach((own, n) => {
  own.addEventListener('click', () => tab(own.dataset.tab));
  own.addEventListener('keydown', e => {
    const by = { ArrowRight: 1, ArrowLeft: -1 }[e.key];
    if (!by) return;
    const next = tabs[(n + by + tabs.length) % tabs.length];
    next.focus();
    tab(next.dataset.tab);
  });
});
tab(matchMedia('(min-width: 1100px)').matches ? 'simulate' : 'script');
