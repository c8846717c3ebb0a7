//! Tools of a cell file.

use super::{Builder, us};
use crate::pressure::MOST_MV;
use crate::problem::Problem;
use crate::read::Port;
use crate::scene::{Block, Gripper, Tool, ToolKind, Vacuum};
use crate::value::Entry;

/// Roles of an output that switches a tool of this kind without an `output`.
pub(crate) fn roles_of(word: &str) -> &'static [&'static str] {
    match word {
        "drill" => &["spindle"],
        "laser" => &["laser", "spindle"],
        _ => &[],
    }
}

impl Builder<'_> {
    pub(super) fn tool(&mut self, entry: &Entry, several: bool) {
        let Some(word) = entry.text("kind") else { return };
        if several && !entry.has("name") && !entry.is_spoilt(&["name"]) {
            self.wrong(
                "C003",
                entry.span.clone(),
                "missing `name` of a [[tool]]: there are several",
            );
        }
        let number = |key: &str| entry.number(key).unwrap_or(0.0);
        let time = |key: &str| us(number(key));
        let kind = match word.as_str() {
            "vacuum" => ToolKind::Vacuum(Vacuum {
                sealed_kpa: number("sealed_kpa"),
                open_kpa: number("open_kpa"),
                hold_kpa: number("hold_kpa"),
                build_us: number("build_ms") * 1000.0,
                vent_us: number("vent_ms") * 1000.0,
                leak_kpa_s: number("leak_kpa_s"),
                reach: number("reach"),
                gap: number("gap"),
                press: number("press"),
                hold_n: entry.number("hold_n"),
                input: entry.port("input"),
                on_kpa: number("on_kpa"),
                off_kpa: number("off_kpa"),
                analog: entry.port("analog"),
                volts: entry.numbers("volts").unwrap_or_default(),
                kpa: entry.numbers("kpa").unwrap_or_default(),
            }),
            "gripper" => ToolKind::Gripper(Gripper {
                opens: number("opens"),
                grips: entry.numbers("grips").unwrap_or_default(),
                along_x: entry.text("along").as_deref() == Some("x"),
                open_us: time("open_ms"),
                close_us: time("close_ms"),
                input_closed: entry.port("input_closed"),
                input_gripped: entry.port("input_gripped"),
            }),
            "drill" => ToolKind::Drill {
                diameter: number("diameter"),
                flute: entry.number("flute"),
                spin_us: time("spin_ms"),
                plunge_mm_s: entry.number("plunge_max_mm_min").map(|speed| speed / 60.0),
            },
            "dispenser" | "laser" | "pen" => ToolKind::Flow {
                flow_mg_s: number("flow_mg_s"),
                open_us: time("open_ms"),
                close_us: time("close_ms"),
                reach: number("reach"),
                width: number("width"),
            },
            "probe" => ToolKind::Probe {
                input: entry.port("input").or_else(|| self.names.with_role(Port::Input, "probe")),
                diameter: number("diameter"),
                delay_us: number("delay_us") as u64,
            },
            _ => ToolKind::None,
        };
        if let ToolKind::Vacuum(vacuum) = &kind {
            self.vacuum(entry, vacuum);
        }
        let output = self.switched_by(entry, &word);
        let body = entry
            .rows("body")
            .iter()
            .map(|row| Block::standing([row[0], row[1], row[2]], [row[3], row[4], row[5]]))
            .collect();
        self.scene.tools.push(Tool {
            name: entry.text("name").unwrap_or_else(|| word.clone()),
            kind,
            word,
            number: number("number") as u32,
            tip: entry.numbers("tip").unwrap_or_default(),
            body,
            output,
            turn: entry.axis("turn"),
        });
    }

    /// The output that switches a tool: the one that the file names, else the one with the role that fits.
    fn switched_by(&self, entry: &Entry, word: &str) -> Option<u32> {
        let roles = roles_of(word).iter();
        let by_role = || roles.clone().find_map(|role| self.names.with_role(Port::Output, role));
        entry.port("output").or_else(by_role)
    }

    /// Pressures that can never be reached, and levels that are the wrong way round.
    fn vacuum(&mut self, entry: &Entry, vacuum: &Vacuum) {
        let levels = [
            ("hold_kpa", vacuum.hold_kpa, "sealed_kpa", vacuum.sealed_kpa),
            ("on_kpa", vacuum.on_kpa, "sealed_kpa", vacuum.sealed_kpa),
            ("off_kpa", vacuum.off_kpa, "on_kpa", vacuum.on_kpa),
        ];
        for (key, least, other, most) in levels {
            if least > most {
                self.wrong(
                    "C004",
                    entry.span_of(key),
                    format!("`{key}` is {least}; it must not be above `{other}`, {most}"),
                );
            }
        }
        if vacuum.kpa[0] == vacuum.kpa[1] {
            let text = format!("`kpa` is {0} twice; its two pressures must differ", vacuum.kpa[0]);
            self.wrong("C004", entry.span_of("kpa"), text);
        } else if vacuum.analog.is_some() {
            let mv = [0.0, vacuum.sealed_kpa].map(|kpa| vacuum.volts_at(kpa) * 1000.0);
            if let Some(mv) = mv.into_iter().find(|mv| !(0.0..=MOST_MV).contains(mv)) {
                let text =
                    format!("`volts`: the sensor gives {mv:.0} mV; a pin has 0 to {MOST_MV} mV");
                self.problems.push(
                    Problem::warning("C004", entry.span_of("volts"), text)
                        .hint("what lies beyond is cut off by the pin: put a divider before it"),
                );
            }
        }
    }
}
