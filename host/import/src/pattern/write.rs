//! From a pattern to the text of a script.

use std::collections::HashSet;

use lang::axis::Axis;
use lang::profile::{AxisProfile, OutputRole, Profile};

use super::table::{Row, check_name, text as table_text, words};
use super::{Act, Down, MAX_UM, Pattern, Point, Shape, Written, check};
use crate::script::{Script, clean, mm, time};

/// Greatest product of a loop's counter and a length that the device multiplies, um.
const MOST_PRODUCT: i64 = 2_000_000_000;
/// Longest wait or pulse, ms.
const MOST_MS: i64 = 3_600_000;
/// Fastest way down, um/s.
const MOST_FEED: i64 = 1_000_000;
/// Places that are told for a picture.
const MOST_SHOWN: usize = 5_000;

/// Writes a whole script, or, with the text of the one into which it goes, a piece of it.
///
/// # Errors
/// The pattern or its frame is wrong, or the machine cannot do it; in words.
pub fn write(pattern: &Pattern, profile: &Profile, into: Option<&str>) -> Result<Written, String> {
    check_name(&pattern.name)?;
    check::needed(profile, Axis::X)?;
    check::needed(profile, Axis::Y)?;
    work_is_good(pattern, profile)?;
    let mut points = pattern.shape.points()?;
    let mut notes = Vec::new();
    let fit = pattern.frame.as_ref().map(super::Frame::fit).transpose()?;
    for point in &mut points {
        let drawn = [0, 1].map(|i| point.at[i] + pattern.origin[i]);
        point.at = fit.as_ref().map_or(drawn, |fit| fit.place(drawn));
        if point.at.iter().any(|um| um.abs() > MAX_UM) {
            return Err("a point of the pattern lies beyond 10 m".to_owned());
        }
    }
    let mut writer = Writer::new(pattern, profile, into);
    writer.head(fit.as_ref().map(|fit| fit.brief.as_str()));
    let body = match &pattern.shape {
        _ if fit.is_some() => None,
        Shape::Grid { count, pitch, zigzag } => writer.grid(*count, *pitch, *zigzag),
        Shape::Line { count, way } => writer.line(*count, *way),
        Shape::Sockets { count, apart, pins, pitch, rows } => {
            writer.sockets([*count, *pins], [*apart, *pitch, *rows])
        }
        Shape::Circle { .. } | Shape::Points(_) => None,
    };
    match body {
        Some(body) => writer.loops(&body),
        None => writer.tables(&points)?,
    }
    let text = writer.script.finish().text;
    check::try_out(&text, profile)?;
    if let Some(fit) = fit {
        notes.push(format!("the drawing is {}", fit.words));
        notes.extend(fit.notes);
    }
    notes.extend(check::travel(pattern, &points, profile));
    let places = points.iter().take(MOST_SHOWN).map(|point| point.at).collect();
    Ok(Written { text, count: points.len(), places, notes })
}

fn work_is_good(pattern: &Pattern, profile: &Profile) -> Result<(), String> {
    if let Some(Down { surface, depth, clear, feed }) = pattern.work.down {
        check::needed(profile, Axis::Z)?;
        if surface.saturating_abs() > MAX_UM
            || !(1..=MAX_UM).contains(&depth)
            || !(1..=MAX_UM).contains(&clear)
            || !(1..=MOST_FEED).contains(&feed)
        {
            return Err(
                "depth and clearance are positive lengths, and Z goes down at 0.001 to 1000 \
                        mm/s"
                    .to_owned(),
            );
        }
    }
    match pattern.work.act {
        Act::Nothing => Ok(()),
        Act::Wait { ms } | Act::Pulse { ms, .. } if !(1..=MOST_MS).contains(&ms) => {
            Err("a wait or a pulse takes 1 ms to 1 h".to_owned())
        }
        Act::Pulse { output, .. } if !(1..=profile.wiring.outputs()).contains(&output) => {
            Err(format!("the machine `{}` has no output {output}", profile.name))
        }
        _ => Ok(()),
    }
}

/// The loops of a regular pattern.
struct Body {
    /// What it is, for the first line.
    what: String,
    consts: Vec<String>,
    vars: Vec<String>,
    /// Lines that open a loop, from outside to inside.
    opens: Vec<String>,
    /// Lines in the innermost one, before the work.
    inside: Vec<String>,
}

struct Writer<'a> {
    pattern: &'a Pattern,
    profile: &'a Profile,
    /// Words of the script into which it goes.
    taken: HashSet<String>,
    whole: bool,
    script: Script,
    /// Names of the Z constants, where Z moves.
    down: Option<[String; 3]>,
    spindle: bool,
}

impl<'a> Writer<'a> {
    fn new(pattern: &'a Pattern, profile: &'a Profile, into: Option<&str>) -> Writer<'a> {
        let down = pattern.work.down.is_some();
        let mut own = Writer {
            pattern,
            profile,
            taken: words(into.unwrap_or_default()),
            whole: into.is_none(),
            script: Script::default(),
            down: None,
            // Where an output is switched at each point Z carries a dispenser or a gripper.
            spindle: pattern.work.spindle
                && down
                && !matches!(pattern.work.act, Act::Pulse { .. })
                && profile.output_with(OutputRole::Spindle).is_some(),
        };
        own.down = down.then(|| ["BOTTOM", "ABOVE", "PLUNGE"].map(|name| own.fresh(name)));
        own
    }

    /// A name that the script does not have yet.
    fn fresh(&mut self, name: &str) -> String {
        let all = std::iter::once(name.to_owned()).chain((2..).map(|n| format!("{name}_{n}")));
        let free = |name: &String| !self.taken.contains(&name.to_lowercase());
        let found = all.into_iter().find(free).unwrap_or_default();
        self.taken.insert(found.to_lowercase());
        found
    }

    /// The first lines: what it is, the machine, and how deep.
    fn head(&mut self, frame: Option<&str>) {
        let what = match &self.pattern.shape {
            Shape::Circle { count, diameter, first_mdeg } => {
                let from = mm(first_mdeg % 360_000);
                format!(
                    "{count} {} on a circle of {} round X {}, Y {}, from {} degrees on",
                    self.pattern.name,
                    mm(*diameter),
                    mm(self.pattern.origin[0]),
                    mm(self.pattern.origin[1]),
                    from.trim_end_matches("mm")
                )
            }
            Shape::Points(list) => format!("{} {} of a list", list.len(), self.pattern.name),
            Shape::Grid { count, pitch, .. } => format!(
                "{} by {} {}, {} and {} apart",
                count[0],
                count[1],
                self.pattern.name,
                mm(pitch[0]),
                mm(pitch[1])
            ),
            Shape::Line { count, way } => {
                format!("{count} {} over X {}, Y {}", self.pattern.name, mm(way[0]), mm(way[1]))
            }
            Shape::Sockets { count, pins, pitch, rows, .. } => format!(
                "{count} sockets: two rows of {pins} {}, {} apart, the rows {}",
                self.pattern.name,
                mm(*pitch),
                mm(*rows)
            ),
        };
        let lies = frame.map_or(String::new(), |words| format!(", {words}"));
        self.script.remark(&format!("{what}{lies}."));
        if self.whole {
            self.script.line(&format!("PROFILE \"{}\"", self.profile.name));
        }
        let Some(down) = &self.pattern.work.down else { return };
        let surface = self.fresh("SURFACE");
        let Some([bottom, above, plunge]) = self.down.clone() else { return };
        let downward = self.profile.z.as_ref().is_some_and(AxisProfile::counts_down);
        let (deeper, higher) = if downward { ("+", "-") } else { ("-", "+") };
        self.script
            .remarked(&format!("CONST {surface} = {}", mm(down.surface)), "Z of the surface");
        self.script.line(&format!(
            "CONST {bottom} = {surface} {deeper} {}, {above} = {surface} {higher} {}",
            mm(down.depth),
            mm(down.clear)
        ));
        self.script.line(&format!("CONST {plunge} = {}", speed(down.feed)));
    }

    /// Home, and what the lines behind it rely on.
    fn begin(&mut self) {
        self.script.gap();
        if self.whole && !self.profile.home_order.is_empty() {
            self.script.line("Home");
        }
        if self.taken.contains("g91") {
            self.script.line("G90");
        }
        if let Some([_, above, _]) = self.down.clone() {
            self.script.line(&format!("G0 Z[{above}]"));
        }
        if self.spindle {
            self.script.line("M3");
        }
    }

    /// The work at the place that was reached.
    fn work(&mut self) {
        let down = self.down.clone();
        if let Some([bottom, _, plunge]) = &down {
            self.script.line(&format!("G1 Z[{bottom}] F[{plunge}]"));
        }
        match self.pattern.work.act {
            Act::Nothing => {}
            Act::Wait { ms } => self.script.line(&format!("Wait {}", time(ms))),
            Act::Pulse { output, ms } => self.script.line(&format!("Pulse {output}, {}", time(ms))),
        }
        if let Some([_, above, _]) = &down {
            self.script.line(&format!("G0 Z[{above}]"));
        }
    }

    fn end(&mut self) {
        if self.spindle {
            self.script.line("M5");
        }
    }

    /// `LEFT + column * PITCH`, without what is 0.
    fn from(origin: i64, rest: &str) -> String {
        match origin {
            0 => rest.to_owned(),
            um if rest.starts_with('-') => format!("{} - {}", mm(um), &rest[1..]),
            um => format!("{} + {rest}", mm(um)),
        }
    }

    fn grid(&mut self, count: [i64; 2], pitch: [i64; 2], zigzag: bool) -> Option<Body> {
        if count.iter().zip(pitch).any(|(n, um)| n * um.abs() > MOST_PRODUCT) {
            return None;
        }
        let [wide, high] = ["COLUMNS", "ROWS"].map(|name| self.fresh(name));
        let [column, row] = ["column", "row"].map(|name| self.fresh(name));
        let mut vars = vec![column.clone(), row.clone()];
        let mut inside = Vec::new();
        let mut at = column.clone();
        if zigzag {
            at = self.fresh("place");
            vars.push(at.clone());
            let last = count[0] - 1;
            inside.push(format!(
                "IF {row} MOD 2 = 0 THEN {at} = {column} ELSE {at} = {last} - {column}"
            ));
        }
        let [x, y] = self.pattern.origin;
        inside.push(format!(
            "G0 X[{}] Y[{}]",
            Self::from(x, &format!("{at} * {wide}")),
            Self::from(y, &format!("{row} * {high}"))
        ));
        Some(Body {
            what: format!("{} {}", count[0] * count[1], self.pattern.name),
            consts: vec![format!("CONST {wide} = {}, {high} = {}", mm(pitch[0]), mm(pitch[1]))],
            vars,
            opens: vec![
                format!("FOR {row} = 0 TO {}", count[1] - 1),
                format!("FOR {column} = 0 TO {}", count[0] - 1),
            ],
            inside,
        })
    }

    fn line(&mut self, count: i64, way: [i64; 2]) -> Option<Body> {
        if way.iter().any(|um| um.abs() * count > MOST_PRODUCT) {
            return None;
        }
        let gaps = (count - 1).max(1);
        let i = self.fresh("i");
        let mut consts = Vec::new();
        let words = [("X", "STEP_X"), ("Y", "STEP_Y")];
        let ways =
            words.iter().zip(way).zip(self.pattern.origin).map(|(((letter, name), um), from)| {
                if um == 0 {
                    return format!("{letter}[{}]", mm(from));
                }
                if um % gaps != 0 {
                    return format!(
                        "{letter}[{}]",
                        Self::from(from, &format!("{i} * {} / {gaps}", mm(um)))
                    );
                }
                let name = self.fresh(name);
                consts.push(format!("CONST {name} = {}", mm(um / gaps)));
                format!("{letter}[{}]", Self::from(from, &format!("{i} * {name}")))
            });
        let inside = vec![format!("G0 {}", ways.collect::<Vec<_>>().join(" "))];
        Some(Body {
            what: format!("{count} {}", self.pattern.name),
            consts,
            vars: vec![i.clone()],
            opens: vec![format!("FOR {i} = 0 TO {}", count - 1)],
            inside,
        })
    }

    fn sockets(&mut self, [count, pins]: [i64; 2], [apart, pitch, rows]: [i64; 3]) -> Option<Body> {
        if count * apart.abs() + pins * pitch.abs() > MOST_PRODUCT {
            return None;
        }
        let [step, wide, next] = ["PITCH", "ROWS", "SOCKETS"].map(|name| self.fresh(name));
        let [socket, row, pin] = ["socket", "row", "pin"].map(|name| self.fresh(name));
        let [x, y] = self.pattern.origin;
        let along = format!("{socket} * {next} + {pin} * {step}");
        let place = format!(
            "G0 X[{}] Y[{}]",
            Self::from(x, &along),
            Self::from(y, &format!("{row} * {wide}"))
        );
        Some(Body {
            what: format!("{} {}", 2 * count * pins, self.pattern.name),
            consts: vec![format!(
                "CONST {step} = {}, {wide} = {}, {next} = {}",
                mm(pitch),
                mm(rows),
                mm(apart)
            )],
            vars: vec![socket.clone(), row.clone(), pin.clone()],
            opens: vec![
                format!("FOR {socket} = 0 TO {}", count - 1),
                format!("FOR {row} = 0 TO 1"),
                format!("FOR {pin} = 0 TO {}", pins - 1),
            ],
            inside: vec![place],
        })
    }

    fn loops(&mut self, body: &Body) {
        body.consts.iter().for_each(|line| self.script.line(line));
        self.script.line(&format!("DIM {}", body.vars.join(", ")));
        self.begin();
        for (n, line) in body.opens.iter().enumerate() {
            if n == 0 {
                self.script.remark(&body.what);
            }
            self.script.open(line);
        }
        body.inside.iter().for_each(|line| self.script.line(line));
        self.work();
        body.opens.iter().for_each(|_| self.script.close("NEXT"));
        self.end();
    }

    /// A table for each group of the list, and a loop over it.
    fn tables(&mut self, points: &[Point]) -> Result<(), String> {
        let mut groups: Vec<Vec<&Point>> = Vec::new();
        for point in points {
            match groups.iter_mut().find(|group| group[0].group == point.group) {
                Some(group) => group.push(point),
                None => groups.push(vec![point]),
            }
        }
        let i = self.fresh("i");
        let mut names = Vec::new();
        for points in &groups {
            let name = if groups.len() == 1 {
                self.fresh(&self.pattern.name)
            } else {
                self.fresh(&format!("{}_{}", self.pattern.name, names.len() + 1))
            };
            let row = |point: &&Point| Row { name: point.name.clone(), at: point.at.to_vec() };
            let rows: Vec<Row> = points.iter().map(row).collect();
            let table = table_text(&name, 2, "", &rows)?;
            table.lines().for_each(|line| self.script.line(line));
            names.push(name);
        }
        self.script.line(&format!("DIM {i}"));
        self.begin();
        for (n, (points, name)) in groups.iter().zip(&names).enumerate() {
            let group = clean(&points[0].group);
            let of = if group.is_empty() { group } else { format!(", {group}") };
            // A tool has a number or a size, the side of a board has not.
            let is_tool = of.contains(|c: char| c.is_ascii_digit());
            if n > 0 && self.down.is_some() && is_tool {
                if self.spindle {
                    self.script.line("M5");
                }
                self.script.remarked("M6", "the next tool, then Start");
                if self.spindle {
                    self.script.line("M3");
                }
            }
            let plural = if points.len() == 1 { "" } else { "s" };
            self.script.remark(&format!("{} point{plural}{of}", points.len()));
            self.script.open(&format!("FOR {i} = 0 TO COUNT({name}) - 1"));
            self.script.line(&format!("G0 X[{name}({i}, 0)] Y[{name}({i}, 1)]"));
            self.work();
            self.script.close("NEXT");
        }
        self.end();
        Ok(())
    }
}

/// A speed as a person writes it.
fn speed(um_s: i64) -> String {
    match um_s * 60 % 1000 {
        0 => format!("{}mm/min", um_s * 60 / 1000),
        _ => format!("{}/s", mm(um_s)),
    }
}
