//! All boards behind gateways together: which there are, their state, and their differences.

use std::collections::HashMap;

use lang::profile::{BUILT_IN, Profile};
use lang::record::{BoardRecord, MachineRecord};
use lang::wire;
use serde::Serialize;

use crate::client::identity::differences as record_differences;
use crate::client::{Client, ClientError};
use crate::hall::known::Known;
use crate::link::{self, Link};

/// Which boards are meant: all that have one of the tags or one of the names; without any, all.
#[derive(Clone, Debug, Default)]
pub struct Choice {
    /// Tags.
    pub tags: Vec<String>,
    /// Names.
    pub boards: Vec<String>,
}

/// A board of the fleet.
#[derive(Clone, Debug)]
pub struct Member {
    /// Its gateway, `HOST:PORT`.
    pub gateway: String,
    /// What the gateway knows of it.
    pub known: Known,
}

/// What there is.
#[derive(Clone, Debug, Default)]
pub struct Found {
    /// Boards that are meant, gateway by gateway.
    pub members: Vec<Member>,
    /// Gateways that do not tell, each with the reason.
    pub missing: Vec<String>,
}

/// How a board stands; what is compared is text.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Standing {
    /// Why nothing is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<String>,
    /// What it does.
    pub state: &'static str,
    /// Its fault, in words.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fault: Option<String>,
    /// Version of the firmware, its instruction set and its features.
    pub firmware: String,
    /// CRC of its program, or `none`.
    pub program: String,
    /// The program's script, when the gateway was told.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub script: Option<String>,
    /// Name of its profile when it is a built-in one, otherwise a number for its content.
    pub profile: String,
}

/// The text of a column.
type Column = fn(&Standing) -> &str;

/// What is compared: the column's name, and its text.
const COMPARED: [(&str, Column); 3] = [
    ("firmware", |standing| &standing.firmware),
    ("program", |standing| &standing.program),
    ("profile", |standing| &standing.profile),
];

impl Choice {
    /// Whether nobody is left out.
    pub fn is_everyone(&self) -> bool {
        self.tags.is_empty() && self.boards.is_empty()
    }

    /// Whether a board is meant.
    pub fn holds(&self, known: &Known) -> bool {
        self.is_everyone()
            || self.boards.contains(&known.board)
            || known.tags.iter().any(|tag| self.tags.contains(tag))
    }
}

impl Member {
    /// A way to the board.
    ///
    /// # Errors
    /// The gateway is not there; in words.
    pub fn link(&self) -> Result<Box<dyn Link>, String> {
        link::open(&format!("tcp:{}", self.gateway))
    }
}

/// Asks gateways for their boards.
///
/// # Errors
/// None of the gateways answers; in words.
pub fn members(gateways: &[String], choice: &Choice) -> Result<Found, String> {
    let mut found = Found::default();
    for gateway in gateways {
        let hall = link::open(&format!("tcp:{gateway}")).and_then(|link| {
            let told = Client::new(link, 1).hall();
            told.map_err(|error| format!("{gateway} is no gateway of this version: {error}"))
        });
        match hall {
            Ok(hall) => {
                let meant = hall.into_iter().filter(|known| choice.holds(known));
                let gateway = gateway.clone();
                found.members.extend(meant.map(|known| Member { gateway: gateway.clone(), known }));
            }
            Err(why) => found.missing.push(why),
        }
    }
    if found.members.is_empty() && !found.missing.is_empty() {
        return Err(found.missing.join("; "));
    }
    Ok(found)
}

/// The name of a built-in profile that a board has, otherwise a number for what it has.
fn profile(record: &BoardRecord, machine: Option<u16>) -> String {
    // How a board hangs on its line is no matter of its machine.
    let same = |profile: &Profile| {
        let differ = record_differences(record, &BoardRecord::of(profile, record.sequence));
        differ.iter().all(|what| *what == "link")
            && machine.is_none_or(|hash| hash == MachineRecord::of(profile).hash())
    };
    let known = BUILT_IN.iter().filter_map(|(name, _)| Profile::built_in(name).ok());
    let fits: Vec<Profile> = known.filter(same).collect();
    if let [only] = &fits[..] {
        return only.name.clone();
    }
    let plain = BoardRecord { sequence: 0, crc: 0, address: 0, rate: 0, lock: [0; 2], ..*record };
    let bytes = plain.to_bytes();
    let crc = bytes.iter().fold(wire::CRC_START, |crc, byte| wire::crc16(crc, *byte));
    match machine {
        Some(hash) => format!("{crc:04X}-{hash:04X}"),
        None => format!("{crc:04X}"),
    }
}

impl Standing {
    /// Nothing is known, and why.
    pub fn missing(error: String) -> Standing {
        Standing { error: Some(error), ..Standing::default() }
    }

    /// Asks a board.
    ///
    /// # Errors
    /// See [`ClientError`].
    pub fn of<L: Link>(board: &mut Client<L>, known: &Known) -> Result<Standing, ClientError> {
        let (identity, status) = (board.identity()?, board.status()?);
        let has_program = identity.program_bytes > 0;
        let machine = match has_program {
            true => Some(board.holding(wire::PROGRAM_PROFILE, 1)?[0]),
            false => None,
        };
        let profile = match board.board_record() {
            Ok(record) => profile(&record, machine),
            Err(ClientError::Locked) => "locked".to_owned(),
            Err(error) => return Err(error),
        };
        let told = known.program.as_ref().filter(|program| program.crc == identity.program_crc);
        let fault = status.fault.as_ref().map(|fault| {
            let line = status.line.or_else(|| told?.line(status.fault_pc));
            let line = line.map_or(String::new(), |line| format!(", line {line}"));
            format!("{fault} {}{line}", status.text.unwrap_or_default())
        });
        Ok(Standing {
            error: None,
            state: status.state,
            fault,
            firmware: format!(
                "{} {:04X}-{:X}",
                identity.firmware, identity.instruction_set, identity.features
            ),
            program: if has_program {
                format!("{:04X}", identity.program_crc)
            } else {
                "none".to_owned()
            },
            script: told.filter(|_| has_program).map(|program| program.script.clone()),
            profile,
        })
    }
}

/// In what each board differs from most of them; boards that cannot be seen do not count.
pub fn differences(standings: &[Standing]) -> Vec<Vec<&'static str>> {
    let mut differ = vec![Vec::new(); standings.len()];
    for (name, of) in COMPARED {
        let mut counts: HashMap<&str, usize> = HashMap::new();
        let seen = || standings.iter().filter(|standing| standing.error.is_none());
        seen().for_each(|standing| *counts.entry(of(standing)).or_default() += 1);
        // Of two that are as many, the one that comes first is what is usual.
        let most = counts.values().copied().max().unwrap_or(0);
        let usual = seen().map(of).find(|text| counts[text] == most);
        for (standing, list) in standings.iter().zip(&mut differ) {
            if standing.error.is_none() && Some(of(standing)) != usual {
                list.push(name);
            }
        }
    }
    differ
}

/// The table for people; what differs from most boards has a star.
pub fn table(members: &[Member], standings: &[Standing], differ: &[Vec<&str>]) -> String {
    let head = ["board", "gateway", "state", "firmware", "program", "profile"];
    let mut rows = vec![head.map(str::to_owned)];
    for ((member, standing), differs) in members.iter().zip(standings).zip(differ) {
        let starred = |name: &str, text: &str| {
            format!("{text}{}", if differs.contains(&name) { " *" } else { "" })
        };
        let script = standing.script.as_ref().map_or(String::new(), |name| format!(" {name}"));
        let state = standing.fault.as_deref().unwrap_or(standing.state);
        rows.push([
            member.known.board.clone(),
            format!("{}/{}", member.gateway, member.known.unit),
            standing.error.as_deref().unwrap_or(state).to_owned(),
            starred("firmware", &standing.firmware),
            starred("program", &format!("{}{script}", standing.program)),
            starred("profile", &standing.profile),
        ]);
    }
    let wide =
        |column: usize| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..head.len()).map(wide).collect();
    let mut text = String::new();
    for row in &rows {
        let cells = row.iter().zip(&widths).map(|(cell, width)| format!("{cell:width$}"));
        text += cells.collect::<Vec<_>>().join("  ").trim_end();
        text.push('\n');
    }
    if differ.iter().any(|list| !list.is_empty()) {
        text += "* not what most of these boards have\n";
    }
    text
}

#[cfg(test)]
mod tests {
    use super::{Choice, Member, Standing, differences, profile, table};
    use crate::hall::known::Known;
    use lang::profile::Profile;
    use lang::record::{BoardRecord, MachineRecord};

    fn standing(firmware: &str, program: &str) -> Standing {
        let (firmware, program) = (firmware.to_owned(), program.to_owned());
        Standing {
            state: "ready",
            firmware,
            program,
            profile: "mill".into(),
            ..Standing::default()
        }
    }

    #[test]
    fn what_few_boards_have_is_what_differs() {
        let all = [
            standing("1.3", "7F21"),
            standing("1.2", "7F21"),
            Standing::missing("gone".to_owned()),
            standing("1.3", "none"),
        ];
        let differ = differences(&all);
        assert_eq!(differ, [vec![], vec!["firmware"], vec![], vec!["program"]]);
        let member = |board: &str| {
            let known = Known { board: board.to_owned(), unit: 3, ..Known::default() };
            Member { gateway: "hall:1502".to_owned(), known }
        };
        let members = ["drill", "saw", "feeder", "press"].map(member);
        let text = table(&members, &all, &differ);
        let lines: Vec<&str> = text.lines().collect();
        assert!(lines[2].starts_with("saw     hall:1502/3  ready  1.2 *"), "{text}");
        assert!(lines[3].contains("gone") && lines[4].contains("none *"), "{text}");
        assert_eq!(lines.len(), 6);
    }

    #[test]
    fn boards_are_meant_by_any_tag_or_their_name() {
        let known = |board: &str, tags: &[&str]| Known {
            board: board.to_owned(),
            tags: tags.iter().map(|tag| (*tag).to_owned()).collect(),
            ..Known::default()
        };
        let choice = Choice { tags: vec!["hall".into(), "wet".into()], boards: vec!["saw".into()] };
        assert!(choice.holds(&known("a", &["wet", "old"])));
        assert!(choice.holds(&known("saw", &[])));
        assert!(!choice.holds(&known("b", &["old"])));
        assert!(Choice::default().holds(&known("b", &[])));
    }

    #[test]
    fn a_profile_is_told_by_name_or_number() {
        let of = |name: &str| Profile::built_in(name).expect("built in");
        let record = |name: &str| BoardRecord::of(&of(name), 7);
        let machine = |name: &str| Some(MachineRecord::of(&of(name)).hash());
        assert_eq!(profile(&record("charly"), machine("charly")), "charly");
        let other = profile(&record("charly"), Some(1));
        assert!(other.ends_with("-0001") && other.len() == 9, "{other}");
        let address = BoardRecord { address: 9, sequence: 1, crc: 3, ..record("charly") };
        assert_eq!(profile(&address, Some(1)), other, "the line does not count");
    }
}
