// Pasapas in Visual Studio Code: the language server, the debug adapter and tasks of `pasapas`.
'use strict';
const vscode = require('vscode');
const fs = require('fs');
const path = require('path');
const { Client } = require('./client.js');
const { register } = require('./providers.js');

const LANGUAGE = 'pasapas';
let server = null, problems = null, place = '';

// The command: the setting's, the one inside this extension, or the one on the path.
function command() {
  const own = vscode.workspace.getConfiguration('pasapas').get('command');
  if (own) return own;
  const inside = path.join(place, 'bin', process.platform === 'win32' ? 'pasapas.exe' : 'pasapas');
  return fs.existsSync(inside) ? inside : 'pasapas';
}
// Arguments that every command takes.
function options() {
  const profile = vscode.workspace.getConfiguration('pasapas').get('profile');
  return profile ? ['--profile', profile] : [];
}

async function start() {
  const client = new Client(command(), ['lsp', '--stdio', ...options()], heard, words => {
    vscode.window.showErrorMessage(`The Pasapas language server: ${words}. The setting pasapas.command names the tool.`);
  });
  server = client;
  const { capabilities } = await client.ask('initialize', { processId: process.pid, rootUri: null, capabilities: {} });
  client.tell('initialized', {});
  vscode.workspace.textDocuments.forEach(opened);
  return capabilities;
}
function heard(method, params) {
  if (method !== 'textDocument/publishDiagnostics') return;
  const range = r => new vscode.Range(r.start.line, r.start.character, r.end.line, r.end.character);
  const list = params.diagnostics.map(told => {
    const severity = { 1: 0, 2: 1, 3: 2, 4: 3 }[told.severity] ?? 0;
    const problem = new vscode.Diagnostic(range(told.range), told.message, severity);
    Object.assign(problem, { code: told.code, source: told.source });
    problem.relatedInformation = (told.relatedInformation ?? []).map(r =>
      new vscode.DiagnosticRelatedInformation(
        new vscode.Location(vscode.Uri.parse(r.location.uri), range(r.location.range)), r.message));
    return problem;
  });
  problems.set(vscode.Uri.parse(params.uri), list);
}
const named = document => ({ uri: document.uri.toString() });
function opened(document) {
  if (document.languageId !== LANGUAGE) return;
  server?.tell('textDocument/didOpen', {
    textDocument: { ...named(document), languageId: LANGUAGE, version: document.version, text: document.getText() },
  });
}
function changed({ document }) {
  if (document.languageId !== LANGUAGE) return;
  server?.tell('textDocument/didChange', {
    textDocument: { ...named(document), version: document.version },
    contentChanges: [{ text: document.getText() }],
  });
}
function closed(document) {
  if (document.languageId !== LANGUAGE) return;
  server?.tell('textDocument/didClose', { textDocument: named(document) });
}

// Tasks: what the command line does with a script.
function task(definition) {
  const file = definition.file ?? '${file}';
  const args = [definition.task, ...options(), file, ...(definition.arguments ?? [])];
  const made = new vscode.Task(definition, vscode.TaskScope.Workspace, definition.task, 'pasapas',
    new vscode.ProcessExecution(command(), args), '$pasapas');
  if (definition.task === 'check') made.group = vscode.TaskGroup.Build;
  return made;
}
const tasks = {
  provideTasks: () => ['check', 'build', 'sim', 'upload'].map(name => task({ type: LANGUAGE, task: name })),
  resolveTask: ({ definition }) => definition.task ? task(definition) : undefined,
};

const adapter = { createDebugAdapterDescriptor: () => new vscode.DebugAdapterExecutable(command(), ['dap', ...options()]) };
// F5 without a launch.json: simulate what the editor shows.
const configurations = {
  resolveDebugConfiguration(folder, config) {
    if (config.type || config.request) return config;
    if (vscode.window.activeTextEditor?.document.languageId !== LANGUAGE) return config;
    return { type: LANGUAGE, request: 'launch', name: 'Simulate', program: '${file}', stopOnEntry: true };
  },
};

async function activate(context) {
  place = context.extensionPath;
  problems = vscode.languages.createDiagnosticCollection(LANGUAGE);
  const keep = (...things) => context.subscriptions.push(...things);
  keep(problems,
    vscode.workspace.onDidOpenTextDocument(opened),
    vscode.workspace.onDidChangeTextDocument(changed),
    vscode.workspace.onDidCloseTextDocument(closed),
    vscode.tasks.registerTaskProvider(LANGUAGE, tasks),
    vscode.debug.registerDebugAdapterDescriptorFactory(LANGUAGE, adapter),
    vscode.debug.registerDebugConfigurationProvider(LANGUAGE, configurations),
    vscode.commands.registerCommand('pasapas.restart', async () => { await server?.close(); await start(); }),
    vscode.commands.registerCommand('pasapas.workbench', () => {
      const file = vscode.window.activeTextEditor?.document.fileName;
      if (!file) return;
      const terminal = vscode.window.createTerminal({ name: 'Pasapas', shellPath: command(), shellArgs: ['workbench', ...options(), file] });
      terminal.show();
    }));
  const capabilities = await start();
  const { tokenTypes, tokenModifiers } = capabilities.semanticTokensProvider.legend;
  const ask = (method, params) => server.ask(`textDocument/${method}`, params);
  keep(...register(vscode, LANGUAGE, ask, { types: tokenTypes, modifiers: tokenModifiers }));
}
const deactivate = () => server?.close();
module.exports = { activate, deactivate };
