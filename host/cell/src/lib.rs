//! A cell: the things around a machine, moved by what its axes and outputs do.
//!
//! [`read`] makes a [`scene::Scene`] of a `.cell.toml` file. All keys stand in one table, [`keys`]; whatever a file
//! says wrongly becomes a [`problem::Problem`] with its place and remedy.
//!
//! ```
//! # struct Mill;
//! # impl cell::Names for Mill {
//! #     fn input(&self, _: &str) -> Option<u32> { None }
//! #     fn output(&self, name: &str) -> Option<u32> { (name == "pump").then_some(3) }
//! #     fn analog(&self, _: &str) -> Option<u32> { None }
//! #     fn counter(&self, _: &str) -> Option<u32> { None }
//! #     fn known(&self, _: cell::Port) -> Vec<String> { vec!["pump".to_owned()] }
//! #     fn profile(&self) -> &str { "mill" }
//! #     fn has_analog(&self) -> bool { true }
//! #     fn has(&self, _: cell::Port, _: u32) -> bool { true }
//! #     fn axes(&self) -> &str { "XYZ" }
//! # }
//! let text = "cell = 1\n[[tool]]\nkind = \"vacuum\"\noutput = \"pumpe\"\n";
//! let problems = cell::read(text, &Mill, &|_| None, &|_| Err(String::new())).unwrap_err();
//! assert_eq!(
//!     problems[0].render("job.cell.toml", text),
//!     "job.cell.toml:4:10: error[C006]: output \"pumpe\": the profile \"mill\" has outputs pump; or a number\n  \
//!      hint: \"pump\" is meant?\n"
//! );
//! ```

pub mod build;
pub mod check;
pub mod form;
pub mod judge;
pub mod kernel;
pub mod keys;
pub mod law;
pub mod list;
pub mod log;
pub mod pressure;
pub mod problem;
pub mod region;
pub mod scene;
pub mod things;
pub mod vary;

mod read;
mod source;
mod value;

pub use read::{Names, Port};
pub use value::Entry;

/// Reads and checks a cell file. `names` and `travel` are the profile's; `files` reads what the cell names.
///
/// # Errors
/// All problems, when one of them is an error; else the warnings come with the scene.
pub fn read(
    text: &str,
    names: &dyn Names,
    travel: check::Travel<'_>,
    files: build::Files<'_>,
) -> Result<(scene::Scene, Vec<problem::Problem>), Vec<problem::Problem>> {
    let mut problems = Vec::new();
    let sources = source::Sources::gather(text, files, &mut problems);
    let named = |mut problems: Vec<problem::Problem>| {
        sources.name(&mut problems);
        problems
    };
    let scene = match build::scene(&sources, names, files) {
        Ok((scene, own)) => {
            problems.extend(own);
            scene
        }
        Err(own) => {
            problems.extend(own);
            return Err(named(problems));
        }
    };
    problems.extend(check::check(&scene, &sources.text, names.profile(), travel));
    // What has no effect is told of a file that is right else.
    if problems.iter().all(|problem| !problem.error) {
        problems.extend(check::inert(&scene, &sources.text, names.profile()));
    }
    let problems = named(problems);
    if problems.iter().any(|problem| problem.error) { Err(problems) } else { Ok((scene, problems)) }
}
