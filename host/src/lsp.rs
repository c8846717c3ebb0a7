//! The language server: diagnostics, completion, hover, symbols, definitions and formatting for
//! editors, over the Language Server Protocol 3.17 on standard input and output.

mod assist;
mod document;
mod symbols;

use std::collections::HashMap;

use lang::profile::Profile;
use lsp_server::{Connection, ErrorCode, Message, Notification, Request, Response};
use lsp_types::notification::{
    DidChangeTextDocument, DidCloseTextDocument, DidOpenTextDocument, Notification as _,
    PublishDiagnostics,
};
use lsp_types::request::{
    Completion, DocumentSymbolRequest, Formatting, GotoDefinition, HoverRequest, Request as _,
};
use lsp_types::{
    CompletionOptions, CompletionResponse, Diagnostic, DocumentSymbolResponse,
    GotoDefinitionResponse, HoverProviderCapability, Location, OneOf, PublishDiagnosticsParams,
    ServerCapabilities, TextDocumentPositionParams, TextDocumentSyncCapability,
    TextDocumentSyncKind, Uri,
};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

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
    let capabilities = serde_json::to_value(capabilities()).map_err(broken)?;
    connection.initialize(capabilities).map_err(broken)?;
    let mut server = Server { documents: HashMap::new(), profile };
    for message in &connection.receiver {
        let answer = match message {
            Message::Request(request) => {
                if connection.handle_shutdown(&request).map_err(broken)? {
                    return Ok(());
                }
                Some(Message::Response(server.answer(request)))
            }
            Message::Notification(notification) => {
                server.take_note(notification).map(Message::Notification)
            }
            Message::Response(_) => None,
        };
        if let Some(answer) = answer {
            connection.sender.send(answer).map_err(broken)?;
        }
    }
    Ok(())
}

fn capabilities() -> ServerCapabilities {
    ServerCapabilities {
        text_document_sync: Some(TextDocumentSyncCapability::Kind(TextDocumentSyncKind::FULL)),
        completion_provider: Some(CompletionOptions::default()),
        hover_provider: Some(HoverProviderCapability::Simple(true)),
        document_symbol_provider: Some(OneOf::Left(true)),
        document_formatting_provider: Some(OneOf::Left(true)),
        definition_provider: Some(OneOf::Left(true)),
        ..ServerCapabilities::default()
    }
}

/// The open documents.
struct Server<'a> {
    documents: HashMap<String, Document>,
    profile: Option<&'a Profile>,
}

impl Server<'_> {
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
        let name = key.rsplit('/').next().unwrap_or(key);
        let document = Document::new(name, text);
        let shown = document.diagnostics(uri, self.profile);
        self.documents.insert(key.to_owned(), document);
        Some(shown)
    }

    fn answer(&self, request: Request) -> Response {
        let Request { id, method, params } = request;
        let result = match method.as_str() {
            Completion::METHOD => self.at(params, |p: lsp_types::CompletionParams| {
                let TextDocumentPositionParams { text_document, position } =
                    p.text_document_position;
                let document = self.documents.get(text_document.uri.as_str())?;
                Some(CompletionResponse::Array(assist::complete(document, position)))
            }),
            HoverRequest::METHOD => self.at(params, |p: lsp_types::HoverParams| {
                let place = p.text_document_position_params;
                let document = self.documents.get(place.text_document.uri.as_str())?;
                assist::hover(document, place.position)
            }),
            GotoDefinition::METHOD => self.at(params, |p: lsp_types::GotoDefinitionParams| {
                let place = p.text_document_position_params;
                let uri = place.text_document.uri;
                let document = self.documents.get(uri.as_str())?;
                let range = assist::definition(document, place.position)?;
                Some(GotoDefinitionResponse::Scalar(Location { uri, range }))
            }),
            DocumentSymbolRequest::METHOD => {
                self.at(params, |p: lsp_types::DocumentSymbolParams| {
                    let document = self.documents.get(p.text_document.uri.as_str())?;
                    Some(DocumentSymbolResponse::Nested(symbols::outline(document)))
                })
            }
            Formatting::METHOD => self.at(params, |p: lsp_types::DocumentFormattingParams| {
                let document = self.documents.get(p.text_document.uri.as_str())?;
                document.formatted()
            }),
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

fn parsed<P: DeserializeOwned>(params: Value) -> Option<P> {
    serde_json::from_value(params).ok()
}

#[cfg(test)]
mod tests;
