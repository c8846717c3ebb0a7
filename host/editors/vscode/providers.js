// From Visual Studio Code's questions to those of the Language Server Protocol, and the answers back.
'use strict';

// Registers every provider; `ask(method, params)` asks the server, `legend` names its tokens.
function register(vscode, language, ask, legend) {
  const at = (document, position) => ({ ...of(document), position: { line: position.line, character: position.character } });
  const of = document => ({ textDocument: { uri: document.uri.toString() } });
  const range = r => new vscode.Range(r.start.line, r.start.character, r.end.line, r.end.character);
  const plain = r => ({ start: { line: r.start.line, character: r.start.character }, end: { line: r.end.line, character: r.end.character } });
  const location = l => new vscode.Location(vscode.Uri.parse(l.uri), range(l.range));
  const edits = list => (list ?? []).map(e => new vscode.TextEdit(range(e.range), e.newText));
  const workspaceEdit = edit => {
    const made = new vscode.WorkspaceEdit();
    for (const [uri, list] of Object.entries(edit?.changes ?? {})) made.set(vscode.Uri.parse(uri), edits(list));
    return made;
  };
  const words = text => new vscode.MarkdownString(text);
  const l = vscode.languages;
  // The protocol counts kinds of completions and symbols from 1, the editor from 0.
  const symbol = s => {
    const made = new vscode.DocumentSymbol(s.name, s.detail ?? '', s.kind - 1, range(s.range), range(s.selectionRange));
    made.children = (s.children ?? []).map(symbol);
    return made;
  };
  return [
    l.registerCompletionItemProvider(language, {
      async provideCompletionItems(document, position) {
        const items = await ask('completion', at(document, position));
        return (items ?? []).map(item => Object.assign(new vscode.CompletionItem(item.label, item.kind - 1),
          { detail: item.detail, documentation: item.documentation }));
      },
    }),
    l.registerHoverProvider(language, {
      async provideHover(document, position) {
        const found = await ask('hover', at(document, position));
        return found && new vscode.Hover(words(found.contents.value), found.range && range(found.range));
      },
    }),
    l.registerSignatureHelpProvider(language, {
      async provideSignatureHelp(document, position) {
        const found = await ask('signatureHelp', at(document, position));
        if (!found) return null;
        const help = new vscode.SignatureHelp();
        help.signatures = found.signatures.map(s => {
          const made = new vscode.SignatureInformation(s.label, s.documentation);
          made.parameters = (s.parameters ?? []).map(p => new vscode.ParameterInformation(p.label));
          return made;
        });
        help.activeSignature = found.activeSignature ?? 0;
        help.activeParameter = found.activeParameter ?? 0;
        return help;
      },
    }, '(', ',', ' '),
    l.registerDefinitionProvider(language, {
      async provideDefinition(document, position) {
        const found = await ask('definition', at(document, position));
        return found && location(found);
      },
    }),
    l.registerReferenceProvider(language, {
      async provideReferences(document, position, context) {
        const found = await ask('references', { ...at(document, position), context: { includeDeclaration: context.includeDeclaration } });
        return (found ?? []).map(location);
      },
    }),
    l.registerDocumentHighlightProvider(language, {
      async provideDocumentHighlights(document, position) {
        const found = await ask('documentHighlight', at(document, position));
        return (found ?? []).map(h => new vscode.DocumentHighlight(range(h.range), h.kind - 1));
      },
    }),
    l.registerRenameProvider(language, {
      async prepareRename(document, position) {
        const found = await ask('prepareRename', at(document, position));
        if (!found) throw new Error('Nothing here has a name of the script\'s own.');
        return { range: range(found.range), placeholder: found.placeholder };
      },
      async provideRenameEdits(document, position, newName) {
        return workspaceEdit(await ask('rename', { ...at(document, position), newName }));
      },
    }),
    l.registerCodeActionsProvider(language, {
      async provideCodeActions(document, selected) {
        const found = await ask('codeAction', { ...of(document), range: plain(selected), context: { diagnostics: [] } });
        return (found ?? []).map(told => {
          const action = new vscode.CodeAction(told.title, vscode.CodeActionKind.QuickFix);
          return Object.assign(action, { edit: workspaceEdit(told.edit), isPreferred: told.isPreferred });
        });
      },
    }),
    l.registerDocumentSymbolProvider(language, {
      async provideDocumentSymbols(document) { return ((await ask('documentSymbol', of(document))) ?? []).map(symbol); },
    }),
    l.registerDocumentFormattingEditProvider(language, {
      async provideDocumentFormattingEdits(document, options) {
        return edits(await ask('formatting', { ...of(document), options: { tabSize: options.tabSize, insertSpaces: options.insertSpaces } }));
      },
    }),
    l.registerFoldingRangeProvider(language, {
      async provideFoldingRanges(document) {
        const kind = { comment: vscode.FoldingRangeKind.Comment };
        return ((await ask('foldingRange', of(document))) ?? []).map(f => new vscode.FoldingRange(f.startLine, f.endLine, kind[f.kind]));
      },
    }),
    l.registerInlayHintsProvider(language, {
      async provideInlayHints(document, seen) {
        const found = await ask('inlayHint', { ...of(document), range: plain(seen) });
        return (found ?? []).map(h => Object.assign(
          new vscode.InlayHint(new vscode.Position(h.position.line, h.position.character), h.label, h.kind), { paddingLeft: h.paddingLeft }));
      },
    }),
    l.registerDocumentSemanticTokensProvider(language, {
      async provideDocumentSemanticTokens(document) {
        const found = await ask('semanticTokens/full', of(document));
        return new vscode.SemanticTokens(new Uint32Array(found?.data ?? []));
      },
    }, new vscode.SemanticTokensLegend(legend.types, legend.modifiers)),
  ];
}
module.exports = { register };
