//! Cells of several files, and ports that a machine lacks.

#[expect(dead_code, reason = "the machine is for whole runs; here its names are enough")]
mod machine;

use cell::scene::Scene;
use machine::Plain;

fn files(name: &str) -> Result<String, String> {
    let text = match name {
        "wrong.cell.toml" => {
            "cell = 1\ntable = 3\n# a slip\npart = [{ name = \"pin\", size = [1, 0, 1] }]\n"
        }
        "parts.cell.toml" => {
            "cell = 1\ninclude = [\"more.cell.toml\"]\npart = [{ name = \"pin\", size = [1, 1, 1] }]\n"
        }
        // It includes what includes it.
        "more.cell.toml" => {
            "cell = 1\ninclude = [\"parts.cell.toml\"]\n\nplace = [{ name = \"far\", at = [0, 260, 0], size = [9, 9, 9] }]\n"
        }
        "old.cell.toml" => "cell = 2\n",
        _ => return Err(format!("file \"{name}\" cannot be read")),
    };
    Ok(text.to_owned())
}

fn read(text: &str) -> (Option<Scene>, Vec<String>) {
    let travel = |axis: char| (axis == 'Y').then_some((0.0, 200.0));
    let (scene, problems) = match cell::read(text, &Plain, &travel, &files) {
        Ok((scene, problems)) => (Some(scene), problems),
        Err(problems) => (None, problems),
    };
    let said = problems.iter().map(|own| own.render("c", text).trim_end().replace('\n', " /"));
    (scene, said.collect())
}

fn said(lines: &str) -> Vec<String> {
    read(&format!("cell = 1\n{lines}")).1
}

/// What an included file says is told with its own name and places, and what it has is there.
#[test]
fn included_files_add_their_things() {
    let include = |name: &str| format!("include = [\"{name}.cell.toml\"]\n");
    assert_eq!(
        said(&include("wrong")),
        [
            "wrong.cell.toml:2:9: warning[C016]: `table` of an included file has no effect /  hint: write it into the file that includes this one",
            "wrong.cell.toml:4:32: error[C004]: `size` of [part] has 0; each must be above 0",
        ]
    );
    assert_eq!(
        said(&include("old")),
        ["old.cell.toml:1:8: error[C013]: this cell is of version 2; this program reads 1"]
    );
    let feeder = "feeder = [{ name = \"tray\", part = \"pin\", at = [9, 9, 0] }]\n";
    let (scene, said_of) = read(&format!("cell = 1\n{}{feeder}", include("parts")));
    assert_eq!(
        said_of,
        [
            "more.cell.toml:4:19: warning[C008]: place \"far\" lies outside the travel: Y 260, the profile \"plain\" ends at 200"
        ]
    );
    let scene = scene.unwrap();
    assert_eq!((scene.parts.len(), scene.places.len(), scene.table), (1, 1, None));
    // A name is one in all files together.
    let twice = "place = [{ name = \"pin\", at = [0, 0, 0], size = [9, 9, 9] }]\n";
    let twice = said(&(include("parts") + twice));
    assert!(
        twice.iter().any(|said| said.contains("error[C005]: two things are named \"pin\"")),
        "{twice:?}"
    );
}

#[test]
fn counters_and_analog_inputs_that_are_not_there_are_refused() {
    for (lines, words) in [
        (
            "conveyor = [{ name = \"belt\", at = [0, 0, 0], size = [90, 9, 9], mm_s = 5, counter = 1, counts_mm = 10 }]\n",
            "c:2:85: error[C014]: no part has counters yet",
        ),
        (
            "sensor = [{ name = \"eye\", kind = \"distance\", from = [0, 0, 0], to = [9, 0, 0], analog = 7 }]\n",
            "error[C006]: the profile \"plain\" has no analog input 7 /  hint: write `[[analog]]`",
        ),
        (
            "tool = [{ kind = \"vacuum\", analog = 1, volts = [0, 9] }]\n",
            "warning[C004]: `volts`: the sensor gives 5400 mV; a pin has 0 to 3300 mV",
        ),
    ] {
        let said = said(lines);
        assert!(said[0].contains(words), "{said:?}");
    }
}
