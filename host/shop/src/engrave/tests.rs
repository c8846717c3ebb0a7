use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};
use lang::profile::Profile;
use proptest::prelude::*;

use super::dither::{Dither, LEVELS};
use super::picture::{self, Picture};
use super::raster::{self, raster};
use super::trace::{self, trace};
use super::{Form, Job, Laser, write};

fn laser() -> Laser {
    Laser::of(&Profile::built_in("laser").expect("built in")).expect("a laser")
}

fn wish() -> raster::Wish {
    raster::Wish {
        size: 4.0,
        lines: 1.0,
        dither: Dither::None,
        at: None,
        overscan: None,
        speed: 50.0,
        power: 1000,
        one_way: false,
        offset: 0.0,
    }
}

fn picture(rows: &[&str]) -> Picture {
    let grey = |sign: char| match sign {
        '#' => 0,
        '+' => 100,
        _ => 255,
    };
    let greys = rows.iter().flat_map(|row| row.chars().map(grey)).collect();
    Picture { width: rows[0].len(), height: rows.len(), greys }
}

fn png(width: u32, height: u32, greys: &[u8]) -> Vec<u8> {
    let mut out = Vec::new();
    let mut encoder = png::Encoder::new(&mut out, width, height);
    encoder.set_color(png::ColorType::Grayscale);
    let mut writer = encoder.write_header().expect("a head");
    writer.write_image_data(greys).expect("pixels");
    writer.finish().expect("an end");
    out
}

/// The sum of a chunk of a PNG.
fn crc(bytes: &[u8]) -> u32 {
    let step = |sum: u32, _| if sum & 1 == 1 { (sum >> 1) ^ 0xEDB8_8320 } else { sum >> 1 };
    !bytes.iter().fold(!0, |sum, byte| (0..8).fold(sum ^ u32::from(*byte), step))
}

fn script(job: &Job) -> String {
    write(job, Form::Script, &laser(), 50.0, ("laser", "a.png")).expect("a script")
}

fn compiles(text: &str) {
    let source = Source::new("job", text.to_owned());
    let (program, found) = compile(&source, ProfileChoice::built_in());
    assert!(program.is_some(), "{}\n{text}", found.render(&source));
}

#[test]
fn rows_are_burnt_from_below_in_both_directions_with_a_run_up() {
    let job = raster(&picture(&["#..#", "....", "##.+"]), &wish(), &laser()).expect("a job");
    let text = script(&job);
    compiles(&text);
    insta::assert_snapshot!(text);
    let wish =
        raster::Wish { dither: Dither::Power, one_way: true, at: Some([9.0, 7.0]), ..wish() };
    let job = raster(&picture(&["#..#", "....", "##.+"]), &wish, &laser()).expect("a job");
    let text = write(&job, Form::Gcode, &laser(), 50.0, ("laser", "a.png")).expect("G-code");
    insta::assert_snapshot!(text);
}

#[test]
fn a_line_to_the_left_is_moved_by_the_offset() {
    let wish = raster::Wish { offset: 0.1, ..wish() };
    let job = raster(&picture(&["####", "####"]), &wish, &laser()).expect("a job");
    let lit: Vec<f64> =
        job.steps.iter().filter(|step| step.power == Some(1000)).map(|step| step.to[0]).collect();
    // From 3 mm on: the run-up of 2.5 mm in whole ones, and the offset.
    let near = |a: f64, b: f64| (a - b).abs() < 1e-9;
    assert!(near(lit[0], 3.1 + 4.0) && near(lit[1], 3.1 + 0.1), "{lit:?}");
}

#[test]
fn each_dither_shows_the_same_grey() {
    let grey = Picture { width: 64, height: 64, greys: vec![191; 64 * 64] };
    for (dither, wanted, more) in [
        (Dither::None, 0.0, 0.0),
        (Dither::FloydSteinberg, 0.251, 0.01),
        (Dither::Atkinson, 0.25, 0.12),
        (Dither::Bayer, 0.25, 0.005),
        (Dither::Power, 0.25, 0.001),
    ] {
        let levels = grey.levels(dither);
        let sum: u32 = levels.iter().map(|level| u32::from(*level)).sum();
        let part = f64::from(sum) / f64::from(LEVELS) / 4096.0;
        assert!((part - wanted).abs() <= more, "{dither:?}: {part}");
    }
}

#[test]
fn pictures_are_decoded_and_damaged_or_huge_ones_refused() {
    let small = png(2, 1, &[0, 255]);
    assert_eq!(picture::decode(&small).expect("a picture").greys, [0, 255]);
    let jpeg = include_bytes!("data/grey.jpg");
    let read = picture::decode(jpeg).expect("a picture");
    assert_eq!((read.width, read.height), (16, 8));
    assert!(read.greys[0] < 60 && read.greys[15] > 200, "{:?}", read.greys);
    // A picture of 20 000 x 20 000 pixels needs few bytes.
    let mut huge = png(1, 1, &[0]);
    huge[16..24].copy_from_slice(&[0, 0, 0x4E, 0x20, 0, 0, 0x4E, 0x20]);
    let sum = crc(&huge[12..29]).to_be_bytes();
    huge[29..33].copy_from_slice(&sum);
    let mut cut = png(64, 64, &(0..4096).map(|n| (n * 7919 % 251) as u8).collect::<Vec<_>>());
    cut.truncate(cut.len() / 2);
    for (bytes, words) in [
        (&huge[..], "20000 x 20000 pixels; at most 50 millions are read"),
        (&b"G0 X1"[..], "no PNG, JPEG or SVG"),
        (&cut, "the PNG cannot be read"),
        (&jpeg[..jpeg.len() / 2], "the JPEG cannot be read"),
        (&small[..20], "the PNG cannot be read"),
    ] {
        let wrong = picture::decode(bytes).expect_err(words);
        assert!(wrong.text.contains(words) && !wrong.hint.is_empty(), "{wrong:?}");
    }
}

#[test]
fn paths_are_followed_and_a_drawing_without_any_refused() {
    let wish = trace::Wish { size: 40.0, at: None, power: 300 };
    let svg = |body: &str| {
        format!("<svg xmlns='http://www.w3.org/2000/svg' width='20' height='10'>{body}</svg>")
    };
    let body = "<g transform='translate(1 1)'><rect x='1' y='1' width='4' height='2'/></g>\
                <path d='M10 5 C 10 2, 14 2, 14 5' fill='none' stroke='black'/>";
    let job = trace(svg(body).as_bytes(), &wish, &laser()).expect("a job");
    let text = script(&job);
    compiles(&text);
    insta::assert_snapshot!(text);
    let deep = format!("{}{}", "<g>".repeat(5000), "</g>".repeat(5000));
    for (body, words) in [
        ("<text x='1' y='5'>words</text>", "an SVG without paths"),
        ("<path d='M0 0 L1", "the SVG cannot be read"),
        (&deep, "deep in each other"),
        ("<path d='M0 0 L300 0' stroke='black'/>", "X goes from 0.000 to 600.000 mm"),
    ] {
        let wrong = trace(svg(body).as_bytes(), &wish, &laser()).expect_err(words);
        assert!(wrong.text.contains(words) && !wrong.hint.is_empty(), "{wrong:?}");
    }
}

#[test]
fn what_does_not_fit_or_shows_nothing_is_told() {
    let dark = picture(&["####"]);
    for (picture, wish, words) in [
        (&dark, raster::Wish { size: 400.0, ..wish() }, "X goes from 0.000 to 406.000 mm"),
        (&dark, raster::Wish { at: Some([0.0; 2]), ..wish() }, "X goes from -3.000"),
        (&dark, raster::Wish { size: 9000.0, lines: 50.0, ..wish() }, "dots are to be burnt"),
        (&picture(&["...."]), wish(), "nothing of the picture is dark"),
    ] {
        let wrong = raster(picture, &wish, &laser()).expect_err(words);
        assert!(wrong.text.contains(words) && !wrong.hint.is_empty(), "{wrong:?}");
    }
    let mill = Laser::of(&Profile::built_in("mill").expect("built in")).expect_err("no laser");
    assert!(mill.contains("--profile laser"), "{mill}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    /// What is burnt is as long as the dark pixels, each line runs up and out dark, and nothing leaves
    /// the machine.
    #[test]
    fn as_much_is_burnt_as_is_dark(
        width in 1usize..20,
        greys in prop::collection::vec(prop::bool::ANY, 1..200),
        one_way: bool,
    ) {
        let height = greys.len().div_ceil(width);
        let mut own: Vec<u8> = greys.iter().map(|dark| if *dark { 0 } else { 255 }).collect();
        own.resize(width * height, 255);
        let dark = own.iter().filter(|grey| **grey == 0).count();
        let picture = Picture { width, height, greys: own };
        let wish = raster::Wish { size: width as f64, one_way, ..wish() };
        let Ok(job) = raster(&picture, &wish, &laser()) else {
            prop_assert!(dark == 0 || height > 200);
            return Ok(());
        };
        let burnt = job.way(|step| step.power == Some(1000));
        prop_assert!((burnt - dark as f64).abs() < 1e-6, "{} {}", burnt, dark);
        for pair in job.steps.windows(2) {
            // Rapid moves begin and end dark.
            prop_assert!(pair[1].power.is_some() || pair[0].power == Some(0));
        }
        prop_assert_eq!(job.steps.last().and_then(|step| step.power), Some(0));
    }

    /// No bytes make the decoders panic.
    #[test]
    fn mutilated_pictures_are_read_or_refused(at in 0usize..2000, byte: u8, cut in 0usize..2000) {
        let greys: Vec<u8> = (0..1024).map(|n| (n * 31 % 256) as u8).collect();
        for mut bytes in [png(32, 32, &greys), include_bytes!("data/grey.jpg").to_vec()] {
            let count = bytes.len();
            bytes[at % count] = byte;
            bytes.truncate((cut % count).max(count / 2));
            let _ = picture::decode(&bytes);
        }
    }
}
