//! Blocks of G-code.

use logos::{Lexer, Logos};

use super::State;
use crate::front::codes::Code;
use crate::front::span::Span;
use crate::front::token::{Gcode, Sign, Tok};
use crate::front::{literal, words};

impl<'a> State<'a> {
    /// Reads G-code until the block ends or a bracket opens.
    pub(super) fn gcode(&mut self, at: usize) -> usize {
        let text = self.text;
        let mut lexer = Gcode::lexer(text.get(at..).unwrap_or(""));
        while !self.diags.hopeless()
            && let Some(piece) = lexer.next()
        {
            let range = lexer.span();
            let span = Span::new((at + range.start) as u32, (at + range.end) as u32);
            match piece {
                Ok(Gcode::Word) => self.push(Tok::GWord, span),
                Ok(Gcode::Bracket) => {
                    self.push(Tok::GLetter, Span::new(span.start, span.start + 1));
                    self.push(Tok::Sign(Sign::OpenBracket), Span::new(span.start + 1, span.end));
                    self.brackets = 1;
                    return span.end as usize;
                }
                Ok(Gcode::Parenthesis) => {
                    let letter = &span.of(text)[..1];
                    let message = format!("`{letter}(` is no G-code word");
                    let hint = format!("expressions stand in brackets: `{letter}[...]`");
                    self.bad_word(span, message, &hint);
                    let rest = lexer.remainder();
                    let line = rest.find(['\r', '\n']).unwrap_or(rest.len());
                    lexer.bump(rest[..line].find(')').map_or(0, |close| close + 1));
                }
                Ok(Gcode::Remark) => self.push(Tok::GComment, span),
                Ok(Gcode::UnclosedRemark) => {
                    let hint = "a comment in a G-code block ends with `)` on its line";
                    self.report(Code::UnclosedComment, span, "the comment has no `)`", hint);
                    self.push(Tok::GComment, span);
                }
                Ok(Gcode::Comment) => self.push(Tok::Comment, span),
                Ok(Gcode::Letters) => {
                    let word = lexer.slice();
                    if ends_block(word, lexer.remainder()) {
                        self.gcode = false;
                        return span.start as usize;
                    }
                    self.gcode_letters(&mut lexer, span);
                }
                Ok(Gcode::Colon) => {
                    self.push(Tok::Sign(Sign::Colon), span);
                    return span.end as usize;
                }
                Ok(Gcode::LineEnd) => {
                    self.push(Tok::LineEnd, span);
                    return span.end as usize;
                }
                Ok(Gcode::Continuation) if self.blank_before(span) => {
                    self.push(Tok::Continuation, span);
                }
                Ok(Gcode::Continuation) => {
                    let underscore = Span::new(span.start, span.start + 1);
                    self.stray_underscore(underscore);
                    return underscore.end as usize;
                }
                Err(()) => self.gcode_stray(&mut lexer, span),
            }
        }
        text.len()
    }

    /// Letters without a number.
    fn gcode_letters(&mut self, lexer: &mut Lexer<'a, Gcode>, span: Span) {
        let rest = lexer.remainder();
        let number = rest.bytes().take_while(|&b| b.is_ascii_digit() || b == b'.').count();
        lexer.bump(number);
        let span = Span::new(span.start, span.end + number as u32);
        if self.needs_brackets(lexer, span) {
            return;
        }
        let rest = lexer.remainder();
        let word = span.of(self.text);
        let message = format!("`{word}` is no G-code word");
        let apart = rest.trim_start_matches([' ', '\t']);
        let hint = if word.len() == 1 && apart.starts_with(|c: char| "+-.0123456789[".contains(c)) {
            format!("the number follows its letter directly: `{word}{}`", value_start(apart))
        } else if apart.starts_with('#') {
            PARAMETERS.to_owned()
        } else if words::lookup(word).is_some() {
            "a `:` separates statements".to_owned()
        } else {
            "a word is a letter directly followed by a number or `[expression]`".to_owned()
        };
        self.bad_word(span, message, &hint);
    }

    /// Reports `X5mm`, `F1200 mm/min`, `Z-depth` and `Zdepth` with the brackets that they want. `false` where it is something else.
    fn needs_brackets(&mut self, lexer: &mut Lexer<'a, Gcode>, span: Span) -> bool {
        let (word, rest) = (span.of(self.text), lexer.remainder());
        let number = self.tokens.last().filter(|last| last.tok == Tok::GWord);
        let number = number.filter(|last| {
            let between = self.text.get(last.span.end as usize..span.start as usize);
            let blank = between.is_some_and(|text| text.trim_matches([' ', '\t']).is_empty());
            blank && literal::is_unit(word)
        });
        let name_length =
            |text: &str| text.bytes().take_while(|&b| literal::is_name_byte(b)).count();
        let (whole, message) = match number {
            Some(number) => {
                // `mm` of `mm/min`.
                let from = self.text.get(span.start as usize..).unwrap_or(word);
                let more = literal::unit_length(from).map_or(0, |length| length - word.len());
                lexer.bump(more);
                let whole = Span::new(number.span.start, span.end + more as u32);
                (whole, format!("a unit stands in the word `{}`", whole.of(self.text)))
            }
            None if words::lookup(word).is_none()
                && "XYZIJKRFSP".contains(&word[..1].to_uppercase()) =>
            {
                let signed = rest.strip_prefix('-').filter(|_| word.len() == 1);
                let more = match signed {
                    Some(name) if name.starts_with(|c: char| c.is_ascii_alphabetic()) => {
                        1 + name_length(name)
                    }
                    None if word.len() > 1 && word.bytes().all(|b| b.is_ascii_alphabetic()) => {
                        name_length(rest)
                    }
                    _ => return false,
                };
                lexer.bump(more);
                (
                    Span::new(span.start, span.end + more as u32),
                    format!("`{word}` is no G-code word"),
                )
            }
            None => return false,
        };
        let (letter, value) = whole.of(self.text).split_at(1);
        let instead = format!("{letter}[{}]", value.replace([' ', '\t'], ""));
        let hint = format!("a value that is no plain number stands in brackets: `{instead}`");
        if !self.block_reported {
            self.report_fix(Code::GcodeWord, whole, message, &hint, instead);
        }
        self.block_reported = true;
        self.push(Tok::Bad, span);
        true
    }

    /// Reports the first wrong word of a block.
    fn bad_word(&mut self, span: Span, message: String, hint: &str) {
        if !self.block_reported {
            self.report(Code::GcodeWord, span, message, hint);
        }
        self.block_reported = true;
        self.push(Tok::Bad, span);
    }

    fn gcode_stray(&mut self, lexer: &mut Lexer<'a, Gcode>, span: Span) {
        let first = span.of(self.text).chars().next().unwrap_or(' ');
        let bit = self.tokens.last().map_or("", |word| word.span.of(self.text));
        let hint = match first {
            '#' => PARAMETERS,
            '/' => "there is no block delete: use IF",
            '*' => "checksums are not used here: delete it",
            ',' => "words stand side by side: `G1 X10 Y5`",
            '=' if bit.contains('.') => "a bit is written by a statement of its own: `n.3 = ON`",
            '=' => "a name that begins like a G-code word needs an underscore: `x_1 = 5`",
            _ => "a word is a letter directly followed by a number or `[expression]`",
        };
        let apart = |c: char| c.is_ascii_digit() || "+-.".contains(c);
        if first == ',' && self.digit_before(span) && self.digit_after(span) {
            let word = self.tokens.last().map_or("", |word| word.span.of(self.text)).to_owned();
            let rest = lexer.remainder();
            let digits = rest.bytes().take_while(u8::is_ascii_digit).count();
            let hint = format!("decimals have a point: `{word}.{}`", &rest[..digits]);
            if !self.block_reported {
                let message = "a comma stands in the number";
                self.report_fix(Code::GcodeWord, span, message, &hint, ".");
            }
            self.block_reported = true;
            lexer.bump(digits);
            return self.push(Tok::Bad, span);
        }
        let rest = lexer.remainder();
        let more = rest.len() - rest.trim_start_matches(apart).len();
        lexer.bump(if apart(first) { more } else { 0 });
        let span = Span::new(span.start, (self.text.len() - lexer.remainder().len()) as u32);
        let shown: String = span.of(self.text).chars().take(20).collect();
        let message = format!("`{shown}` is no G-code word");
        self.bad_word(span, message, hint);
    }
}

/// The hint for `#5`.
const PARAMETERS: &str = "parameters of G-code are not known here: use a variable, as in `X[a]`";

fn ends_block(word: &str, rest: &str) -> bool {
    let whole = !rest.bytes().next().is_some_and(literal::is_name_byte);
    whole && (word.eq_ignore_ascii_case("ELSE") || word.eq_ignore_ascii_case("REM"))
}

/// The characters of a number, for a hint.
fn value_start(text: &str) -> &str {
    let end = text.find(|c: char| !(c.is_ascii_digit() || "+-.[".contains(c)));
    text.get(..end.unwrap_or(text.len()).min(12)).unwrap_or("")
}
