//! Statements of the source: a word, its values, and a semicolon that is often missing.

use nom::Parser;
use nom::bytes::complete::{take_while, take_while1};
use nom::character::complete::{char, one_of};
use nom::combinator::{opt, recognize, verify};
use nom::multi::separated_list1;
use nom::sequence::{delimited, pair, preceded, terminated};

use super::number::{Factor, whole_number};
use super::{Open, Read, Reader, Refused, letters};
use crate::codes::Code;
use crate::isel::instr::{Axes, Op, Pair, Pairs};
use crate::isel::operands::{MAX_STEPS, RATES};
use crate::line::{Parsed, blanks, decimal, sign, whole, word};
use lang::axis::Axis;

/// `12.5(2000)`
type Value<'a> = (&'a str, Option<i64>);

fn value(i: &str) -> Parsed<'_, Value<'_>> {
    pair(decimal, opt(delimited(sign('('), opt(whole), sign(')'))).map(Option::flatten)).parse(i)
}

fn values(i: &str) -> Parsed<'_, Vec<Value<'_>>> {
    separated_list1(sign(','), value).parse(i)
}

/// A word of the language, lower case.
fn keyword(i: &str) -> Parsed<'_, String> {
    let letters = take_while1(|c: char| c.is_alphabetic() || c == '_');
    let (rest, text) = preceded(blanks, letters).parse(i)?;
    Ok((rest, text.to_lowercase()))
}

pub(super) fn label_name(i: &str) -> Parsed<'_, &str> {
    let name = recognize(pair(
        verify(one_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_"), |_| true),
        take_while(|c: char| c.is_alphanumeric() || c == '_'),
    ));
    preceded(blanks, name).parse(i)
}

impl Reader<'_, '_> {
    /// All statements of a line.
    pub(super) fn statements(&mut self, text: &str) -> Read<()> {
        let mut rest = text;
        loop {
            rest = rest.trim_start_matches([' ', '\t', ';', '\u{a0}']);
            if rest.is_empty() {
                return Ok(());
            }
            let named: Parsed<'_, &str> = terminated(label_name, sign(':')).parse(rest);
            if let Ok((after, name)) = named {
                if self.labels.insert(name.to_lowercase(), self.stored.len()).is_some() {
                    return Err(Refused::new(
                        Code::BadJump,
                        format!("the label `{name}` stands twice"),
                        "",
                    ));
                }
                rest = after;
                continue;
            }
            let Ok((after, word)) = keyword(rest) else {
                return Err(Refused::new(
                    Code::Unreadable,
                    format!("`{rest}` is no statement"),
                    "a statement begins with a word",
                ));
            };
            rest = self.statement(&word, after)?;
        }
    }

    /// One statement; gives what stands behind it.
    fn statement<'t>(&mut self, word: &str, rest: &'t str) -> Read<&'t str> {
        match word {
            "move" | "moverel" => self.movement(rest, word, Op::Relative),
            "moveto" | "moveabs" => self.movement(rest, word, Op::Absolute),
            "movep" => self.movement(rest, word, Op::UntilImpulse),
            "repeat" => {
                self.loops.push((self.stored.len(), self.line));
                Ok(rest)
            }
            "until" => self.until(rest),
            "delay" => self.delay(rest),
            "wait" => self.wait(rest),
            "send" => {
                let (rest, c) = number(rest)?;
                character(c)?;
                self.push(Op::Send(c))?;
                Ok(rest)
            }
            "reference" | "référence" | "ref" => {
                let (rest, axes) = axes(rest)?;
                self.owned(axes)?;
                self.push(Op::Home(axes))?;
                Ok(rest)
            }
            "null" => {
                let (rest, axes) = axes(rest)?;
                self.owned(axes)?;
                self.push(Op::Zero(axes))?;
                Ok(rest)
            }
            "stop" => {
                self.stopped = true;
                Ok(rest.trim_start().strip_prefix('.').unwrap_or(rest))
            }
            "goto" => {
                let (rest, name) = label_name(rest).map_err(|_| expected("a label"))?;
                self.jump(name, Op::Jump(0))?;
                Ok(rest)
            }
            "pulse" => self.pulse(rest),
            "line" => {
                let (rest, axes) = axes(rest)?;
                let plane = match axes.0 {
                    3 => 0,
                    5 => 1,
                    6 => 2,
                    _ => {
                        return Err(Refused::new(
                            Code::OutOfRange,
                            "a plane has two axes",
                            "planes are xy, xz, yz",
                        ));
                    }
                };
                self.push(Op::Plane(plane))?;
                Ok(rest)
            }
            "set" => self.solid(rest),
            "circle" => self.circle(rest),
            "set_port" => self.set_port(rest),
            "on_port" => self.on_port(rest),
            "tell" => self.tell(rest),
            _ => Err(Refused::new(
                Code::Unreadable,
                format!("`{word}` is not known"),
                "known are move moverel moveto moveabs movep repeat until delay wait send reference null goto pulse line set circle set_port on_port tell stop",
            )),
        }
    }

    /// Only axes that `#axis` names.
    fn owned(&self, axes: Axes) -> Read<()> {
        if self.axes.holds(axes) {
            return Ok(());
        }
        Err(Refused::new(
            Code::WrongAxis,
            "an axis that `#axis` does not name",
            "the card answers 3",
        ))
    }

    fn steps(&self, axis: Axis, text: &str) -> Read<i64> {
        let wrong = || {
            Refused::new(
                Code::OutOfRange,
                format!("`{text}` is out of range"),
                "steps lie within 8388607",
            )
        };
        // um of a unit times steps of a turn, over um of a turn.
        let num = self.unit.num.checked_mul(self.steps[axis.index()]).ok_or_else(wrong)?;
        let den = self.unit.den.checked_mul(self.elev[axis.index()]).ok_or_else(wrong)?;
        let steps = whole_number(text, Factor { num, den }).ok_or_else(wrong)?;
        if steps.abs() > MAX_STEPS { Err(wrong()) } else { Ok(steps) }
    }

    /// The speed that `#define () (2000);` gives.
    fn usual_speed(&self) -> Option<i64> {
        let (_, text) = self.macros.iter().find(|(name, _)| name == "()")?;
        let rate = text.trim().strip_prefix('(')?.strip_suffix(')')?.trim().parse().ok()?;
        RATES.contains(&rate).then_some(rate)
    }

    fn movement<'t>(&mut self, rest: &'t str, what: &str, make: fn(Pairs) -> Op) -> Read<&'t str> {
        let (rest, mut list) = values(rest)
            .map_err(|_| expected("distances with speeds: `move 10(2000),0(2000);`"))?;
        let absolute = matches!(make(Pairs::default()), Op::Absolute(_));
        let (wanted, z) = (self.axes.pairs(), self.axes.has(Axis::Z));
        // As PAL-PC does.
        if list.len() > wanted {
            self.warn(
                Code::LeftOut,
                format!(
                    "{} values behind `{what}`; `#axis` asks for {wanted}, the others are dropped",
                    list.len()
                ),
            );
            list.truncate(wanted);
        }
        // An absolute move has no use for the second Z.
        if list.len() != wanted && !(absolute && z && list.len() + 1 == wanted) {
            return Err(Refused::new(
                Code::WrongCount,
                format!("{} values behind `{what}`; `#axis` asks for {wanted}", list.len()),
                "one for each of X and Y, two for Z; the card answers 7",
            ));
        }
        let order = self.axes.list().chain([Axis::Z]);
        let mut pairs = Pairs::default();
        for (i, (axis, (text, rate))) in order.zip(&list).enumerate() {
            let steps = self.steps(axis, text)?;
            let rate = match rate {
                Some(rate) if RATES.contains(rate) => *rate,
                None | Some(0) if steps == 0 && !absolute => *RATES.start(),
                None => {
                    let Some(usual) = self.usual_speed() else {
                        return Err(Refused::new(
                            Code::WrongCount,
                            format!("`{text}` has no speed"),
                            "write it in parentheses, in steps/s: `10(2000)`; or the usual one once: \
                             `#define () (2000);`",
                        ));
                    };
                    self.warn(
                        Code::Changed,
                        format!("`{text}` has no speed: that of `#define ()` is taken"),
                    );
                    usual
                }
                Some(rate) => {
                    return Err(Refused::new(
                        Code::OutOfRange,
                        format!("a speed of {rate} steps/s"),
                        "speeds are 21 to 20000; the card answers D",
                    ));
                }
            };
            let pair = Pair { steps, rate };
            if z && i + 1 == wanted {
                pairs.back = Some(pair);
            } else {
                pairs.axes[axis.index()] = Some(pair);
            }
        }
        if absolute && let Some(back) = pairs.back.take().filter(|back| back.steps != 0) {
            let repeats =
                pairs.axes[Axis::Z.index()].is_some_and(|first| first.steps == back.steps);
            if repeats {
                self.note("the second Z of an absolute move repeats the first: it is left out");
            } else {
                self.warn(
                    Code::LeftOut,
                    "the second Z of an absolute move must be 0; it is left out",
                );
            }
        }
        self.push(make(pairs))?;
        Ok(rest)
    }

    fn until<'t>(&mut self, rest: &'t str) -> Read<&'t str> {
        let Some((start, _)) = self.loops.pop() else {
            return Err(Refused::new(Code::BadJump, "`until` without `repeat`", ""));
        };
        if start == self.stored.len() {
            return Err(Refused::new(Code::BadJump, "a loop around nothing", "the card answers C"));
        }
        let forever: Parsed<'_, &str> = word("forever").parse(rest);
        if let Ok((rest, _)) = forever {
            self.push(Op::Loop { times: 0, start })?;
            return Ok(rest);
        }
        let (rest, times) = number(rest)?;
        if !(1..=32_767).contains(&times) {
            return Err(Refused::new(
                Code::OutOfRange,
                format!("{times} passes"),
                "loops run 1 to 32767 times, or `forever`",
            ));
        }
        self.push(Op::Loop { times, start })?;
        Ok(rest)
    }

    /// `delay n`, tenths of a second: a `delay 50` is sent as `550`.
    fn delay<'t>(&mut self, rest: &'t str) -> Read<&'t str> {
        let (rest, tenths) = number(rest)?;
        if !(0..=32_767).contains(&tenths) {
            return Err(Refused::new(
                Code::OutOfRange,
                format!("a delay of {tenths}"),
                "delays are 0 to 32767 tenths of a second",
            ));
        }
        self.push(Op::Delay(tenths))?;
        Ok(rest)
    }

    /// `wait n` is a delay, `wait c, label` waits for a character.
    fn wait<'t>(&mut self, rest: &'t str) -> Read<&'t str> {
        let (after, c) = number(rest)?;
        let comma: Parsed<'_, char> = sign(',').parse(after);
        let Ok((after, _)) = comma else { return self.delay(rest) };
        character(c)?;
        let offset: Parsed<'_, i64> = whole(after);
        if let Ok((after, offset)) = offset {
            let jump = if offset == 0 { None } else { Some(self.away(offset)?) };
            self.push(Op::WaitChar { c, jump })?;
            return Ok(after);
        }
        let (after, name) = label_name(after).map_err(|_| expected("a label or an offset"))?;
        self.jump(name, Op::WaitChar { c, jump: Some(0) })?;
        Ok(after)
    }

    /// The statement `offset` away.
    pub(super) fn away(&self, offset: i64) -> Read<usize> {
        let here = i64::try_from(self.stored.len()).unwrap_or(i64::MAX / 2);
        let to = here.checked_add(offset).and_then(|to| usize::try_from(to).ok());
        to.ok_or_else(|| {
            Refused::new(
                Code::BadJump,
                format!("{offset} leads before the program's start"),
                "the card answers B",
            )
        })
    }

    /// A jump to a label, which may stand further on.
    pub(super) fn jump(&mut self, name: &str, op: Op) -> Read<()> {
        let at = self.stored.len();
        self.push(op)?;
        self.open.push(Open { at, label: name.to_lowercase(), line: self.line });
        Ok(())
    }

    fn pulse<'t>(&mut self, rest: &'t str) -> Read<&'t str> {
        if let Ok((rest, option)) = whole(rest) {
            if !(1..=6).contains(&option) {
                return Err(Refused::new(
                    Code::OutOfRange,
                    format!("pulse option {option}"),
                    "options are 1 to 6; the card answers A",
                ));
            }
            self.push(Op::Pulse(option))?;
            return Ok(rest);
        }
        let (after, what) = keyword(rest).map_err(|_| expected("on, off, out, in or sync"))?;
        let option = match what.as_str() {
            "on" => 1,
            "off" => 2,
            "out" => 3,
            "in" => 4,
            "sync" => 5,
            _ => return Err(expected("on, off, out, in or sync")),
        };
        self.push(Op::Pulse(option))?;
        Ok(after)
    }

    fn solid<'t>(&mut self, rest: &'t str) -> Read<&'t str> {
        let (rest, _): (_, &str) = nom_or(word("3d").parse(rest), "`3d on` or `3d off`")?;
        let (rest, state) = keyword(rest).map_err(|_| expected("on or off"))?;
        match state.as_str() {
            "on" => self.push(Op::Solid(true))?,
            "off" => self.push(Op::Solid(false))?,
            _ => return Err(expected("on or off")),
        }
        Ok(rest)
    }

    /// `circle cw radius(speed), from, to`: angles in degrees from the X axis, counter-clockwise.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_precision_loss,
        reason = "steps have 24 bits"
    )]
    fn circle<'t>(&mut self, rest: &'t str) -> Read<&'t str> {
        let rest = rest.trim_start().trim_start_matches('-');
        let (rest, sense) = keyword(rest).map_err(|_| expected("cw or ccw"))?;
        let clockwise = match sense.as_str() {
            "cw" => true,
            "ccw" => false,
            _ => return Err(expected("cw or ccw")),
        };
        let (rest, list) = values(rest).map_err(|_| expected("a radius and two angles"))?;
        let [(radius, Some(rate)), (from, _), (to, _)] = list[..] else {
            return Err(expected("`circle cw 10(1000), 0, 90;`"));
        };
        let radius = self.steps(Axis::X, radius)?;
        let angles = [from, to].map(|text| text.trim().parse::<f64>().unwrap_or(f64::NAN));
        let [from, to] = angles;
        if radius <= 0
            || !RATES.contains(&rate)
            || angles.iter().any(|a| a.is_nan() || a.abs() > 3600.0)
        {
            return Err(Refused::new(
                Code::OutOfRange,
                "these values make no circle",
                "a radius above 0 and angles in degrees",
            ));
        }
        let mut sweep = if clockwise { from - to } else { to - from };
        while sweep <= 0.0 {
            sweep += 360.0;
        }
        let steps = |x: f64| x.round() as i64;
        let start = [from.to_radians().cos(), from.to_radians().sin()]
            .map(|part| steps(part * radius as f64));
        let length = steps(4.0 * radius as f64 * sweep / 180.0);
        self.push(Op::Clockwise(clockwise))?;
        self.push(Op::Arc { length, rate, from: start })?;
        Ok(rest)
    }

    fn tell<'t>(&mut self, rest: &'t str) -> Read<&'t str> {
        let (rest, device) = number(rest)?;
        let (rest, what) = keyword(rest).map_err(|_| expected("start or ref with its axes"))?;
        if !(0..=9).contains(&device) {
            return Err(Refused::new(
                Code::OutOfRange,
                format!("card {device}"),
                "cards are 0 to 9",
            ));
        }
        let text = match what.strip_prefix("ref") {
            _ if what == "start" => format!("{device}S"),
            Some(named) if !named.is_empty() => format!("{device}R{}", letters(named)?.0),
            _ => return Err(expected("start or ref with its axes")),
        };
        self.push(Op::Tell { text, wait: true })?;
        Ok(rest)
    }
}

pub(super) fn nom_or<'t, T>(parsed: Parsed<'t, T>, what: &str) -> Read<(&'t str, T)> {
    parsed.map_err(|_| expected(what))
}

pub(super) fn expected(what: &str) -> Refused {
    Refused::new(Code::Unreadable, format!("here should stand {what}"), "")
}

fn number(rest: &str) -> Read<(&str, i64)> {
    whole(rest).map_err(|_| expected("a number"))
}

fn axes(rest: &str) -> Read<(&str, Axes)> {
    let list = take_while1(|c: char| "xyzXYZ".contains(c));
    let named: Parsed<'_, &str> = preceded(blanks, list).parse(rest);
    let (rest, text) = named.map_err(|_| expected("axes: `xyz`"))?;
    let open: Parsed<'_, Option<char>> = opt(char('.')).parse(rest);
    let rest = open.map_or(rest, |(rest, _)| rest);
    Ok((rest, letters(text)?))
}

/// A synchronisation character.
fn character(c: i64) -> Read<()> {
    if (33..=125).contains(&c) {
        return Ok(());
    }
    Err(Refused::new(
        Code::OutOfRange,
        format!("synchronisation character {c}"),
        "they are 33 to 125; the card answers 5",
    ))
}
