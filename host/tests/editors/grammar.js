// Colours lines by the grammar, as an editor does: of the patterns that match, the one that begins
// first, then the one that stands first. `node grammar.js GRAMMAR LINE...` prints word and scope.
'use strict';
const grammar = JSON.parse(require('fs').readFileSync(process.argv[2], 'utf8'));
const rules = grammar.patterns.map(rule => ({ ...rule, pattern: new RegExp(rule.match.replace(/^\(\?i\)/, ''), rule.match.startsWith('(?i)') ? 'dgi' : 'dg') }));
for (const line of process.argv.slice(3)) {
  const out = [];
  for (let at = 0; at < line.length;) {
    let best = null;
    for (const rule of rules) {
      rule.pattern.lastIndex = at;
      const found = rule.pattern.exec(line);
      if (found && found[0] && (!best || found.index < best.found.index)) best = { rule, found };
    }
    if (!best) break;
    const { rule, found } = best;
    if (rule.name) out.push(`${found[0]}:${rule.name.replace('.pasapas', '')}`);
    for (const [n, capture] of Object.entries(rule.captures ?? {})) out.push(`${found[n]}:${capture.name.replace('.pasapas', '')}`);
    at = found.index + found[0].length;
  }
  console.log(out.join(' | '));
}
