//! `pasapas fleet` over two gateways with three boards of the real firmware.

mod common;

use common::{Board, Gateway, pasapas, text};
use serde_json::Value;

/// Boards, their gateways, and the option that names these.
struct Hall {
    boards: [Board; 3],
    gateways: Vec<Gateway>,
    option: String,
}

const GOOD: &str = "KEEP made\nDIM deep AS LENGTH\nmade = made + 1\nSetOut 2, ON\nWait 60s\n";
const FAILS: &str = "DIM a\nWait 50ms\nPRINT 1 / a\n";

impl Hall {
    fn start() -> Hall {
        let small = ["--part", "g2553"];
        let boards =
            [Board::start(&small), Board::start(&small), Board::start(&["--part", "f5529"])];
        let port = |n: usize| text(&boards[n].port()).to_owned();
        let board = |name: &str, n: usize, unit: u8, tags: &str| {
            format!(
                "[[board]]\nname = \"{name}\"\nport = {:?}\nunit = {unit}\ntags = [{tags}]\n",
                port(n)
            )
        };
        let rights = "[[client]]\nfrom = \"127.0.0.1\"\nwrite = [\"all\"]\n";
        let files = [
            format!(
                "names = \"hall.json\"\n{}{}{rights}",
                board("drill", 0, 1, "\"hall\", \"wet\""),
                board("saw", 1, 2, "\"hall\"")
            ),
            format!("{}{rights}", board("press", 2, 1, "\"yard\"")),
        ];
        let folder = boards[0].folder.path();
        let start = |(n, content): (usize, &String)| {
            let file = folder.join(format!("{n}.toml"));
            std::fs::write(&file, content).expect("a file");
            Gateway::start(&[text(&file)])
        };
        let gateways: Vec<Gateway> = files.iter().enumerate().map(start).collect();
        let places: Vec<String> =
            gateways.iter().map(|one| format!("127.0.0.1:{}", one.port)).collect();
        Hall { option: places.join(","), boards, gateways }
    }

    fn script(&self, name: &str, content: &str) -> String {
        let path = self.boards[0].folder.path().join(name);
        std::fs::write(&path, content).expect("a file");
        text(&path).to_owned()
    }

    fn fleet(&self, args: &[&str]) -> (i32, String) {
        pasapas(&[&["fleet"], args, &["--gateway", &self.option]].concat())
    }

    /// A board's line of the table.
    fn standing(&self, board: &str) -> Value {
        let (_, said) = self.fleet(&["status", "--format", "json"]);
        let lines = said.lines().filter_map(|line| serde_json::from_str::<Value>(line).ok());
        let mut lines = lines.filter(|line| line["board"] == board);
        lines.next().unwrap_or_else(|| panic!("no {board}: {said}"))
    }
}

#[test]
fn a_program_rolls_over_the_boards_with_a_tag_and_stops_at_the_first_fault() {
    let hall = Hall::start();
    let (good, fails) = (hall.script("good.bas", GOOD), hall.script("fails.bas", FAILS));
    let (code, said) = hall.fleet(&["upload", &good]);
    assert_eq!(code, 2, "whom it concerns must be said: {said}");
    let (code, said) = hall.fleet(&["upload", &good, "--tag", "hall"]);
    assert_eq!(code, 0, "{said}");
    assert!(said.contains("drill: uploaded") && said.contains("saw: uploaded"), "{said}");
    let (code, said) = hall.fleet(&["status"]);
    assert_eq!(code, 0, "{said}");
    let (drill, press) = (hall.standing("drill"), hall.standing("press"));
    assert_eq!((&drill["script"], &drill["profile"]), (&"good.bas".into(), &"mill".into()));
    assert_eq!(drill["differs"].as_array().map(Vec::len), Some(0), "{drill}");
    let differs = press["differs"].to_string();
    assert!(differs.contains("program") && differs.contains("firmware"), "{press}");

    // What fails on the first board does not get to the second.
    let before = hall.standing("saw")["program"].clone();
    let (code, said) = hall.fleet(&["upload", &fails, "--tag", "hall", "--replace", "--start"]);
    assert_eq!(code, 4, "{said}");
    assert!(said.contains("F02") && said.contains("left alone: saw"), "{said}");
    assert_eq!(hall.standing("saw")["program"], before);
    assert_eq!(hall.standing("drill")["state"], "fault");

    // It gets over its fault with a program that runs.
    let (code, said) =
        hall.fleet(&["upload", &good, "--tag", "wet,yard", "--replace", "--start", "--watch", "1"]);
    assert_eq!(code, 0, "{said}");
    for board in ["drill", "press"] {
        assert_eq!(hall.standing(board)["state"], "running");
    }
    // A running board is not stopped unless that is asked for.
    let (code, said) = hall.fleet(&["upload", &fails, "--board", "drill", "--replace"]);
    assert_eq!(code, 4, "{said}");
    assert_eq!(hall.standing("drill")["state"], "running");
    let (code, said) = hall.fleet(&["start", "--board", "saw"]);
    assert_eq!(code, 0, "{said}");

    // Another machine's board ends a roll.
    let (code, said) = hall.fleet(&["stop", "--all"]);
    assert_eq!(code, 0, "{said}");
    for board in ["drill", "saw", "press"] {
        assert_eq!(hall.standing(board)["state"], "ready");
    }
    let over = format!("tcp:127.0.0.1:{}", hall.gateways[0].port);
    let (code, said) = pasapas(&["profile", "set", "charly", "--port", &over]);
    assert_eq!(code, 0, "{said}");
    let (code, said) = hall.fleet(&["upload", &fails, "--tag", "hall", "--replace"]);
    assert_eq!(code, 4, "{said}");
    assert!(said.contains("profile is not `mill`") && said.contains("left alone: saw"), "{said}");
}

#[test]
fn what_can_be_reached_is_stopped_whatever_else_fails() {
    let mut hall = Hall::start();
    let good = hall.script("good.bas", GOOD);
    let (code, said) = hall.fleet(&["upload", &good, "--all", "--start", "--watch", "1"]);
    assert_eq!(code, 0, "{said}");
    hall.gateways.pop();
    let (code, said) = hall.fleet(&["start", "--all"]);
    assert_eq!(code, 4, "nothing is started by halves: {said}");
    let (code, said) = hall.fleet(&["stop", "--all"]);
    assert_eq!(code, 4, "{said}");
    assert!(said.contains("drill: stopped") && said.contains("saw: stopped"), "{said}");
    assert_eq!(hall.standing("saw")["state"], "ready");

    // The names of the program's variables went with it, over a gateway's end as well.
    let over = format!("tcp:127.0.0.1:{}", hall.gateways[0].port);
    let row = ",holding register,4000,int32,made,,1,true,KEEP variable of the script.";
    let (code, table) = pasapas(&["gateway", "--describe", "--port", &over]);
    assert_eq!(code, 0, "{table}");
    assert!(table.contains(&format!("drill,1{row}")) && table.contains(&format!("saw,2{row}")));
    hall.gateways.clear();
    let file = hall.boards[0].folder.path().join("0.toml");
    let (code, table) = pasapas(&["gateway", "--describe", text(&file)]);
    assert_eq!(code, 0, "{table}");
    assert!(table.contains(&format!("saw,2{row}")), "{table}");
}
