//! Command files of the JeDiV USB card.
//!
//! `Move;x;y;z;a;max;pause_ms;speed%;message` (JeDiV interface file, section 10). The list of
//! fields there has the pause before the speed, and so have its samples; the `//` header of the
//! sample file names them the other way round.

use nom::Parser;
use nom::multi::many0;
use nom::sequence::preceded;

use super::Job;
use super::codes::Code;
use super::diag::{Diag, Diags};
use super::line::{Parsed, column, sign, whole};
use super::script::{Made, Script, Units, time};
use lang::axis::Axis;

/// Greatest number of steps of one line; the card's counters have 24 bits.
const MAX_STEPS: i64 = 8_388_607;
/// Longest pause, ms: a day.
const MAX_PAUSE: i64 = 86_400_000;
/// Fields of a line behind its word, the message left out.
const FIELDS: usize = 7;
/// Longest group of lines that is looked for when it repeats.
const MAX_GROUP: usize = 16;

/// One line of the script.
struct Row {
    /// Of the file.
    line: u32,
    statement: String,
    remark: String,
}

/// Makes a script of a command file.
pub(crate) fn import(job: &Job<'_>, diags: &mut Diags) -> Made {
    let mut reader = Reader {
        job,
        diags,
        units: Units::new([job.options.scale; 3], job.profile),
        percent: 100,
        height: 0,
        swapped: false,
        fed: None,
        number: 1,
        rows: Vec::new(),
    };
    for (number, line) in job.lines.numbered(reader.diags) {
        reader.line(number, line);
        if reader.diags.hopeless() {
            break;
        }
    }
    let rows = reader.rows;
    if job.options.card.is_none()
        && !diags.has_errors()
        && rows.iter().any(|row| row.statement.starts_with("G1"))
    {
        let text = "a line's speed is taken of the profile's top rate: the card's frequencies stand in no file";
        diags.push(
            Diag::new(Code::Said, 1, 1, text)
                .note()
                .hint("`--feed`, `--travel` and `--threshold` name them"),
        );
    }
    if rows.iter().all(|row| row.statement.is_empty()) && !diags.has_errors() {
        diags.push(Diag::new(Code::NoProgram, 1, 1, "no line of the file does anything"));
    }
    let mut script = Script::new(job.name, "commands of a JeDiV card", job.profile);
    script.remarked("G91", "all moves count from where the tool stands");
    script.gap();
    write(&mut script, &rows, job.options.plain);
    script.finish()
}

struct Reader<'a, 'd> {
    job: &'a Job<'a>,
    diags: &'d mut Diags,
    units: Units,
    /// Speed in percent of the profile's top.
    percent: i64,
    /// Z as the card's counter has it, steps.
    height: i64,
    /// Axes 1 and 3, and 2 and 4, have changed places.
    swapped: bool,
    /// The F that holds, steps/s.
    fed: Option<i64>,
    /// The line that is being read.
    number: u32,
    rows: Vec<Row>,
}

/// Whether two groups of lines do the same.
fn alike(a: &[Row], b: &[Row]) -> bool {
    let same = |(a, b): (&Row, &Row)| a.statement == b.statement && a.remark == b.remark;
    a.len() == b.len() && a.iter().zip(b).all(same)
}

impl Reader<'_, '_> {
    fn error(&mut self, line: u32, col: u32, code: Code, text: impl Into<String>, hint: &str) {
        self.diags.push(Diag::new(code, line, col, text).hint(hint));
    }

    fn push(&mut self, statement: String, remark: &str) {
        self.rows.push(Row { line: self.number, statement, remark: remark.to_owned() });
    }

    fn line(&mut self, number: u32, line: &str) {
        self.number = number;
        let text = line.trim();
        if let Some(remark) = text.strip_prefix("//") {
            let lower = remark.to_lowercase();
            if let (Some(speed), Some(pause)) = (lower.find("vitesse"), lower.find("pause"))
                && speed < pause
            {
                let text = "this header has speed before pause; the card reads pause, then speed";
                self.diags.push(Diag::new(Code::Inconsistent, number, 1, text).note());
            }
            return self.push(String::new(), remark);
        }
        if text.is_empty() {
            return;
        }
        if let Some(value) = text.strip_prefix("O=") {
            return self.swap(line, value);
        }
        let Some((word, rest)) = text.split_once(';') else {
            let hint = "a line is Move, Pause or RAZ_CPT and its fields with `;` between";
            return self.error(
                number,
                1,
                Code::Unreadable,
                format!("`{text}` has no fields"),
                hint,
            );
        };
        let fields: Parsed<'_, Vec<i64>> = (whole, many0(preceded(sign(';'), whole)))
            .map(|(first, mut rest)| {
                rest.insert(0, first);
                rest
            })
            .parse(rest);
        let Ok((tail, values)) = fields else {
            return self.error(
                number,
                column(line, rest),
                Code::Unreadable,
                "numbers belong here",
                "steps are whole numbers",
            );
        };
        let message = match tail.trim_start().strip_prefix(';') {
            Some(message) => message.trim(),
            None if tail.trim().is_empty() => "",
            None => {
                let col = column(line, tail);
                return self.error(
                    number,
                    col,
                    Code::Unreadable,
                    format!("`{}` is no field", tail.trim()),
                    "fields are whole numbers with `;` between",
                );
            }
        };
        if values.len() != FIELDS {
            let text = format!("{} fields; {FIELDS} belong behind `{word}`", values.len());
            let hint = "`Move;x;y;z;a;max;pause_ms;speed%;message`";
            return self.error(number, column(line, rest), Code::WrongCount, text, hint);
        }
        match word.trim() {
            "Move" => self.movement(number, &values, message),
            "Pause" => {
                if values[..4].iter().any(|steps| *steps != 0) {
                    return self.error(
                        number,
                        1,
                        Code::Inconsistent,
                        "a pause that moves",
                        "write a Move line",
                    );
                }
                self.pause(number, values[5], message);
            }
            "RAZ_CPT" => {
                let list: Vec<String> = self
                    .job
                    .profile
                    .axes()
                    .map(|(axis, _)| format!("SetPos {}, 0mm", axis.letter()))
                    .collect();
                self.height = 0;
                self.push(list.join(" : "), message);
            }
            other => {
                let hint = "known are Move, Pause, RAZ_CPT and // remarks";
                self.error(number, 1, Code::Unreadable, format!("`{other}` is not known"), hint);
            }
        }
    }

    /// `O=True` or `O=False` (section 9.1.6): axes 1 and 3, and 2 and 4, change places or not.
    fn swap(&mut self, line: &str, value: &str) {
        self.swapped = match value.trim().to_lowercase().as_str() {
            "true" | "t" => true,
            "false" | "f" => false,
            _ => {
                let text = format!("`O={value}` swaps no axes");
                let (number, hint) = (self.number, "`O=True` or `O=False`");
                return self.error(number, column(line, value), Code::Unreadable, text, hint);
            }
        };
        let remark = if self.swapped { "axes 1 and 3 swapped" } else { "axes as they are" };
        self.push(String::new(), remark);
    }

    fn pause(&mut self, number: u32, ms: i64, message: &str) {
        if !(0..=MAX_PAUSE).contains(&ms) {
            return self.error(
                number,
                1,
                Code::OutOfRange,
                format!("a pause of {ms} ms"),
                "pauses are 0 to a day",
            );
        }
        self.push(format!("Wait {}", time(ms)), message);
    }

    fn movement(&mut self, number: u32, values: &[i64], message: &str) {
        let (most, pause, percent) = (values[4], values[5], values[6]);
        let mut steps = [values[0], values[1], values[2], values[3]];
        if self.swapped {
            steps.rotate_left(2);
        }
        let steps = &steps[..];
        if steps[3] != 0 {
            let text = match self.swapped {
                true => "a fourth axis moves: that is axis 2 behind `O=True`",
                false => "a fourth axis moves",
            };
            let hint = "the machine has X, Y and Z";
            return self.error(number, 1, Code::WrongAxis, text, hint);
        }
        if let Some(wrong) = steps.iter().find(|steps| steps.abs() > MAX_STEPS) {
            return self.error(
                number,
                1,
                Code::OutOfRange,
                format!("{wrong} steps"),
                "steps lie within 8388607",
            );
        }
        if !(0..=100).contains(&percent) {
            return self.error(
                number,
                1,
                Code::OutOfRange,
                format!("a speed of {percent} %"),
                "speeds are 1 to 100, 0 keeps the last",
            );
        }
        let longest = steps.iter().map(|steps| steps.abs()).max().unwrap_or(0);
        if most != longest {
            let text = format!("the longest way is {longest} steps, the line says {most}");
            self.diags.push(Diag::new(Code::Inconsistent, number, 1, text).warning());
        }
        if percent > 0 {
            self.percent = percent;
        }
        let mut words = Vec::new();
        for (axis, steps) in Axis::ALL.into_iter().zip(steps) {
            if *steps == 0 {
                continue;
            }
            if self.job.profile.axis(axis).is_none() {
                let text = format!(
                    "the machine `{}` has no axis {}",
                    self.job.profile.name,
                    axis.letter()
                );
                return self.error(
                    number,
                    1,
                    Code::WrongAxis,
                    text,
                    "choose another with `--profile`",
                );
            }
            let text = self.units.steps(axis, *steps);
            words.push(match text.strip_suffix("mm") {
                Some(mm) => format!("{}{mm}", axis.letter()),
                None => format!("{}[{text}]", axis.letter()),
            });
        }
        if words.is_empty() {
            self.push(String::new(), if message.is_empty() { "speed" } else { message });
        } else {
            let feed = self.feed(steps);
            if self.fed.replace(feed) != Some(feed) {
                words.push(format!("F[{feed}st/s]"));
            }
            self.push(format!("G1 {}", words.join(" ")), message);
            self.height += steps[2];
        }
        if pause != 0 {
            self.pause(number, pause, "");
        }
    }

    /// Steps/s along the path when the axis with the longest way runs at the percentage of the
    /// card's frequency, which counts that axis's steps; without one of its top.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_precision_loss,
        reason = "24-bit values are exact"
    )]
    fn feed(&self, steps: &[i64]) -> i64 {
        let longest = Axis::ALL.into_iter().zip(steps).max_by_key(|(_, steps)| steps.abs());
        let Some((axis, longest)) = longest else { return 1 };
        let top = self.job.profile.axis(axis).map_or(1, |part| i64::from(part.top_rate));
        let below = self.height.min(self.height + steps[2]);
        let top = match self.job.options.card {
            None => top,
            Some(card) => match card.threshold {
                // A plunge begins above the threshold and ends in the work.
                Some(threshold) if below >= threshold => card.travel.into(),
                _ => card.feed.into(),
            },
        };
        let path = steps.iter().map(|steps| (*steps as f64).powi(2)).sum::<f64>().sqrt();
        let rate = (top * self.percent) as f64 / 100.0 * path / longest.abs().max(1) as f64;
        (rate.round() as i64).max(1)
    }
}

/// Writes the lines; groups that repeat three times or more become loops, unless `plain`.
fn write(script: &mut Script, rows: &[Row], plain: bool) {
    let mut at = 0;
    while at < rows.len() {
        let found = (1..=if plain { 0 } else { MAX_GROUP }).find_map(|len| {
            let first = rows.get(at..at + len)?;
            let groups =
                rows[at..].chunks_exact(len).take_while(|group| alike(group, first)).count();
            (groups >= 3 && groups * len >= 4).then_some((len, groups))
        });
        let (len, times) = found.unwrap_or((1, 1));
        if times > 1 {
            script.open(&format!("REPEAT {times}"));
        }
        for row in &rows[at..at + len] {
            script.set_place(row.line);
            match row.statement.as_str() {
                "" => script.remark(&row.remark),
                statement => script.remarked(statement, &row.remark),
            }
        }
        if times > 1 {
            script.close("END REPEAT");
        }
        at += len * times;
    }
}
