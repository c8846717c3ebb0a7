//! `pasapas engrave`: a picture or a drawing becomes a laser's job.

use std::path::Path;

use clap::{Args, ValueEnum};
use lang::profile::Profile;
use serde_json::json;
use shop::Wrong;
use shop::engrave::dither::Dither;
use shop::engrave::picture::{self, Kind};
use shop::engrave::raster::{self, raster};
use shop::engrave::trace::{self, trace};
use shop::engrave::{Form, Job, Laser, MAX_BYTES, write};

use super::console::{Console, Options};
use super::paste::note;
use crate::failure::Failure;
use crate::input;
use crate::output;

/// The profile that is taken without `--profile`.
const PROFILE: &str = "laser";

/// `pasapas engrave`
#[derive(Debug, Args)]
pub struct Engrave {
    /// A PNG or JPEG picture, or an SVG drawing with --trace
    picture: String,
    /// Width on the work: 80mm; the height follows
    #[arg(long, value_name = "WIDTH", allow_hyphen_values = true, value_parser = length)]
    size: f64,
    /// Lines of a mm, and dots of a line's mm
    #[arg(long, value_name = "N", default_value_t = 10.0, value_parser = lines)]
    lines: f64,
    /// How greys are shown
    #[arg(long, value_enum, value_name = "KIND", default_value_t = Shown::FloydSteinberg)]
    dither: Shown,
    /// Follow the paths of a drawing
    #[arg(long)]
    trace: bool,
    /// Where the lower left corner lies, mm: 10,10
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true, value_parser = place)]
    at: Option<[f64; 2]>,
    /// mm/min
    #[arg(long, value_name = "F", default_value_t = 3000, value_parser = clap::value_parser!(u32).range(1..=60_000))]
    feed: u32,
    /// S of black, and of a traced line; without it full power
    #[arg(long, value_name = "S", value_parser = clap::value_parser!(u32).range(1..=32_767))]
    power: Option<u32>,
    /// Run-up before and behind each line: 3mm; without it what the ramp needs
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true, value_parser = length)]
    overscan: Option<f64>,
    /// Begin every line at the left
    #[arg(long)]
    one_way: bool,
    /// Move lines to the left by so much in X, for the play of a belt: 0.05mm
    #[arg(long, value_name = "LENGTH", default_value = "0mm", allow_hyphen_values = true, value_parser = offset)]
    offset: f64,
    /// The job: a script, or G-code for a name that ends in .nc, .gco or .gcode; without it a script on standard
    /// output
    #[arg(short, long, value_name = "JOB")]
    output: Option<String>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Shown {
    /// Darker than the middle is burnt
    None,
    /// For photos
    FloydSteinberg,
    /// For photos with light parts
    Atkinson,
    /// A pattern of 8 x 8
    Bayer,
    /// Power by the grey, 16 steps
    Power,
}

/// `80mm`, `80`, `3in`: mm.
fn length(text: &str) -> Result<f64, String> {
    offset(text).ok().filter(|mm| (0.1..=10_000.0).contains(mm)).ok_or_else(|| {
        format!("`{text}` is no size: write a length of 0.1mm to 10000mm, such as 80mm or 3in")
    })
}

fn offset(text: &str) -> Result<f64, String> {
    let text = text.trim();
    let (number, unit) = [("mm", 1.0), ("cm", 10.0), ("in", 25.4)]
        .into_iter()
        .find_map(|(unit, mm)| Some((text.strip_suffix(unit)?, mm)))
        .unwrap_or((text, 1.0));
    let mm = number.trim().parse::<f64>().ok().map(|number| number * unit);
    mm.filter(|mm| mm.abs() <= 10_000.0)
        .ok_or_else(|| format!("`{text}` is no length: write mm, such as 0.05mm"))
}

fn lines(text: &str) -> Result<f64, String> {
    let lines = text.trim().parse::<f64>().ok().filter(|n| (0.5..=50.0).contains(n));
    lines.ok_or_else(|| "a mm has 0.5 to 50 lines".to_owned())
}

fn place(text: &str) -> Result<[f64; 2], String> {
    let (x, y) =
        text.split_once(',').ok_or("write X and Y in mm with a comma between them: 10,10")?;
    Ok([offset(x)?, offset(y)?])
}

impl Engrave {
    /// Reads the picture and writes the job.
    ///
    /// # Errors
    /// The picture is wrong or does not fit the machine; that was written.
    pub fn run(&self, options: &Options, console: &Console) -> Result<(), Failure> {
        let inputs = [Some(Path::new(&self.picture))];
        output::keep_inputs(&[("-o", self.output.as_ref())], &inputs)?;
        let profile = match options.profile(console)? {
            Some(profile) => profile,
            None => {
                Profile::built_in(PROFILE).map_err(|error| Failure::Usage(error.to_string()))?
            }
        };
        let laser = Laser::of(&profile).map_err(Failure::Usage)?;
        let bytes =
            input::read_bytes(&self.picture, MAX_BYTES).map_err(|note| console.refuse(&note))?;
        let refuse = |wrong: Wrong| console.refuse(&note(&self.picture, "X036", &wrong));
        let (job, form) = (self.job(&bytes, &laser).map_err(refuse)?, self.form());
        let speed = f64::from(self.feed) / 60.0;
        let text = write(&job, form, &laser, speed, (profile.name.as_str(), self.picture.as_str()))
            .map_err(refuse)?;
        match &self.output {
            Some(path) => output::write(path, text.as_bytes())?,
            None => console.result(&text)?,
        }
        self.tell(&job, &text, speed, console)
    }

    fn form(&self) -> Form {
        let name = self.output.as_deref().unwrap_or_default().to_lowercase();
        let gcode = [".nc", ".gco", ".gcode", ".gc", ".ngc"].iter().any(|end| name.ends_with(end));
        if gcode { Form::Gcode } else { Form::Script }
    }

    fn job(&self, bytes: &[u8], laser: &Laser) -> Result<Job, Wrong> {
        let power = self.power.unwrap_or(laser.full);
        if power > laser.full {
            let words = format!("--power {power}; S{} is full power", laser.full);
            return Err(Wrong::whole(words, "a smaller --power"));
        }
        if self.trace {
            if picture::kind(bytes) != Some(Kind::Svg) {
                let words = "--trace follows the paths of an SVG, and this is none";
                return Err(Wrong::whole(words, "without --trace a picture is burnt in lines"));
            }
            return trace(bytes, &trace::Wish { size: self.size, at: self.at, power }, laser);
        }
        if picture::kind(bytes) == Some(Kind::Svg) {
            let words = "an SVG is a drawing, no picture";
            return Err(Wrong::whole(
                words,
                "--trace follows its paths; to burn it in lines, save it as PNG",
            ));
        }
        let wish = raster::Wish {
            size: self.size,
            lines: self.lines,
            dither: match self.dither {
                Shown::None => Dither::None,
                Shown::FloydSteinberg => Dither::FloydSteinberg,
                Shown::Atkinson => Dither::Atkinson,
                Shown::Bayer => Dither::Bayer,
                Shown::Power => Dither::Power,
            },
            at: self.at,
            overscan: self.overscan,
            speed: f64::from(self.feed) / 60.0,
            power,
            one_way: self.one_way,
            offset: self.offset,
        };
        raster(&picture::decode(bytes)?, &wish, laser)
    }

    /// What the job is, and where it fits.
    fn tell(&self, job: &Job, text: &str, speed: f64, console: &Console) -> Result<(), Failure> {
        let burnt = job.way(|step| step.power.is_some_and(|power| power > 0));
        let dark = job.way(|step| step.power == Some(0));
        let lines = text.lines().count();
        if console.json() {
            return match &self.output {
                Some(_) => console.json_line(&json!({
                    "lines": lines, "burnt_mm": burnt.round(), "dark_mm": dark.round(),
                    "seconds": job.seconds(speed).round(),
                })),
                None => Ok(()),
            };
        }
        let minutes = job.seconds(speed) / 60.0;
        console.complain(&format!(
            "{}\n{lines} lines, {:.1} m burnt, {:.1} m dark at that speed; {minutes:.1} min or more",
            job.head.join("; "),
            burnt / 1000.0,
            dark / 1000.0
        ));
        let name = self.output.as_deref().unwrap_or("JOB");
        console.complain(&format!(
            "`pasapas stream {name}` runs it; `pasapas build` tells whether it fits the board"
        ));
        Ok(())
    }
}
