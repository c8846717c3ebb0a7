//! Signature help: the call around a position.

use lang::front::index::Sort;
use lang::front::span::Span;
use lang::front::token::{Sign, Tok, Token};
use lang::front::words::{Class, Func, Kw};
use lsp_types::{
    Documentation, ParameterInformation, ParameterLabel, Position, SignatureHelp,
    SignatureInformation,
};

use super::about;
use super::document::Document;

/// What is called.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Callee {
    /// A statement of the machine.
    Statement(Kw),
    /// A built-in function.
    Builtin(Func),
    /// A SUB or FUNCTION: index of the symbol.
    Routine(usize),
}

/// A call that is being written.
#[derive(Clone, Copy, Debug)]
pub struct Call {
    /// What is called.
    pub callee: Callee,
    /// Which argument stands at the place, from 0.
    pub argument: usize,
}

impl Call {
    /// The innermost call whose arguments an offset stands among.
    pub fn around(document: &Document, offset: u32) -> Option<Call> {
        let tokens = document.tokens();
        // The end of a text without a last line end is a token without letters: it lies behind.
        let before = |token: &Token| token.span.start < offset && token.span.end <= offset;
        let until = tokens.partition_point(before);
        let ends = |token: &Token| {
            matches!(token.tok, Tok::LineEnd | Tok::Label | Tok::Sign(Sign::Colon))
                || matches!(token.tok, Tok::Kw(Kw::Then | Kw::Else))
        };
        let from = tokens[..until].iter().rposition(ends).map_or(0, |n| n + 1);
        let statement: Vec<Token> =
            tokens[from..until].iter().filter(|t| !t.tok.is_trivia()).copied().collect();
        let mut open: Vec<Option<Call>> = Vec::new();
        let mut start = 0;
        if let Some(first) = statement.first() {
            let call = |callee| Some(Call { callee, argument: 0 });
            let own = match first.tok {
                Tok::Kw(Kw::Start | Kw::Call) => {
                    start = 1;
                    statement.get(1).and_then(|token| callee(document, *token))
                }
                _ => callee(document, *first),
            };
            // What stands directly behind a name is not an argument yet.
            let own = own.filter(|_| statement.len() > start && behind(&statement[start], offset));
            open.push(own.and_then(|own| match own {
                Callee::Builtin(_) => None,
                own => call(own),
            }));
        }
        for (n, token) in statement.iter().enumerate().skip(start) {
            match token.tok {
                Tok::Sign(Sign::Open) => {
                    let name = n.checked_sub(1).map(|before| statement[before]);
                    let own = name.and_then(|name| callee(document, name));
                    // `go(1, 2)`: the parentheses of a call without CALL are its own.
                    open.push(own.map(|callee| Call { callee, argument: 0 }));
                }
                Tok::Sign(Sign::Close) => {
                    open.pop();
                }
                Tok::Sign(Sign::Comma) => {
                    if let Some(Some(call)) = open.last_mut() {
                        call.argument += 1;
                    }
                }
                _ => {}
            }
        }
        open.into_iter().rev().flatten().next()
    }
}

/// Whether an offset lies behind a token and a blank.
fn behind(token: &Token, offset: u32) -> bool {
    offset > token.span.end
}

fn callee(document: &Document, token: Token) -> Option<Callee> {
    match token.tok {
        Tok::Kw(kw) | Tok::Quiet(kw) if kw.entry().class == Class::Machine => {
            Some(Callee::Statement(kw))
        }
        Tok::Func(func) => Some(Callee::Builtin(func)),
        Tok::Name | Tok::Kw(_) => {
            let key = token.span.of(document.source().text()).to_ascii_lowercase();
            let Some(symbol) = document.index().look(None, &key) else {
                return Func::soft(&key).map(Callee::Builtin);
            };
            let sort = document.index().symbols()[symbol].sort;
            matches!(sort, Sort::Sub | Sort::Function).then_some(Callee::Routine(symbol))
        }
        _ => None,
    }
}

/// The form of the call at a place, with the argument that stands there.
pub fn help(document: &Document, position: Position) -> Option<SignatureHelp> {
    let offset = document.offset(position);
    let call = Call::around(document, offset)?;
    let (label, about) = match call.callee {
        Callee::Statement(kw) => (kw.entry().usage.to_owned(), kw.entry().about.to_owned()),
        Callee::Builtin(func) => (func.usage().to_owned(), func.about().to_owned()),
        Callee::Routine(symbol) => (head(document, symbol), String::new()),
    };
    let parameters = parameters(&label);
    let last = parameters.len().checked_sub(1)?;
    let information = |span: Span| ParameterInformation {
        label: ParameterLabel::LabelOffsets([span.start, span.end]),
        documentation: None,
    };
    let repeats = label.ends_with("...]") || label.ends_with("...");
    let active = if repeats { call.argument.min(last) } else { call.argument };
    Some(SignatureHelp {
        signatures: vec![SignatureInformation {
            label,
            documentation: (!about.is_empty()).then_some(Documentation::String(about)),
            parameters: Some(parameters.into_iter().map(information).collect()),
            active_parameter: Some(active as u32),
        }],
        active_signature: Some(0),
        active_parameter: Some(active as u32),
    })
}

/// `SUB go(a AS LENGTH, b AS NUMBER)`, kinds that were found out included.
fn head(document: &Document, symbol: usize) -> String {
    let symbol = &document.index().symbols()[symbol];
    let routines = &document.analysis().script.routines;
    let Some(routine) = routines.iter().find(|r| r.name.span == symbol.name.span) else {
        return about::declaration(document, symbol);
    };
    let kind = |at: u32| {
        let fact = document.analysis().facts.get(&at);
        fact.and_then(|fact| fact.kinds.first())
            .map_or("NUMBER".to_owned(), |k| k.name().to_uppercase())
    };
    let params: Vec<String> = routine
        .params
        .iter()
        .map(|param| format!("{} AS {}", param.name.text, kind(param.name.span.start)))
        .collect();
    let (word, result) = match routine.is_function {
        true => ("FUNCTION", format!(" AS {}", kind(routine.name.span.start))),
        false => ("SUB", String::new()),
    };
    format!("{word} {}({}){result}", routine.name.text, params.join(", "))
}

/// Places of the parameters in a form such as `MoveAxe axis, target [, speed]` or `go(a AS LENGTH)`.
/// The forms are ASCII: bytes are UTF-16 units.
fn parameters(form: &str) -> Vec<Span> {
    let opens = form.find('(').filter(|at| !form[..*at].trim_end().ends_with(','));
    let begin = opens.map(|at| at + 1).or_else(|| form.find(' ').map(|at| at + 1));
    let Some(begin) = begin else { return Vec::new() };
    let end = match opens {
        Some(_) => form.rfind(')').unwrap_or(form.len()),
        None => form.len(),
    };
    let mut at = begin;
    let mut found = Vec::new();
    for part in form.get(begin..end).unwrap_or("").split([',', ';']) {
        let own = part.trim_matches(|c: char| c.is_whitespace() || c == '[' || c == ']');
        if !own.is_empty() && own != "..." {
            let lead = part.find(own).unwrap_or(0);
            found.push(Span::new((at + lead) as u32, (at + lead + own.len()) as u32));
        }
        at += part.len() + 1;
    }
    found
}

#[cfg(test)]
mod tests {
    use super::parameters;
    use lang::front::words::{Class, Func, Kw};

    fn words(form: &str) -> Vec<&str> {
        parameters(form).into_iter().map(|span| span.of(form)).collect()
    }

    #[test]
    fn forms_fall_into_parameters() {
        let form = Kw::MoveAxe.entry().usage;
        assert_eq!(words(form), ["axis", "target", "speed", "accel", "decel"]);
        assert_eq!(words(Func::Steps.usage()), ["axis", "length"]);
        assert_eq!(words("SUB go(a AS LENGTH, b AS NUMBER)"), ["a AS LENGTH", "b AS NUMBER"]);
        assert_eq!(words(Kw::Home.entry().usage), ["axis"]);
        for func in Func::ALL {
            assert_eq!(words(func.usage()).len(), func.args().len(), "{}", func.usage());
        }
        for kw in Kw::ALL.iter().filter(|kw| kw.entry().class == Class::Machine) {
            for span in parameters(kw.entry().usage) {
                assert!(!span.of(kw.entry().usage).is_empty());
            }
        }
    }
}
