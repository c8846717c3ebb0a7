//! From text to tokens. Two logos lexers take turns: one for BASIC, one for G-code blocks; which
//! one reads is decided at the start of each statement.

mod begins;
mod gcode;
mod own;
mod slips;

pub use self::begins::begins_gcode;
use super::codes::Code;
use super::diag::{Diag, Diags};
use super::literal;
use super::span::Span;
use super::token::{Basic, Foreign, Sign, Tok, Token};
use super::words::{self, Func, Kw, Reserved};
use logos::{Lexer, Logos};

/// Splits a text into tokens, comments included. The last one is always a [`Tok::LineEnd`]. A text
/// that is hopelessly wrong is not read to its end.
pub fn lex(text: &str, diags: &mut Diags) -> Vec<Token> {
    let mut state = State {
        text,
        tokens: Vec::with_capacity(text.len() / 4 + 1),
        diags,
        line: 1,
        line_start: true,
        statement_start: true,
        brackets: 0,
        gcode: false,
        block_reported: false,
    };
    let mut at = 0;
    while at < text.len() && !state.diags.hopeless() {
        at = if state.gcode && state.brackets == 0 { state.gcode(at) } else { state.basic(at) };
    }
    if state.tokens.last().is_none_or(|t| t.tok != Tok::LineEnd) {
        state.push(Tok::LineEnd, Span::point(text.len() as u32));
    }
    own::take_names(text, state.tokens)
}

struct State<'a> {
    text: &'a str,
    tokens: Vec<Token>,
    diags: &'a mut Diags,
    line: u32,
    /// No token of this line yet.
    line_start: bool,
    /// A statement may begin here.
    statement_start: bool,
    /// Open brackets inside a G-code block; its expressions are BASIC.
    brackets: u32,
    /// Inside a G-code block.
    gcode: bool,
    /// Its first wrong word was reported; what follows is often a consequence.
    block_reported: bool,
}

impl<'a> State<'a> {
    fn push(&mut self, tok: Tok, span: Span) {
        self.tokens.push(Token { tok, span, line: self.line });
        match tok {
            Tok::LineEnd => {
                self.line += 1;
                self.line_start = true;
                self.statement_start = true;
                self.gcode = false;
                self.brackets = 0;
            }
            Tok::Continuation => self.line += 1,
            Tok::Comment => {}
            Tok::Label | Tok::Sign(Sign::Colon) | Tok::Kw(Kw::Then | Kw::Else) => {
                self.line_start = false;
                self.statement_start = true;
                self.gcode = false;
                self.brackets = 0;
            }
            _ => {
                self.line_start = false;
                self.statement_start = false;
            }
        }
    }

    fn report(&mut self, code: Code, span: Span, message: impl Into<String>, hint: &str) {
        self.diags.push(Diag::new(code, span, message).hint(hint));
    }

    /// The same with what is to stand there instead.
    fn report_fix(
        &mut self,
        code: Code,
        span: Span,
        message: impl Into<String>,
        hint: &str,
        instead: impl Into<String>,
    ) {
        self.diags.push(Diag::new(code, span, message).hint(hint).fix(span, instead));
    }

    /// A word in the place of a sign: blanks part it from what stands directly beside it.
    fn parted(&self, word: &str, span: Span) -> String {
        let part = |c: Option<char>| match c {
            Some(c) if !c.is_whitespace() => " ",
            _ => "",
        };
        let (before, behind) =
            (self.text.get(..span.start as usize), self.text.get(span.end as usize..));
        let before = part(before.and_then(|text| text.chars().next_back()));
        let behind = part(behind.and_then(|text| text.chars().next()));
        format!("{before}{word}{behind}")
    }

    /// Reads on from `at` with the BASIC lexer until a G-code block begins or goes on; gives the
    /// offset where reading goes on.
    fn basic(&mut self, at: usize) -> usize {
        let text = self.text;
        let mut lexer = Basic::lexer(text.get(at..).unwrap_or(""));
        loop {
            let rest = lexer.remainder();
            let next = text.len() - rest.len();
            if self.statement_start && begins_gcode(rest) {
                self.gcode = true;
                self.block_reported = false;
                self.statement_start = false;
                return next;
            }
            if self.diags.hopeless() {
                return next;
            }
            let Some(piece) = lexer.next() else { return text.len() };
            let range = lexer.span();
            let span = Span::new((at + range.start) as u32, (at + range.end) as u32);
            match piece {
                Ok(Basic::Word) => self.word(&mut lexer, at, span),
                Ok(Basic::Number) => self.number(&mut lexer, span),
                Ok(Basic::Text) => self.push(Tok::Text, span),
                Ok(Basic::UnclosedText) if self.digit_before(span) => {
                    let sign = Span::new(span.start, span.start + 1);
                    let message = "`\"` is no unit";
                    self.report_fix(Code::BadUnit, sign, message, slips::INCHES, "in");
                    self.push(Tok::Bad, span);
                }
                Ok(Basic::UnclosedText) => {
                    let message = "the text has no closing `\"`";
                    self.report(Code::UnclosedText, span, message, "a text ends on its line");
                    self.push(Tok::Bad, span);
                }
                Ok(Basic::Comment) => self.push(Tok::Comment, span),
                Ok(Basic::LineEnd) => self.push(Tok::LineEnd, span),
                Ok(Basic::Continuation) if self.blank_before(span) => {
                    self.push(Tok::Continuation, span);
                }
                Ok(Basic::Continuation) => {
                    let underscore = Span::new(span.start, span.start + 1);
                    self.stray_underscore(underscore);
                    lexer = Basic::lexer(text.get(underscore.end as usize..).unwrap_or(""));
                    return self.resume(lexer);
                }
                Ok(Basic::Question) => {
                    let hint = "printing is `PRINT`; `?` belongs to Probe? ProbeMask? Home? WaitIn? WaitChar?";
                    if self.statement_start {
                        let print = self.parted("PRINT", span);
                        self.report_fix(Code::LoneQuestion, span, "`?` stands alone", hint, print);
                    } else {
                        self.report(Code::LoneQuestion, span, "`?` stands alone", hint);
                    }
                    self.push(Tok::Bad, span);
                }
                Ok(Basic::Sign(sign)) => {
                    self.push(Tok::Sign(sign), span);
                    if self.gcode && self.track_brackets(sign) {
                        return span.end as usize;
                    }
                }
                Ok(Basic::Foreign(foreign)) => self.foreign(foreign, span, lexer.remainder()),
                Ok(Basic::ForeignComment) => {
                    let hint = "write `'` for a comment";
                    let sign = Span::new(span.start, span.start + 2);
                    let diag = Diag::new(Code::ForeignComment, span, "this is no comment here");
                    self.diags.push(diag.hint(hint).fix(sign, "'"));
                    self.push(Tok::Comment, span);
                }
                Err(()) if span.of(text).starts_with('_') => {
                    self.stray_underscore(Span::new(span.start, span.start + 1));
                }
                Err(()) => self.stray(&mut lexer, span),
            }
        }
    }

    /// Leaves the current lexer; the rest is read by a new one.
    fn resume(&self, lexer: Lexer<'a, Basic>) -> usize {
        self.text.len() - lexer.remainder().len()
    }

    /// Whether the bracket that was opened by a G-code word closed.
    fn track_brackets(&mut self, sign: Sign) -> bool {
        match sign {
            Sign::OpenBracket => self.brackets += 1,
            Sign::CloseBracket => {
                self.brackets = self.brackets.saturating_sub(1);
                return self.brackets == 0;
            }
            _ => {}
        }
        false
    }

    fn blank_before(&self, span: Span) -> bool {
        let before = self.text.as_bytes().get(..span.start as usize).and_then(<[u8]>::last);
        before.is_none_or(|b| matches!(b, b' ' | b'\t'))
    }

    fn stray_underscore(&mut self, span: Span) {
        let hint = "` _` continues a line where a blank stands before it and nothing but a comment behind it";
        self.report(Code::BadContinuation, span, "`_` stands alone", hint);
        self.push(Tok::Bad, span);
    }

    fn word(&mut self, lexer: &mut Lexer<'a, Basic>, base: usize, span: Span) {
        let word = lexer.slice();
        let rest = lexer.remainder();
        let reserved = words::lookup(word);
        if let Some(Reserved::Kw(Kw::Rem)) = reserved {
            let length = rest.find(['\r', '\n']).unwrap_or(rest.len());
            lexer.bump(length);
            self.push(Tok::Comment, Span::new(span.start, span.end + length as u32));
            return;
        }
        if let Some(Reserved::Kw(kw)) = reserved
            && kw.has_quiet_form()
            && rest.starts_with('?')
        {
            lexer.bump(1);
            self.push(Tok::Quiet(kw), Span::new(span.start, span.end + 1));
            return;
        }
        let is_name = reserved.is_none_or(is_soft);
        if is_name && self.line_start && rest.starts_with(':') && !rest.starts_with(":=") {
            lexer.bump(1);
            self.push(Tok::Label, Span::new(span.start, span.end + 1));
            return;
        }
        let tok = match reserved {
            Some(Reserved::Kw(kw)) => Tok::Kw(kw),
            Some(Reserved::Func(func)) => Tok::Func(func),
            None => Tok::Name,
        };
        let shows = tok == Tok::Func(Func::In) && self.behind_value();
        self.push(tok, span);
        if shows {
            self.shown_unit(lexer, base);
        }
        if is_name {
            self.type_suffix(lexer, base);
        }
    }

    /// Whether a value ends here, as in `POS(X) IN mm`. In `ON IN n` none does.
    fn behind_value(&self) -> bool {
        let Some(before) = self.tokens.last() else { return false };
        match before.tok {
            Tok::Name | Tok::Number | Tok::Bit | Tok::Sign(Sign::Close) | Tok::Func(_) => true,
            Tok::Kw(kw) => kw.is_soft(),
            _ => false,
        }
    }

    /// The unit behind an IN is one name, with its `/`.
    fn shown_unit(&mut self, lexer: &mut Lexer<'a, Basic>, base: usize) {
        let rest = lexer.remainder();
        let blanks = rest.len() - rest.trim_start_matches([' ', '\t']).len();
        let Some(length) = literal::shown_length(&rest[blanks..]) else { return };
        lexer.bump(blanks + length);
        let end = base + lexer.span().end;
        self.push(Tok::Name, Span::new((end - length) as u32, end as u32));
    }

    /// `x%`, `a$`, `f!`, `d#` of other BASICs: reported, then read as the name without it.
    fn type_suffix(&mut self, lexer: &mut Lexer<'a, Basic>, base: usize) {
        let rest = lexer.remainder();
        let Some(suffix) = rest.chars().next().filter(|c| "%$!#".contains(*c)) else { return };
        let behind = rest[1..].trim_start_matches([' ', '\t']);
        let operand = behind.starts_with(|c: char| c.is_ascii_alphanumeric() || c == '(');
        let compares = suffix == '!' && behind.starts_with('=');
        if (suffix == '%' && operand && !rest[1..].starts_with([' ', '\t'])) || compares {
            return;
        }
        let at = (base + lexer.span().end) as u32;
        let hint = "names have no type suffix; a kind is written `AS LENGTH`";
        let message = format!("`{suffix}` can not end a name");
        self.report_fix(Code::UnknownCharacter, Span::new(at, at + 1), message, hint, "");
        lexer.bump(1);
    }

    /// Takes the unit, or the letters that are none, to the digits.
    fn number(&mut self, lexer: &mut Lexer<'a, Basic>, span: Span) {
        let rest = lexer.remainder();
        let word = rest.bytes().take_while(|&b| literal::is_name_byte(b)).count();
        let length = literal::unit_length(rest).unwrap_or(word);
        if length == 0 && self.is_bit(span) {
            return self.push(Tok::Bit, span);
        }
        lexer.bump(length);
        let span = Span::new(span.start, span.end + length as u32);
        match literal::settle(span.of(self.text)) {
            Ok(_) => self.push(Tok::Number, span),
            Err(error) => {
                let mut diag = Diag::new(error.code, span, error.message);
                diag.hint = error.hint;
                if let Some(instead) = error.instead {
                    diag = diag.fix(span, instead);
                }
                if error.code == Code::DecimalWithoutUnit {
                    diag = self.decimals(diag, span);
                }
                self.diags.push(diag);
                self.push(Tok::Bad, span);
            }
        }
    }

    /// Whether a point with digits names a bit: of what stands directly before it.
    fn is_bit(&self, span: Span) -> bool {
        let Some(before) = self.tokens.last() else { return false };
        let has_bits = match before.tok {
            Tok::Name | Tok::Sign(Sign::Close) => true,
            Tok::Kw(kw) => kw.is_soft(),
            _ => false,
        };
        let digits = span.of(self.text);
        let point = digits.starts_with('.') && digits.len() <= 3;
        has_bits && point && before.span.end == span.start
    }

    /// What decimals without a unit behind the last token were meant as.
    fn decimals(&self, diag: Diag, span: Span) -> Diag {
        let Some(before) = self.tokens.last().filter(|token| token.line == self.line) else {
            return diag;
        };
        let (name, digits) = (before.span.of(self.text), span.of(self.text));
        match before.tok {
            // `Portb.0` of BASCOM and `PinB.3` of others.
            Tok::Name if before.span.end == span.start && digits.starts_with('.') => Diag::new(
                Code::UnknownName,
                before.span.to(span),
                format!("`{name}{digits}` is no name"),
            )
            .hint("an output is set by `SetOut n, ON`, an input is read by `IN(n)`"),
            Tok::Name if name.len() == 1 && begins_gcode(&format!("{name}{digits}")) => {
                let message = format!("`{name}` and its number stand apart");
                Diag::new(Code::GcodeWord, before.span.to(span), message)
                    .hint(format!("the number follows its letter directly: `{name}{digits}`"))
                    .fix(before.span.to(span), format!("{name}{digits}"))
            }
            Tok::Kw(Kw::Wait) => diag.hint(format!("write a unit, as in `{digits}s`")),
            _ => diag,
        }
    }

    fn foreign(&mut self, foreign: Foreign, span: Span, rest: &str) {
        let text = span.of(self.text);
        let (tok, hint) = match foreign {
            Foreign::Equal => (Tok::Sign(Sign::Eq), "equal is `=`"),
            Foreign::LessEqual => (Tok::Sign(Sign::Le), "less or equal is `<=`"),
            Foreign::GreaterEqual => (Tok::Sign(Sign::Ge), "greater or equal is `>=`"),
            Foreign::NotEqual => (Tok::Sign(Sign::Ne), "not equal is `<>`"),
            Foreign::And => (Tok::Kw(Kw::AndAlso), "write `ANDALSO`"),
            Foreign::Or => (Tok::Kw(Kw::OrElse), "write `ORELSE`"),
            Foreign::Assign => (Tok::Sign(Sign::Eq), "assignment is `=`"),
            Foreign::Increment | Foreign::AddAssign | Foreign::SubAssign | Foreign::OtherAssign
                if self.assigns(span, rest) =>
            {
                return;
            }
            Foreign::Increment => (Tok::Bad, "write `n = n + 1`"),
            Foreign::AddAssign => (Tok::Bad, "write `n = n + 1`"),
            Foreign::SubAssign => (Tok::Bad, "write `n = n - 1`"),
            Foreign::OtherAssign => (Tok::Bad, "write `n = n * 2`"),
            Foreign::Power => {
                (Tok::Bad, "there is no power operator: multiply, or shift with `<<`")
            }
            Foreign::Backslash => (Tok::Sign(Sign::Slash), "`/` divides whole numbers"),
            Foreign::Bang | Foreign::Tilde => (Tok::Kw(Kw::Not), "write `NOT`"),
            Foreign::Ampersand if self.joins_texts(rest) => {
                let hint = "the parts of a PRINT are joined by `;`";
                let message = "`&` is no operator here";
                self.report_fix(Code::ForeignOperator, span, message, hint, ";");
                return self.push(Tok::Sign(Sign::Semicolon), span);
            }
            Foreign::Ampersand => (Tok::Kw(Kw::And), "write `AND`; hexadecimal is `&H1F`"),
            Foreign::Bar => (Tok::Kw(Kw::Or), "write `OR`"),
            Foreign::Percent => (Tok::Kw(Kw::Mod), "the remainder is `MOD`"),
            Foreign::Brace => {
                let hint = "blocks end with their own word: END IF, NEXT, WEND, LOOP";
                self.report(Code::ForeignBrackets, span, format!("`{text}` has no meaning"), hint);
                return self.push(Tok::Bad, span);
            }
        };
        let adjacent = foreign == Foreign::Increment && rest.starts_with(['+', '-']);
        let hint = if adjacent { "there is no unary `+`" } else { hint };
        let message = format!("`{text}` is no operator here");
        let instead = match tok {
            Tok::Sign(Sign::Eq) => "=".to_owned(),
            Tok::Sign(Sign::Le) => "<=".to_owned(),
            Tok::Sign(Sign::Ge) => ">=".to_owned(),
            Tok::Sign(Sign::Ne) => "<>".to_owned(),
            Tok::Sign(Sign::Slash) => "/".to_owned(),
            Tok::Kw(kw) => self.parted(kw.text(), span),
            _ => String::new(),
        };
        if instead.is_empty() {
            self.report(Code::ForeignOperator, span, message, hint);
        } else {
            self.report_fix(Code::ForeignOperator, span, message, hint, instead);
        }
        self.push(tok, span);
    }

    /// A character that begins nothing; neighbours of its sort are taken with it.
    fn stray(&mut self, lexer: &mut Lexer<'a, Basic>, span: Span) {
        let same = |c: char| !c.is_ascii() && !c.is_whitespace();
        let rest = lexer.remainder();
        let first = span.of(self.text).chars().next().unwrap_or(' ');
        // The rest of a word with an accent in it belongs to the same mistake.
        let word = |c: char| c.is_alphanumeric() || c == '_';
        let more = match first {
            c if c.is_alphabetic() => rest.len() - rest.trim_start_matches(word).len(),
            c if same(c) => rest.len() - rest.trim_start_matches(same).len(),
            _ => 0,
        };
        lexer.bump(more);
        let span = Span::new(span.start, span.end + more as u32);
        let shown: String = span.of(self.text).chars().take(20).collect();
        let (message, hint) = match first {
            '\u{201C}' | '\u{201D}' | '\u{AB}' | '\u{BB}' => (
                format!("`{first}` is a typographic quote"),
                "texts stand in plain quotes: \"text\"",
            ),
            '\u{2018}' | '\u{2019}' => {
                (format!("`{first}` is a typographic quote"), "comments begin with a plain `'`")
            }
            '\u{2212}' | '\u{2013}' | '\u{2014}' => {
                (format!("`{first}` is a dash"), "minus is the plain `-`")
            }
            '\u{B5}' | '\u{3BC}' => {
                ("`\u{B5}` has no meaning here".to_owned(), "micrometres are `um`")
            }
            c if c.is_alphabetic() => (
                format!("`{shown}` can not stand in a name"),
                "names have letters a to z, digits and `_`",
            ),
            c if c.is_control() => (
                format!("the control character {:#04x} has no meaning", c as u32),
                "delete it; is this a script?",
            ),
            _ => (
                format!("`{shown}` has no meaning"),
                "outside comments and texts stand words, numbers and the signs of the language",
            ),
        };
        let plain = |c| match c {
            '\u{201C}' | '\u{201D}' | '\u{AB}' | '\u{BB}' => Some('"'),
            '\u{2018}' | '\u{2019}' => Some('\''),
            '\u{2212}' | '\u{2013}' | '\u{2014}' => Some('-'),
            _ => None,
        };
        match span.of(self.text).chars().map(plain).collect::<Option<String>>() {
            Some(instead) => {
                self.report_fix(Code::UnknownCharacter, span, message, hint, instead);
            }
            None => self.report(Code::UnknownCharacter, span, message, hint),
        }
        self.push(Tok::Bad, span);
    }
}

fn is_soft(reserved: Reserved) -> bool {
    matches!(reserved, Reserved::Kw(kw) if kw.is_soft())
}
