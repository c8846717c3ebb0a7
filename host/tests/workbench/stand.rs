//! A workbench, a browser and a board that a story uses up.

use std::io::{BufRead, BufReader};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use pasapas::client::Client;
use pasapas::client::status::Status;
use pasapas::link::{self, Link};
use tempfile::TempDir;

use crate::cdp::{Browser, Outcome, Page};

/// Everything comes true long before this, on a loaded machine too: a trial of rates takes 15 s of the board's time, and
/// a virtual board falls behind where others want the processor.
pub const PATIENCE: Duration = Duration::from_secs(120);

/// Instead of a world: the board is at a serial line.
const LINE: &str = "line";

/// A process of the tool that is ended with its story.
struct Process(Child);

impl Process {
    /// Starts it and gives the last word of the first line that it says.
    fn start(args: &[&str]) -> Outcome<(Process, String)> {
        let mut child = Command::new(env!("CARGO_BIN_EXE_pasapas"))
            .args(args)
            .stdout(Stdio::piped())
            .spawn()
            .map_err(|error| error.to_string())?;
        let out = child.stdout.take().ok_or("no standard output")?;
        let mut line = String::new();
        let process = Process(child);
        BufReader::new(out).read_line(&mut line).map_err(|error| error.to_string())?;
        let word = line.split_whitespace().last().ok_or("it said nothing")?.to_owned();
        Ok((process, word))
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A board outside of the workbench, which a story can ask by itself.
pub struct Board {
    _process: Process,
    /// For `--port`.
    pub port: String,
    client: Client<Box<dyn Link>>,
}

impl Board {
    /// A virtual one, with these options of `pasapas board`.
    pub fn start(more: &[&str]) -> Outcome<Board> {
        let (process, port) = Process::start(&[&["board"], more].concat())?;
        let mut client = Client::new(link::open(&port)?, 1);
        client.find().map_err(|error| error.to_string())?;
        Ok(Board { _process: process, port, client })
    }

    /// What it does.
    pub fn status(&mut self) -> Outcome<Status> {
        self.client.status().map_err(|error| error.to_string())
    }

    /// X of the machine, steps.
    pub fn x(&mut self) -> Outcome<i32> {
        Ok(self.status()?.pos.x.unwrap_or(0))
    }

    /// Switches an output, as a hand in its world understands it.
    pub fn output(&mut self, n: u16, on: bool) -> Outcome<()> {
        self.client.set_coil(lang::wire::COILS + n - 1, on).map_err(|error| error.to_string())
    }

    /// Brings another program into its library.
    pub fn bring(&mut self, script: &str, name: &str) -> Outcome<()> {
        let source = lang::front::source::Source::new("test", script.to_owned());
        let (program, _) = lang::front::compile(&source, lang::front::ProfileChoice::built_in());
        let compiled = lang::back::compile(&program.ok_or("a script")?).map_err(|_| "a program")?;
        let done = self.client.bring(&compiled.image, (None, name), false, &mut |_| {});
        done.map(drop).map_err(|error| error.to_string())
    }

    /// Waits until its state fits.
    pub fn until(&mut self, what: &str, fits: impl Fn(&Status) -> bool) -> Outcome<Status> {
        let end = Instant::now() + PATIENCE;
        loop {
            let status = self.status()?;
            if fits(&status) {
                return Ok(status);
            }
            if Instant::now() > end {
                return Err(format!("the board never showed {what}: {status:?}"));
            }
        }
    }
}

/// See [`Stand::footprint`].
#[derive(Clone, Copy, Debug)]
pub struct Footprint {
    /// Memory that no other process shares, KB.
    pub kb: u64,
    /// Open files.
    pub files: u64,
    /// Threads.
    pub threads: u64,
}

/// Everything of a story.
pub struct Stand {
    /// See [`turn`].
    _turn: MutexGuard<'static, ()>,
    tool: Process,
    /// The browser.
    pub browser: Arc<Browser>,
    /// Where the page is, with the key.
    pub url: String,
    /// The script's folder.
    pub folder: TempDir,
    /// The board, if it is not the workbench's own.
    pub board: Option<Board>,
}

impl Stand {
    /// A workbench for a script, with a board of its own (`None` where there is no Chromium).
    pub fn start(text: &str, more: &[&str]) -> Outcome<Option<Stand>> {
        Stand::with(text, more, None)
    }

    /// A workbench for a board that the story asks too.
    pub fn with_board(text: &str) -> Outcome<Option<Stand>> {
        Stand::with(text, &[], Some(""))
    }

    /// The same with a board at a serial line, which several processes have open.
    pub fn with_line(text: &str) -> Outcome<Option<Stand>> {
        Stand::with(text, &[], Some(LINE))
    }

    /// The same with a world around the board, and options for the workbench.
    pub fn with_world(text: &str, world: &str, more: &[&str]) -> Outcome<Option<Stand>> {
        Stand::with(text, more, Some(world))
    }

    fn with(text: &str, more: &[&str], outside: Option<&str>) -> Outcome<Option<Stand>> {
        if !has_chromium() {
            return Ok(None);
        }
        let turn = turn();
        let folder = tempfile::tempdir().map_err(|error| error.to_string())?;
        let script = folder.path().join("job.bas");
        std::fs::write(&script, text).map_err(|error| error.to_string())?;
        let script = script.display().to_string();
        let around = folder.path().join("world.rhai");
        let around_name = around.display().to_string();
        let board = match outside {
            None => None,
            Some("") => Some(Board::start(&["--tcp", "0"])?),
            Some(LINE) => Some(Board::start(&[])?),
            Some(world) => {
                std::fs::write(&around, world).map_err(|error| error.to_string())?;
                Some(Board::start(&["--tcp", "0", "--world", &around_name])?)
            }
        };
        let mut args = vec!["workbench", "--no-open", &script];
        args.extend(more);
        if let Some(board) = &board {
            args.extend(["--port", &board.port]);
        }
        let (tool, url) = Process::start(&args)?;
        let browser = Browser::start()?;
        Ok(Some(Stand { _turn: turn, tool, browser, url, folder, board }))
    }

    /// A page that has drawn a state of the board.
    pub fn page(&self) -> Outcome<Page> {
        let page = self.browser.page(&self.url)?;
        page.wait("document.querySelector('#port, #lamp') !== null", PATIENCE)?;
        let ready = if self.url.contains("/operator") {
            "document.querySelector('#lamp').textContent === 'No program' \
             || document.querySelector('#lamp').textContent === 'Ready'"
        } else {
            "document.querySelector('#port').classList.contains('on')"
        };
        page.wait(ready, PATIENCE)?;
        Ok(page)
    }

    /// What the tool takes of the system.
    pub fn footprint(&self) -> Outcome<Footprint> {
        let process = format!("/proc/{}", self.tool.0.id());
        let status = std::fs::read_to_string(format!("{process}/status"));
        let status = status.map_err(|error| error.to_string())?;
        let number = |name: &str| {
            let line = status.lines().find_map(|line| line.strip_prefix(name));
            let number = line.and_then(|line| line.split_whitespace().next()?.parse::<u64>().ok());
            number.ok_or_else(|| format!("no {name}"))
        };
        let files =
            std::fs::read_dir(format!("{process}/fd")).map_err(|error| error.to_string())?;
        Ok(Footprint {
            kb: number("RssAnon:")?,
            files: files.count() as u64,
            threads: number("Threads:")?,
        })
    }

    /// The script's file.
    pub fn script(&self) -> PathBuf {
        self.folder.path().join("job.bas")
    }

    /// The board outside.
    pub fn board(&mut self) -> Outcome<&mut Board> {
        self.board.as_mut().ok_or_else(|| "this story has no board of its own".to_owned())
    }
}

/// What a story asks of its page again and again.
impl Page {
    /// Waits until a text is somewhere in an element.
    pub fn says(&self, selector: &str, words: &str) -> Outcome<()> {
        let found = format!(
            "(document.querySelector({selector:?})?.textContent ?? '').includes({words:?})"
        );
        self.wait(&found, PATIENCE).map_err(|error| {
            let has = self.eval(&format!("document.querySelector({selector:?})?.textContent"));
            let notes = self.eval("document.querySelector('#notes')?.textContent");
            format!("{error}; it says {has:?}, and the page's notes are {notes:?}")
        })
    }

    /// Clicks a button as soon as it may be clicked.
    pub fn push(&self, selector: &str) -> Outcome<()> {
        self.wait(
            &format!("document.querySelector({selector:?})?.matches(':enabled') === true"),
            PATIENCE,
        )?;
        self.click(selector)
    }

    /// Waits until a text is in the script.
    pub fn has(&self, text: &str) -> Outcome<()> {
        const SCRIPT: &str = "document.querySelector('.ed .text').textContent";
        self.wait(&format!("{SCRIPT}.includes({text:?})"), PATIENCE).map_err(|error| {
            let (has, notes) =
                (self.eval(SCRIPT), self.eval("document.querySelector('#notes').textContent"));
            format!("{error}; it is {has:?}, and the page says {notes:?}")
        })
    }

    /// Writes a value into a field, as somebody who leaves it.
    pub fn fill(&self, selector: &str, value: &str) -> Outcome<()> {
        let js = format!(
            "(() => {{ const e = document.querySelector({selector:?}); e.value = {value:?}; \
             e.dispatchEvent(new Event('input', {{ bubbles: true }})); \
             e.dispatchEvent(new Event('change', {{ bubbles: true }})) }})()"
        );
        self.wait(&format!("document.querySelector({selector:?}) !== null"), PATIENCE)?;
        self.eval(&js).map(drop)
    }

    /// Shows a part of the workbench.
    pub fn tab(&self, name: &str) -> Outcome<()> {
        self.click(&format!("[data-tab={name}]"))
    }

    /// Waits until what changed is painted.
    pub fn rest(&self) -> Outcome<()> {
        self.eval("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")
            .map(drop)
    }

    /// Writes another script in the place of this one.
    pub fn select_script(&self, text: &str) -> Outcome<()> {
        self.click(".ed .text")?;
        self.select_all()?;
        self.type_text(text)
    }

    /// Puts the caret at the end of the script.
    pub fn end_of_script(&self) -> Outcome<()> {
        self.click(".ed .text")?;
        self.press("End", "End", 35, "", 2)
    }

    /// Brings the script to the board.
    pub fn upload(&self) -> Outcome<()> {
        self.tab("run")?;
        self.push("#upload")?;
        self.wait("document.querySelector('#start').matches(':enabled')", PATIENCE)?;
        self.says("#run-state", "ready")
    }
}

/// Stories come one after the other: each wants the machine's time for itself.
pub fn turn() -> MutexGuard<'static, ()> {
    static TURN: Mutex<()> = Mutex::new(());
    TURN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Whether the browser is there; stories that want it say so where it is not.
pub fn has_chromium() -> bool {
    let found = Command::new("chromium")
        .arg("--version")
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status()
        .is_ok_and(|status| status.success());
    if !found {
        eprintln!("chromium does not run here: its story is left out");
    }
    found
}
