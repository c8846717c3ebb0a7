//! The language server: diagnostics with quick fixes, completion, hover, signatures, everything about
//! names, colours, folds, hints of kinds and formatting for editors, over the Language Server
//! Protocol 3.17 on standard input and output.

mod about;
mod complete;
mod diagnostics;
mod document;
mod look;
mod names;
pub(crate) mod path;
mod signature;
#[cfg(feature = "desktop")]
pub mod stdio;

use std::collections::HashMap;

use lang::front::fmt;
use lang::front::span::Span;
use lang::profile::Profile;
use lsp_server::{Connection, ErrorCode, Message, Notification, Request, Response};
use lsp_types::notification::{
    DidChangeTextDocument, DidCloseTextDocument, DidOpenTextDocument, Exit, Notification as _,
    PublishDiagnostics,
};
use lsp_types::request::{self, Request as _};
use lsp_types::{
    CodeActionKind, CodeActionOptions, CodeActionProviderCapability, CompletionOptions,
    CompletionResponse, Diagnostic, DocumentSymbolResponse, FoldingRangeProviderCapability,
    GotoDefinitionResponse, HoverProviderCapability, OneOf, PublishDiagnosticsParams,
    RenameOptions, SemanticTokens, SemanticTokensFullOptions, SemanticTokensOptions,
    ServerCapabilities, SignatureHelpOptions, TextDocumentIdentifier, TextDocumentPositionParams,
    TextDocumentSyncCapability, TextDocumentSyncKind, TextEdit, Uri, WorkDoneProgressOptions,
};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

pub use about::quantity;
use document::Document;

/// Open documents beyond this number are refused; an editor opens some tens.
const MAX_DOCUMENTS: usize = 1000;

/// Why the server ended before the editor asked it to.
#[derive(Debug)]
pub struct Broken(String);

impl std::fmt::Display for Broken {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "the connection to the editor broke: {}", self.0)
    }
}

impl std::error::Error for Broken {}

fn broken(error: impl std::fmt::Display) -> Broken {
    Broken(error.to_string())
}

/// Serves one editor until it says good-bye. `profile` is the machine for scripts that name none.
///
/// # Errors
/// The connection breaks.
pub fn serve(connection: &Connection, profile: Option<&Profile>) -> Result<(), Broken> {
    connection.initialize(capabilities()).map_err(broken)?;
    let mut server = Server::new(profile);
    for message in &connection.receiver {
        if let Message::Request(request) = &message
            && request.method == request::Shutdown::METHOD
        {
            return shut_down(connection, request);
        }
        if let Some(answer) = server.hear(message) {
            connection.sender.send(answer).map_err(broken)?;
        }
    }
    Ok(())
}

/// Answers `shutdown` and waits for `exit`. What an editor still sends between them is refused or not heard; one that is gone
/// without `exit` has said good-bye all the same.
fn shut_down(connection: &Connection, request: &Request) -> Result<(), Broken> {
    let answer = |response: Response| connection.sender.send(response.into()).map_err(broken);
    answer(Response::new_ok(request.id.clone(), ()))?;
    for message in &connection.receiver {
        match message {
            Message::Notification(note) if note.method == Exit::METHOD => break,
            Message::Request(late) => {
                let words = "the server was asked to shut down".to_owned();
                answer(Response::new_err(late.id, ErrorCode::InvalidRequest as i32, words))?;
            }
            _ => {}
        }
    }
    Ok(())
}

/// What the server can do, as the protocol tells it.
pub fn capabilities() -> Value {
    // Nothing in it has no JSON form.
    serde_json::to_value(all_capabilities()).unwrap_or_default()
}

fn all_capabilities() -> ServerCapabilities {
    let strings = |signs: &[&str]| Some(signs.iter().map(|&sign| sign.to_owned()).collect());
    ServerCapabilities {
        text_document_sync: Some(TextDocumentSyncCapability::Kind(TextDocumentSyncKind::FULL)),
        completion_provider: Some(CompletionOptions::default()),
        hover_provider: Some(HoverProviderCapability::Simple(true)),
        signature_help_provider: Some(SignatureHelpOptions {
            trigger_characters: strings(&["(", ",", " "]),
            ..SignatureHelpOptions::default()
        }),
        document_symbol_provider: Some(OneOf::Left(true)),
        document_formatting_provider: Some(OneOf::Left(true)),
        definition_provider: Some(OneOf::Left(true)),
        references_provider: Some(OneOf::Left(true)),
        document_highlight_provider: Some(OneOf::Left(true)),
        rename_provider: Some(OneOf::Right(RenameOptions {
            prepare_provider: Some(true),
            work_done_progress_options: WorkDoneProgressOptions::default(),
        })),
        code_action_provider: Some(CodeActionProviderCapability::Options(CodeActionOptions {
            code_action_kinds: Some(vec![CodeActionKind::QUICKFIX]),
            ..CodeActionOptions::default()
        })),
        semantic_tokens_provider: Some(
            SemanticTokensOptions {
                legend: look::legend(),
                full: Some(SemanticTokensFullOptions::Bool(true)),
                ..SemanticTokensOptions::default()
            }
            .into(),
        ),
        folding_range_provider: Some(FoldingRangeProviderCapability::Simple(true)),
        inlay_hint_provider: Some(OneOf::Left(true)),
        ..ServerCapabilities::default()
    }
}

/// A server behind any connection, or none: what an editor says goes in, what it is to hear comes out.
pub struct Server<'a> {
    /// The open documents.
    documents: HashMap<String, Document>,
    profile: Option<&'a Profile>,
}

impl<'a> Server<'a> {
    /// One without documents. `profile` is the machine for scripts that name none.
    pub fn new(profile: Option<&'a Profile>) -> Server<'a> {
        Server { documents: HashMap::new(), profile }
    }

    /// Takes a message behind the handshake and gives the answer to it, or the diagnostics to be shown.
    pub fn hear(&mut self, message: Message) -> Option<Message> {
        match message {
            Message::Request(request) => Some(Message::Response(self.answer(request))),
            Message::Notification(note) => self.take_note(note).map(Message::Notification),
            Message::Response(_) => None,
        }
    }

    /// Takes what the editor says about its documents; gives the diagnostics to be shown.
    fn take_note(&mut self, notification: Notification) -> Option<Notification> {
        let params = notification.params;
        let (uri, version, diagnostics) = match notification.method.as_str() {
            DidOpenTextDocument::METHOD => {
                let params: lsp_types::DidOpenTextDocumentParams = parsed(params)?;
                let document = params.text_document;
                let shown = self.open(&document.uri, document.text)?;
                (document.uri, Some(document.version), shown)
            }
            DidChangeTextDocument::METHOD => {
                let params: lsp_types::DidChangeTextDocumentParams = parsed(params)?;
                // With full synchronisation the last change holds the whole text.
                let text = params.content_changes.into_iter().next_back()?.text;
                let shown = self.open(&params.text_document.uri, text)?;
                (params.text_document.uri, Some(params.text_document.version), shown)
            }
            DidCloseTextDocument::METHOD => {
                let params: lsp_types::DidCloseTextDocumentParams = parsed(params)?;
                self.documents.remove(params.text_document.uri.as_str());
                (params.text_document.uri, None, Vec::new())
            }
            _ => return None,
        };
        let shown = PublishDiagnosticsParams { uri, diagnostics, version };
        Some(Notification::new(PublishDiagnostics::METHOD.to_owned(), shown))
    }

    fn open(&mut self, uri: &Uri, text: String) -> Option<Vec<Diagnostic>> {
        let key = uri.as_str();
        if self.documents.len() >= MAX_DOCUMENTS && !self.documents.contains_key(key) {
            return None;
        }
        let document = Document::new(uri, text, self.profile);
        let shown = diagnostics::all(&document);
        self.documents.insert(key.to_owned(), document);
        Some(shown)
    }

    fn answer(&self, request: Request) -> Response {
        let Request { id, method, params } = request;
        let result = match method.as_str() {
            request::Completion::METHOD => self.at(params, |p: lsp_types::CompletionParams| {
                let (document, at) = self.place(&p.text_document_position)?;
                Some(CompletionResponse::Array(complete::complete(document, at)))
            }),
            request::HoverRequest::METHOD => self.at(params, |p: lsp_types::HoverParams| {
                let (document, at) = self.place(&p.text_document_position_params)?;
                about::hover(document, at)
            }),
            request::SignatureHelpRequest::METHOD => {
                self.at(params, |p: lsp_types::SignatureHelpParams| {
                    let (document, at) = self.place(&p.text_document_position_params)?;
                    signature::help(document, at)
                })
            }
            request::GotoDefinition::METHOD => {
                self.at(params, |p: lsp_types::GotoDefinitionParams| {
                    let (document, at) = self.place(&p.text_document_position_params)?;
                    names::definition(document, at).map(GotoDefinitionResponse::Scalar)
                })
            }
            request::References::METHOD => self.at(params, |p: lsp_types::ReferenceParams| {
                let (document, at) = self.place(&p.text_document_position)?;
                names::references(document, at, p.context.include_declaration)
            }),
            request::DocumentHighlightRequest::METHOD => {
                self.at(params, |p: lsp_types::DocumentHighlightParams| {
                    let (document, at) = self.place(&p.text_document_position_params)?;
                    names::highlight(document, at)
                })
            }
            request::PrepareRenameRequest::METHOD => {
                self.at(params, |p: TextDocumentPositionParams| {
                    let (document, at) = self.place(&p)?;
                    names::prepare_rename(document, at)
                })
            }
            request::Rename::METHOD => {
                let renamed = parsed(params).and_then(|p: lsp_types::RenameParams| {
                    let (document, at) = self.place(&p.text_document_position)?;
                    Some(names::rename(document, at, &p.new_name))
                });
                match renamed {
                    Some(Ok(edit)) => serde_json::to_value(edit).map_err(|e| e.to_string()),
                    Some(Err(words)) => Err(words),
                    None => Err("there is nothing to rename".to_owned()),
                }
            }
            request::CodeActionRequest::METHOD => {
                self.at(params, |p: lsp_types::CodeActionParams| {
                    Some(diagnostics::fixes(self.document(&p.text_document)?, p.range))
                })
            }
            request::SemanticTokensFullRequest::METHOD => {
                self.at(params, |p: lsp_types::SemanticTokensParams| {
                    let data = look::tokens(self.document(&p.text_document)?);
                    Some(SemanticTokens { result_id: None, data })
                })
            }
            request::FoldingRangeRequest::METHOD => {
                self.at(params, |p: lsp_types::FoldingRangeParams| {
                    Some(look::folds(self.document(&p.text_document)?))
                })
            }
            request::InlayHintRequest::METHOD => {
                self.at(params, |p: lsp_types::InlayHintParams| {
                    Some(look::hints(self.document(&p.text_document)?, p.range))
                })
            }
            request::DocumentSymbolRequest::METHOD => {
                self.at(params, |p: lsp_types::DocumentSymbolParams| {
                    let document = self.document(&p.text_document)?;
                    Some(DocumentSymbolResponse::Nested(names::outline(document)))
                })
            }
            request::Formatting::METHOD => {
                self.at(params, |p: lsp_types::DocumentFormattingParams| {
                    formatted(self.document(&p.text_document)?)
                })
            }
            _ => {
                let message = format!("{method} is not served");
                return Response::new_err(id, ErrorCode::MethodNotFound as i32, message);
            }
        };
        match result {
            Ok(value) => Response::new_ok(id, value),
            Err(message) => Response::new_err(id, ErrorCode::InvalidParams as i32, message),
        }
    }

    fn document(&self, named: &TextDocumentIdentifier) -> Option<&Document> {
        self.documents.get(named.uri.as_str())
    }

    fn place(
        &self,
        place: &TextDocumentPositionParams,
    ) -> Option<(&Document, lsp_types::Position)> {
        Some((self.document(&place.text_document)?, place.position))
    }

    /// Runs a request; without an answer the result is null, as the protocol wants it.
    fn at<P: DeserializeOwned, R: Serialize>(
        &self,
        params: Value,
        run: impl FnOnce(P) -> Option<R>,
    ) -> Result<Value, String> {
        let params = serde_json::from_value(params).map_err(|error| error.to_string())?;
        serde_json::to_value(run(params)).map_err(|error| error.to_string())
    }
}

/// The edit that formats a document; none where nothing changes or where it does not parse.
fn formatted(document: &Document) -> Option<Vec<TextEdit>> {
    if document.imported().is_some() {
        return None;
    }
    let text = document.source().text();
    let new_text = fmt::format(text).ok()?;
    if new_text == text {
        return Some(Vec::new());
    }
    let range = document.range(Span::new(0, text.len() as u32));
    Some(vec![TextEdit { range, new_text }])
}

fn parsed<P: DeserializeOwned>(params: Value) -> Option<P> {
    serde_json::from_value(params).ok()
}

#[cfg(test)]
mod tests;
