// Colours at the same frame as the key: the words come from the tool's own table, so that there is no
// second list of them.

export function lexer({ words, functions }) {
	const kinds = new Map([
		...words.map(word => [word.toLowerCase(), 'word']),
		...functions.map(word => [word.toLowerCase(), 'function']),
	]);
	const TOKEN = /('.*|\([^)\n]*\)(?=\s*$))|("[^"\n]*"?)|((?:\b\d[\d_]*(?:\.\d*)?|\.\d+)(?:[a-zA-Z]+(?:\/[a-z]+\d?)?)?|&[hHbB]\w*)|([A-Za-z_]\w*)/gm;
	const GCODE = /^[GMTFSXYZIJKPRLQHDN][+-]?\d/i;
	return function* lex(text) {
		for (const match of text.matchAll(TOKEN)) {
			const start = match.index, end = start + match[0].length;
			if (match[1]?.startsWith("'")) yield [start, end, 'remark'];
			else if (match[2]) yield [start, end, 'text'];
			else if (match[3]) yield [start, end, 'number'];
			else if (match[4]) {
				const kind = kinds.get(match[4].toLowerCase());
				if (kind) yield [start, end, kind];
				else if (GCODE.test(match[4])) {
					yield [start, start + 1, 'word'];
					yield [start + 1, end, 'number'];
				}
			}
		}
	};
}
