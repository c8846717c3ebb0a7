// What Return does in a script: the new line is indented, a block that opens is closed, and a line that
// closes one goes back to where that begins.

const FAR = 2000;
const ENDS = [['IF', 'END IF'], ['FOR', 'NEXT'], ['WHILE', 'WEND'], ['DO', 'LOOP'], ['REPEAT', 'END REPEAT'], ['SELECT', 'END SELECT'],
	['SUB', 'END SUB'], ['FUNCTION', 'END FUNCTION']];
const END = /^(END\s+(?:IF|REPEAT|SELECT|SUB|FUNCTION)|NEXT|WEND|LOOP)\b/i, MIDDLE = /^(?:ELSEIF\b.*\bTHEN|ELSE|CASE\b.*)$/i;

const bare = line => line.replace(/"[^"]*"?/g, '""').replace(/'.*$/, '').trim();
const indent = line => /^[ \t]*/.exec(line)[0];
const closes = line => END.exec(bare(line))?.[1].toUpperCase().replace(/\s+/, ' ');

// The word that closes the block which a line opens; undefined where it opens none.
export function opens(line) {
	const words = bare(line), first = /^[A-Za-z]+/.exec(words)?.[0].toUpperCase();
	const end = ENDS.find(own => own[0] === first)?.[1];
	if (!end || first === 'IF' && !/\bTHEN$/i.test(words)) return undefined;
	return words.split(':').slice(1).some(part => closes(part)) ? undefined : end;
}

// Indentation of the line that opens the block which line `at` belongs to as its end or middle.
function opener(lines, at) {
	let depth = 0;
	for (let n = at - 1; n >= Math.max(0, at - FAR); n--) {
		if (closes(lines(n))) depth++;
		else if (opens(lines(n)) && depth-- === 0) return indent(lines(n));
	}
	return undefined;
}

// Whether the block that line `at` opens has its end: the next line that is not deeper is that.
function closed(lines, at, count, end) {
	const own = indent(lines(at)).length;
	for (let n = at + 1; n < Math.min(count, at + FAR); n++) {
		const line = lines(n);
		if (!line.trim() || indent(line).length > own || MIDDLE.test(bare(line))) continue;
		return indent(line).length === own && closes(line) === end;
	}
	return false;
}

// Return at the end of line `at` of `count`; `made(n)`: line n is an end that Return has written. Gives the line as it
// shall be, the next one's indentation, the end of the block, and whether the line below goes: this one is that end.
export function enter(lines, at, count, made) {
	const line = lines(at), end = opens(line), words = bare(line);
	if (end) {
		const open = indent(line), deep = end === 'END SELECT' ? open : open + '  ';
		const low = /^\s*[a-z]/.test(line) && !/[A-Z]/.test(/^\s*\w+/.exec(line)[0]);
		return { line, next: deep, end: closed(lines, at, count, end) ? '' : open + (low ? end.toLowerCase() : end) };
	}
	const middle = MIDDLE.test(words), close = closes(line);
	if (!middle && !close) return { line, next: indent(line), end: '' };
	const back = opener(lines, at) ?? indent(line);
	const own = back.length < indent(line).length ? back + line.trimStart() : line;
	const over = !!close && at + 1 < count && made(at + 1) && closes(lines(at + 1)) === close && indent(lines(at + 1)) === back;
	return { line: own, next: indent(own) + (middle ? '  ' : ''), end: '', over };
}
