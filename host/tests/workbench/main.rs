//! The workbench in a real browser: each story does what a person does and asks the board what came
//! of it.
//!
//! Chromium is a package of the system; where it is missing the stories say so and pass, and CI
//! installs it. Pictures go to the folder that WORKBENCH_PICTURES names.
#![cfg(unix)]

mod attack;
mod cdp;
mod edit;
mod keyboard;
mod look;
mod machine;
mod measure;
mod numbers;
mod operator;
mod pattern;
mod plots;
mod pulses;
mod races;
mod run;
mod safety;
mod setup;
mod site;
mod stand;
mod streamed;
mod teach;
mod timeline;
mod writing;
