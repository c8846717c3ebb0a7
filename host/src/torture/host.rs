//! The desktop's side: text, images, foreign files, profiles, worlds and a board that lies. Nothing
//! of it crashes or hangs the tool. The bodies are those of the fuzz targets in `host/fuzz`.

mod liar;

use std::time::{Duration, Instant};

use emulator::Rng;
use lang::back::disasm;
use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};
use lang::image::{Image, seal};
use lang::profile::{BUILT_IN, Profile};

use super::images::judge;
use super::registers;
use super::{Row, Settings, Sink, Verdict};
use crate::sim::world::{Registers, World};

pub use liar::client_replies;

/// What is done with some bytes; the error is what the tool must not do.
pub type Body = fn(&[u8]) -> Result<(), String>;

/// Every body by the name of its fuzz target, with inputs to begin with.
pub const BODIES: [(&str, Body, &[&[u8]]); 7] = [
    (
        "source_to_image",
        source_to_image,
        &[
            include_bytes!("../../../examples/dil14.bas"),
            include_bytes!("../../../examples/two_hand.bas"),
            include_bytes!("../../../examples/pick_place.bas"),
        ],
    ),
    ("image_decoder", image_decoder, &[]),
    (
        "import_formats",
        import_formats,
        &[
            include_bytes!("../../../examples/import/tour.isel"),
            include_bytes!("../../../examples/import/dil14_listing.lst"),
            include_bytes!("../../../examples/import/plate.pal"),
            include_bytes!("../../../examples/import/corner.cde"),
            include_bytes!("../../../examples/import/board.ngc"),
            include_bytes!("../../../examples/import/drill.drl"),
        ],
    ),
    ("client_replies", client_replies, &[]),
    ("registers", registers::storm, &[]),
    ("profile_file", profile_file, &[BUILT_IN[0].1.as_bytes(), BUILT_IN[1].1.as_bytes()]),
    (
        "world_file",
        world_file,
        &[
            include_bytes!("../../../examples/dil14.rhai"),
            include_bytes!("../../../examples/two_hand.rhai"),
        ],
    ),
];

/// Longest time of one input: a development build on a busy computer.
pub const PATIENCE: Duration = Duration::from_secs(20);
/// Longest input.
const LONGEST: usize = 6_000;
/// Simulated time of a world, us.
const WORLD_US: u64 = 10_000_000;

/// A text as a script: compiled, and its image accepted by the verifier that the board has.
///
/// # Errors
/// The image of a script that the compiler takes is refused.
pub fn source_to_image(data: &[u8]) -> Result<(), String> {
    let text = String::from_utf8_lossy(data).into_owned();
    let source = Source::new("fuzz.bas", text);
    let (program, diags) = compile(&source, ProfileChoice::built_in());
    diags.render(&source);
    let Some(program) = program else { return Ok(()) };
    let Ok(compiled) = lang::back::compile(&program) else { return Ok(()) };
    let image = Image::new(&compiled.image).map_err(|flaw| format!("no image: {flaw:?}"))?;
    match image.header.wide() || judge::is_accepted(&compiled.image) {
        true => Ok(()),
        false => Err("the verifier refuses what the compiler made".to_owned()),
    }
}

/// Bytes as an image: listed, and if they are accepted, run.
///
/// # Errors
/// What an accepted image did that none may.
pub fn image_decoder(data: &[u8]) -> Result<(), String> {
    let mut image = data.to_vec();
    for _ in 0..2 {
        if let Ok(read) = Image::new(&image) {
            disasm::listing(&read, None);
        }
        judge::try_out(&image, &mut Rng::new(1))?;
        seal(&mut image);
    }
    Ok(())
}

/// Bytes as a file of another system: a script that the compiler knows, or diagnostics.
///
/// # Errors
/// The file is refused without a word.
pub fn import_formats(data: &[u8]) -> Result<(), String> {
    match import::import("fuzz", data, &import::Options::default()) {
        Err(diags) if diags.is_empty() => Err("refused without a word".to_owned()),
        _ => Ok(()),
    }
}

/// A text as a profile.
///
/// # Errors
/// Never: a profile is taken or refused.
pub fn profile_file(data: &[u8]) -> Result<(), String> {
    match Profile::parse(&String::from_utf8_lossy(data)) {
        Ok(profile) if profile.name.is_empty() => Err("a profile without a name".to_owned()),
        Ok(_) => Ok(()),
        Err(error) if error.to_string().is_empty() => Err("refused without a word".to_owned()),
        Err(_) => Ok(()),
    }
}

/// A text as a world, run for a while.
///
/// # Errors
/// Never: a world runs or says what is wrong.
pub fn world_file(data: &[u8]) -> Result<(), String> {
    let Ok(world) = World::parse("fuzz.rhai", &String::from_utf8_lossy(data)) else {
        return Ok(());
    };
    let Ok(mut scenario) = world.start(&Registers::default()) else { return Ok(()) };
    for _ in 0..200 {
        match scenario.next_us() {
            Some(us) if us < WORLD_US => {
                if scenario.advance(us).is_err() {
                    return Ok(());
                }
            }
            _ => break,
        }
    }
    Ok(())
}

/// Pieces that go where they hurt.
const PIECES: [&str; 24] = [
    "99999999999999999999",
    "-",
    "(",
    ")",
    "\"",
    "'",
    "\0",
    "\u{e9}",
    "{",
    "}",
    "[",
    "]",
    "1e9",
    "G2 X1 R-1\n",
    "SUB a(b)\n",
    "END SUB\n",
    "FOR i = 1 TO 3\n",
    "NEXT\n",
    "CONST A = A\n",
    "DIM a(99999)\n",
    "while true {}",
    "loop { at(1, || 1) }",
    "= ",
    ",,,,",
];

/// An input with some damage.
fn damaged(rng: &mut Rng, seeds: &[&[u8]]) -> Vec<u8> {
    let seed = seeds.get(rng.below(seeds.len() as u64) as usize).copied().unwrap_or_default();
    let mut data = seed.to_vec();
    for _ in 0..1 + rng.below(6) {
        let at = rng.below(data.len() as u64 + 1) as usize;
        let end = (at + rng.below(60) as usize).min(data.len());
        match rng.below(6) {
            0 => data.truncate(at),
            1 => drop(data.drain(at..end)),
            2 => {
                let piece = data[at..end].to_vec();
                let times = 1 + rng.below(40) as usize;
                data.splice(at..at, piece.repeat(times));
            }
            3 => {
                let piece = PIECES[rng.below(PIECES.len() as u64) as usize];
                data.splice(at..at, piece.bytes());
            }
            4 => data
                .splice(at..at, (0..rng.below(20)).map(|_| 0).collect::<Vec<_>>())
                .for_each(drop),
            _ => {
                if let Some(byte) = data.get_mut(at) {
                    *byte = rng.bits() as u8;
                }
            }
        }
        data.truncate(LONGEST);
    }
    if seeds.is_empty() {
        data = (0..rng.below(600)).map(|_| rng.bits() as u8).collect();
    }
    data
}

/// Runs a body on an input, and says when it took too long.
///
/// # Errors
/// What the tool must not do.
pub fn timed(body: Body, data: &[u8], patience: Duration) -> Result<(), String> {
    let began = Instant::now();
    body(data)?;
    match began.elapsed() {
        taken if taken < patience => Ok(()),
        taken => Err(format!("it took {} s", taken.as_secs_f32())),
    }
}

/// A body on damaged inputs.
pub fn against(
    settings: &Settings,
    fault: &'static str,
    body: Body,
    seeds: &[&[u8]],
    patience: Duration,
) -> Row {
    let mut row = Row::new("host", fault, settings);
    row.run(settings, settings.count(300, 5_000, 100_000), |n| {
        let data = damaged(&mut settings.rng(fault, n), seeds);
        match timed(body, &data, patience) {
            Ok(()) => Verdict::Survived,
            Err(text) => Verdict::Lost(format!("{text}:\n{}", String::from_utf8_lossy(&data))),
        }
    });
    row
}

/// Hostile inputs.
///
/// # Errors
/// The table cannot be written.
pub fn run(settings: &Settings, sink: Sink<'_>) -> Result<(), String> {
    for (fault, body, seeds) in BODIES {
        sink(against(settings, fault, body, seeds, PATIENCE))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::{BODIES, PATIENCE, timed};

    #[test]
    fn what_the_fuzzers_found_worth_keeping_holds() {
        for (name, body, _) in BODIES {
            let folder = format!("{}/fuzz/seeds/{name}", env!("CARGO_MANIFEST_DIR"));
            let mut seeds = 0;
            for entry in std::fs::read_dir(&folder).expect("the target has seeds") {
                let path = entry.expect("a file").path();
                let data = std::fs::read(&path).expect("a file");
                assert_eq!(timed(body, &data, PATIENCE), Ok(()), "{}", path.display());
                seeds += 1;
            }
            assert!(seeds > 5, "{seeds} seeds in {folder}");
        }
    }
}
