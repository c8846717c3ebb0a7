// The extension in a stand-in for the editor, with the real language server.
'use strict';
const assert = require('assert');
const path = require('path');
const Module = require('module');
const [, , folder, tool] = process.argv;

class Position { constructor(line, character) { Object.assign(this, { line, character }); } }
class Range {
  constructor(a, b, c, d) { this.start = new Position(a, b); this.end = new Position(c, d); }
}
class Uri {
  constructor(text) { this.text = text; }
  static parse(text) { return new Uri(text); }
  toString() { return this.text; }
}
const record = (...fields) => class { constructor(...values) { fields.forEach((field, n) => { this[field] = values[n]; }); } };
class WorkspaceEdit { all = []; set(uri, edits) { this.all.push([uri, edits]); } }
const providers = {}, events = {}, commands = {}, shown = new Map(), problems = [];
let adapter, configurations, tasks;
const on = name => listener => { events[name] = listener; return { dispose() {} }; };
const languages = new Proxy({
  createDiagnosticCollection: () => ({ set(uri, list) { shown.set(uri.toString(), list); }, dispose() {} }),
}, {
  get: (own, name) => own[name] ?? ((language, provider, ...more) => {
    assert.strictEqual(language, 'pasapas');
    providers[name] = Object.assign(provider, { more });
    return { dispose() {} };
  }),
});
const vscode = {
  Position, Range, Uri, WorkspaceEdit, languages,
  Diagnostic: record('range', 'message', 'severity'),
  DiagnosticRelatedInformation: record('location', 'message'),
  Location: record('uri', 'range'), TextEdit: record('range', 'newText'), Hover: record('contents', 'range'),
  MarkdownString: record('value'), CompletionItem: record('label', 'kind'), SignatureHelp: class {},
  SignatureInformation: record('label', 'documentation'), ParameterInformation: record('label'),
  DocumentHighlight: record('range', 'kind'), CodeAction: record('title', 'kind'), CodeActionKind: { QuickFix: 'quickfix' },
  DocumentSymbol: record('name', 'detail', 'kind', 'range', 'selectionRange'),
  FoldingRange: record('start', 'end', 'kind'), FoldingRangeKind: { Comment: 1 },
  InlayHint: record('position', 'label', 'kind'), SemanticTokens: record('data'),
  SemanticTokensLegend: record('types', 'modifiers'),
  DebugAdapterExecutable: record('command', 'args'), Task: record('definition', 'scope', 'name', 'source', 'execution', 'matcher'),
  TaskScope: { Workspace: 2 }, TaskGroup: { Build: 'build' }, ProcessExecution: record('process', 'args'),
  workspace: {
    textDocuments: [], getConfiguration: () => ({ get: name => name === 'command' ? tool : 'mill' }),
    onDidOpenTextDocument: on('open'), onDidChangeTextDocument: on('change'), onDidCloseTextDocument: on('close'),
  },
  window: { activeTextEditor: null, showErrorMessage: words => problems.push(words) },
  commands: { registerCommand: (name, run) => { commands[name] = run; return { dispose() {} }; } },
  tasks: { registerTaskProvider: (type, provider) => { tasks = provider; return { dispose() {} }; } },
  debug: {
    registerDebugAdapterDescriptorFactory: (type, factory) => { adapter = factory; return { dispose() {} }; },
    registerDebugConfigurationProvider: (type, provider) => { configurations = provider; return { dispose() {} }; },
  },
};
const load = Module._load;
Module._load = (name, ...rest) => name === 'vscode' ? vscode : load(name, ...rest);

const document = (uri, text, version = 1) => ({
  uri: new Uri(uri), languageId: 'pasapas', version, getText: () => text,
});
const until = async (what, words) => {
  for (let n = 0; n < 500; n++) {
    if (what()) return;
    await new Promise(done => setTimeout(done, 20));
  }
  assert.fail(words);
};

async function main() {
  const extension = require(path.join(folder, 'extension.js'));
  const context = { extensionPath: folder, subscriptions: [] };
  await extension.activate(context);
  const uri = 'file:///work/a.bas';
  const script = document(uri, 'DIM n\nn == 1\nPRINT n\n');
  events.open(script);
  await until(() => shown.get(uri)?.length, 'no problems');
  assert.strictEqual(shown.get(uri)[0].code, 'L014');
  const start = new Position(1, 0);
  const [fix] = await providers.registerCodeActionsProvider.provideCodeActions(script, new Range(1, 0, 1, 4));
  assert.strictEqual(fix.title, 'Write `=`');
  assert.strictEqual(fix.edit.all[0][1][0].newText, '=');
  const mended = document(uri, 'DIM n\nn = 1\nPRINT n\n', 2);
  events.change({ document: mended });
  await until(() => shown.get(uri).length === 0, 'problems stay');
  const renamed = await providers.registerRenameProvider.provideRenameEdits(mended, start, 'hole');
  assert.strictEqual(renamed.all[0][1].length, 3);
  await assert.rejects(providers.registerRenameProvider.provideRenameEdits(mended, start, 'IF'), /can not be a name/);
  assert.match((await providers.registerHoverProvider.provideHover(mended, start)).contents.value, /DIM n/);
  const items = await providers.registerCompletionItemProvider.provideCompletionItems(mended, new Position(2, 6));
  assert(items.some(item => item.label === 'POSST'));
  assert.strictEqual((await providers.registerReferenceProvider.provideReferences(mended, start, { includeDeclaration: true })).length, 3);
  assert.strictEqual((await providers.registerDefinitionProvider.provideDefinition(mended, start)).range.start.character, 4);
  assert.strictEqual((await providers.registerDocumentHighlightProvider.provideDocumentHighlights(mended, start)).length, 3);
  assert.strictEqual((await providers.registerDocumentSymbolProvider.provideDocumentSymbols(mended))[0].name, 'n');
  const tokens = providers.registerDocumentSemanticTokensProvider;
  assert(tokens.more[0].types.includes('variable'));
  assert((await tokens.provideDocumentSemanticTokens(mended)).data.length > 0);
  const hints = await providers.registerInlayHintsProvider.provideInlayHints(mended, new Range(0, 0, 9, 0));
  assert.strictEqual(hints[0].label, 'AS NUMBER');
  assert.deepStrictEqual(await providers.registerFoldingRangeProvider.provideFoldingRanges(mended), []);
  assert.deepStrictEqual(await providers.registerDocumentFormattingEditProvider.provideDocumentFormattingEdits(mended, { tabSize: 2, insertSpaces: true }), []);
  assert.strictEqual((await providers.registerSignatureHelpProvider.provideSignatureHelp(mended, start)), null);
  // The debug adapter, tasks and F5 without a launch.json.
  assert.deepStrictEqual(adapter.createDebugAdapterDescriptor().args, ['dap', '--profile', 'mill']);
  vscode.window.activeTextEditor = { document: mended };
  assert.strictEqual(configurations.resolveDebugConfiguration(null, {}).request, 'launch');
  assert.deepStrictEqual(tasks.provideTasks()[0].execution.args, ['check', '--profile', 'mill', '${file}']);
  vscode.workspace.textDocuments.push(mended);
  await commands['pasapas.restart']();
  events.close(mended);
  await extension.deactivate();
  assert.deepStrictEqual(problems, []);
  console.log('all is well');
}
main().catch(error => { console.error(error); process.exit(1); });
