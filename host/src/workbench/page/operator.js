// What a person at the machine needs: program, quantities, Start, Pause, Stop, lamp and message. All
// texts about the work are the script's own.
import { h, $, text, tell, lamp } from './dom.js';
import { Link } from './link.js';

const link = new Link();
const WORDS = { empty: 'No program', ready: 'Ready', running: 'Running', paused: 'Paused', fault: 'Fault', waitstart: 'Press Start', stopping: 'Stopping' };
let faults = [], rows = [], state = null, program = null, printed = 0;

const refuse = error => tell(error.message, true);
link.addEventListener('locked', e => { $('#lock').hidden = false; text($('#lock-words'), e.detail); $('#password').focus(); });
$('#lock').addEventListener('submit', e => { e.preventDefault(); link.connect($('#password').value.trim()); });
link.addEventListener('lost', () => blind('The tool does not answer. Use the buttons at the machine.'));
link.addEventListener('blind', () => blind('No news from the machine. Use the buttons at the machine.'));
link.addEventListener('bye', () => blind('The workbench has ended.'));
function blind(words) { $('#blind').hidden = false; text($('#blind'), words); document.body.classList.add('blind'); }

link.addEventListener('welcome', e => {
  $('#lock').hidden = true;
  ({ faults } = e.detail.words);
  const { files, text: script } = e.detail;
  $('#program').replaceChildren(...files.map(name => h('option', { value: name }, name.replace(/\.bas$/i, ''))));
  if (script.file) $('#program').value = script.file;
  else $('#program').prepend(h('option', { value: '', selected: true }, '–'));
});
$('#program').addEventListener('change', async e => {
  try {
    if (e.target.value) await link.ask({ open: e.target.value });
    await link.ask('upload');
  } catch (error) { refuse(error); }
});
link.addEventListener('text', e => { if (e.detail.file) $('#program').value = e.detail.file; });

// Quantities: variables with AT or KEEP, with the label and the range that the script gives them.
link.addEventListener('program', e => {
  if (program && e.detail && program.crc === e.detail.crc) return;
  program = e.detail;
  rows = (program?.vars ?? []).filter(v => v.operator && v.len === 1).map(v => {
    const { label, low, high } = v, range = low > -(2 ** 31) || high < 2 ** 31 - 1;
    const input = h('input', { type: 'number', inputMode: 'numeric', min: low, max: high, ariaLabel: label });
    const set = async value => {
      if (!Number.isInteger(value) || value < low || value > high) {
        tell(range ? `${label}: ${low} to ${high}` : `${label}: a whole number`, true);
        return;
      }
      try { await link.ask({ set: { cell: v.cell, value } }); } catch (error) { refuse(error); }
    };
    input.addEventListener('change', () => set(+input.value));
    const step = by => h('button', { type: 'button', ariaLabel: `${label} ${by > 0 ? 'more' : 'less'}`,
      onclick: () => set(Math.max(low, Math.min(high, (state?.picture.cells[v.cell] ?? 0) + by))) }, by > 0 ? '+' : '−');
    return { cell: v.cell, input, box: h('div', { className: 'quantity' }, h('span', {}, label), step(-1), input, step(1), h('span', {}, v.unit)) };
  });
  $('#quantities').replaceChildren(...rows.map(row => row.box));
});
link.addEventListener('log', e => {
  for (const entry of e.detail) {
    if (entry.print !== undefined) { text($('#message'), entry.print); printed = performance.now(); }
    // What a short run prints is heard before its beginning is seen.
    else if (entry.begun !== undefined && performance.now() - printed > 1000) text($('#message'), '');
  }
});
link.addEventListener('state', e => {
  state = e.detail;
  $('#blind').hidden = true;
  document.body.classList.remove('blind');
  const { picture, mine } = state, { status } = picture, at = status?.state;
  const active = ['running', 'paused', 'waitstart', 'stopping'].includes(at);
  text($('#lamp'), status ? WORDS[at] ?? at : picture.lost ?? 'No board');
  $('#lamp').dataset.state = at ?? 'lost';
  text($('#start'), at === 'fault' ? 'Acknowledge' : at === 'paused' ? 'Resume' : 'Start');
  $('#start').disabled = !mine || !status || at === 'running' || at === 'stopping' || at === 'empty';
  $('#pause').disabled = !mine || at !== 'running';
  $('#program').disabled = !mine || active;
  $('#helm').hidden = mine;
  text($('#counter'), status ? `Runs since power-up: ${status.runs}` : '');
  for (const row of rows) {
    const value = String(picture.cells[row.cell] ?? 0);
    if (document.activeElement !== row.input && row.input.value !== value) row.input.value = value;
  }
  const fault = status && (at === 'fault' || status.last_end === 'fault' && !active) && faults.find(own => own.code === status.fault);
  $('#fault').hidden = !fault && !status?.blocked_by;
  const words = fault ? `${fault.code}: ${fault.text}. ${fault.remedy}` : '';
  text($('#fault'), words + (status?.input && fault ? ` Input ${status.input}.` : '') + (status?.blocked_by ? ` Input ${status.blocked_by} holds it.` : ''));
  lamp(document.body, at === 'running', 'runs');
});
$('#start').addEventListener('click', () => link.ask(state?.picture.status?.state === 'paused' ? 'resume' : 'start').catch(refuse));
$('#pause').addEventListener('click', () => link.ask('pause').catch(refuse));
$('#stop').addEventListener('pointerdown', () => link.say('stop'));
$('#stop').addEventListener('click', () => link.say('stop'));
$('#helm').addEventListener('click', () => link.ask({ helm: true }).catch(refuse));
addEventListener('keydown', e => { if (e.key === 'Escape') link.say('stop'); });
