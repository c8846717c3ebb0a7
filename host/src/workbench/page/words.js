// The operator page's own words in the languages of the people at the machine; the browser says which. What
// the script prints and names is the script's.
const en = {
	program: 'Program', start: 'Start', pause: 'Pause', stop: 'Stop', resume: 'Resume', acknowledge: 'Acknowledge', control: 'Take control',
	empty: 'No program', ready: 'Ready', running: 'Running', paused: 'Paused', fault: 'Fault', waitstart: 'Press Start', stopping: 'Stopping',
	loading: 'Loading', silent: 'The machine does not answer', noAnswer: 'No answer',
	toolGone: 'The tool does not answer. Use the buttons at the machine.', noNews: 'No news from the machine. Use the buttons at the machine.', ended: 'The workbench has ended.',
	load: name => `Load ${name}`, pressLoad: name => `Press Load ${name}, or choose a program.`, choose: 'Choose a program.',
	other: 'another program', none: 'no program', notHere: name => `${name} (its script is not here)`,
	holds: name => `The machine holds ${name}, whose script is not here.`,
	refused: (name, held) => `${name} could not be loaded. The machine still holds ${held}.`,
	taken: 'Another page is in control. Stop works from here too.', free: 'Nobody is in control.', power: 'The power was off: set the quantities again.',
	between: (label, low, high) => `${label}: between ${low} and ${high}.`, range: (low, high) => `${low} to ${high}`, more: label => `${label} more`, less: label => `${label} less`,
	input: n => `Input ${n}`, late: what => `${what} did not come in time.`, signal: 'A signal that the program waits for did not come in time.',
	blocks: what => `${what} keeps the machine from starting.`, unwired: 'The machine was never set up: ask the service.', thenAcknowledge: 'Put it right, press Acknowledge, then Start.', thenStart: 'Put it right, then press Start.',
	service: 'For the service', line: n => `Line ${n}.`, stopped: 'The emergency stop was pressed.',
};
const de = {
	program: 'Programm', start: 'Start', pause: 'Pause', stop: 'Stopp', resume: 'Weiter', acknowledge: 'Quittieren', control: 'Bedienung übernehmen',
	empty: 'Kein Programm', ready: 'Bereit', running: 'Läuft', paused: 'Pause', fault: 'Störung', waitstart: 'Start drücken', stopping: 'Hält an',
	loading: 'Wird geladen', silent: 'Die Maschine antwortet nicht', noAnswer: 'Keine Antwort',
	toolGone: 'Das Werkzeug antwortet nicht. Die Taster an der Maschine benutzen.', noNews: 'Keine Nachricht von der Maschine. Die Taster an der Maschine benutzen.', ended: 'Die Werkbank wurde beendet.',
	load: name => `${name} laden`, pressLoad: name => `„${name} laden“ drücken oder ein Programm wählen.`, choose: 'Ein Programm wählen.',
	other: 'ein anderes Programm', none: 'kein Programm', notHere: name => `${name} (Skript nicht vorhanden)`,
	holds: name => `In der Maschine ist ${name}; das Skript dazu ist nicht vorhanden.`,
	refused: (name, held) => `${name} konnte nicht geladen werden. In der Maschine ist weiterhin ${held}.`,
	taken: 'Eine andere Seite bedient die Maschine. Stopp wirkt auch von hier.', free: 'Niemand bedient die Maschine.', power: 'Der Strom war weg: die Mengen neu einstellen.',
	between: (label, low, high) => `${label}: zwischen ${low} und ${high}.`, range: (low, high) => `${low} bis ${high}`, more: label => `${label} mehr`, less: label => `${label} weniger`,
	input: n => `Eingang ${n}`, late: what => `${what} kam nicht rechtzeitig.`, signal: 'Ein Signal, auf das das Programm wartet, kam nicht rechtzeitig.',
	blocks: what => `${what} verhindert den Start.`, unwired: 'Die Maschine wurde nie eingerichtet: den Service rufen.', thenAcknowledge: 'Beheben, Quittieren drücken, dann Start.', thenStart: 'Beheben, dann Start drücken.',
	service: 'Für den Service', line: n => `Zeile ${n}.`, stopped: 'Der Not-Halt wurde gedrückt.',
};
const fr = {
	program: 'Programme', start: 'Départ', pause: 'Pause', stop: 'Arrêt', resume: 'Reprendre', acknowledge: 'Acquitter', control: 'Prendre la main',
	empty: 'Aucun programme', ready: 'Prêt', running: 'En marche', paused: 'En pause', fault: 'Défaut', waitstart: 'Appuyer sur Départ', stopping: 'Arrêt en cours',
	loading: 'Chargement', silent: 'La machine ne répond pas', noAnswer: 'Pas de réponse',
	toolGone: 'L’outil ne répond pas. Utiliser les boutons de la machine.', noNews: 'Pas de nouvelles de la machine. Utiliser les boutons de la machine.', ended: 'L’atelier a été fermé.',
	load: name => `Charger ${name}`, pressLoad: name => `Appuyer sur « Charger ${name} » ou choisir un programme.`, choose: 'Choisir un programme.',
	other: 'un autre programme', none: 'aucun programme', notHere: name => `${name} (script absent)`,
	holds: name => `La machine contient ${name}, dont le script n’est pas ici.`,
	refused: (name, held) => `${name} n’a pas pu être chargé. La machine contient toujours ${held}.`,
	taken: 'Une autre page commande la machine. Arrêt agit aussi d’ici.', free: 'Personne ne commande la machine.', power: 'Le courant a été coupé : régler de nouveau les quantités.',
	between: (label, low, high) => `${label} : entre ${low} et ${high}.`, range: (low, high) => `${low} à ${high}`, more: label => `${label} plus`, less: label => `${label} moins`,
	input: n => `Entrée ${n}`, late: what => `${what} n’est pas venue à temps.`, signal: 'Un signal attendu par le programme n’est pas venu à temps.',
	blocks: what => `${what} empêche le départ.`, unwired: 'La machine n’a jamais été configurée : appeler le service.', thenAcknowledge: 'Remédier, appuyer sur Acquitter, puis sur Départ.', thenStart: 'Remédier, puis appuyer sur Départ.',
	service: 'Pour le service', line: n => `Ligne ${n}.`, stopped: 'L’arrêt d’urgence a été actionné.',
};
export const LANGUAGES = { en, de, fr };
const found = navigator.languages.map(own => own.slice(0, 2).toLowerCase()).find(own => LANGUAGES[own]) ?? 'en';
export const language = found, words = LANGUAGES[found];
