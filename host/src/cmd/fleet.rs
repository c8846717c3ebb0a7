//! `pasapas fleet`: all boards behind gateways, chosen by tags or names.

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use clap::{Args, Subcommand};
use serde_json::{Value, json};

use super::console::{Console, Options};
use super::control::{self, Action};
use super::port::Board;
use super::script::{self, Code};
use super::upload;
use crate::client::upload::UploadError;
use crate::client::{Client, ClientError};
use crate::failure::Failure;
use crate::fleet::{Choice, Found, Member, Standing, members, table};
use crate::interrupt;

/// Boards that are asked at the same time.
const AT_ONCE: usize = 16;
/// Rests before a board that did not answer in the middle gets its next try: longer than its gateway
/// leaves it alone.
const RESTS: [Duration; 2] = [Duration::from_secs(1), Duration::from_secs(4)];
/// Between two looks at a board that was just started.
const LOOK: Duration = Duration::from_millis(50);

/// `pasapas fleet`
#[derive(Debug, Args)]
pub struct Fleet {
    #[command(subcommand)]
    what: What,
}

/// Which boards.
#[derive(Clone, Debug, Args)]
struct Which {
    /// A gateway's Modbus TCP server; several with commas or by repeating it
    #[arg(long, value_name = "HOST:PORT", default_value = "127.0.0.1:1502", value_delimiter = ',')]
    gateway: Vec<String>,
    /// Boards with this tag; with several of them those that have any
    #[arg(long, value_name = "TAG", value_delimiter = ',')]
    tag: Vec<String>,
    /// The board with this name
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    board: Vec<String>,
    /// Every board
    #[arg(long, conflicts_with_all = ["tag", "board"])]
    all: bool,
}

#[derive(Debug, Subcommand)]
enum What {
    /// Show all of them in a table, with what differs: firmware, program, profile
    Status {
        #[command(flatten)]
        which: Which,
    },
    /// Bring a program to one after the other; the first fault ends it
    Upload {
        /// A script, or an image that `build -o` wrote
        file: String,
        #[command(flatten)]
        which: Which,
        /// Stop boards that run
        #[arg(long)]
        stop: bool,
        /// Start each behind its upload, and see it run before the next one's turn
        #[arg(long)]
        start: bool,
        /// With --start: how long a board must run without a fault, or until its end, s
        #[arg(long, value_name = "S", default_value_t = 3, requires = "start")]
        watch: u64,
        /// Give a stored program up first when both do not fit
        #[arg(long)]
        replace: bool,
        /// Upload although a board's profile is another one
        #[arg(long)]
        any_profile: bool,
    },
    /// Start one after the other; the first that does not start ends it
    Start {
        #[command(flatten)]
        which: Which,
    },
    /// Stop all of them at once
    Stop {
        #[command(flatten)]
        which: Which,
    },
}

impl Which {
    fn find(&self, anyone: bool) -> Result<Found, Failure> {
        let choice = Choice { tags: self.tag.clone(), boards: self.board.clone() };
        if choice.is_everyone() && !self.all && !anyone {
            return Err(Failure::Usage(
                "name the boards with --tag or --board; --all is every board".to_owned(),
            ));
        }
        members(&self.gateway, &choice).map_err(Failure::Board)
    }

    /// Boards of which each must be there.
    fn all_of_them(&self, console: &Console) -> Result<Vec<Member>, Failure> {
        let found = self.find(false)?;
        for why in &found.missing {
            console.complain(&format!("pasapas: {why}"));
        }
        match (found.missing.is_empty(), found.members.is_empty()) {
            (false, _) => Err(Failure::Board("a gateway is missing: nothing was done".to_owned())),
            (true, true) => Err(nobody()),
            (true, false) => Ok(found.members),
        }
    }
}

fn nobody() -> Failure {
    Failure::Board(
        "no board has these tags and names: `pasapas fleet status` shows what there is".to_owned(),
    )
}

/// Why a board is not done.
struct Trouble {
    failure: Failure,
    /// It may be over by the next try: a cable, a reset, a gateway that comes back.
    passes: bool,
}

impl From<Failure> for Trouble {
    fn from(failure: Failure) -> Trouble {
        Trouble { failure, passes: false }
    }
}

impl From<ClientError> for Trouble {
    fn from(error: ClientError) -> Trouble {
        let passes = matches!(
            error,
            ClientError::Silent
                | ClientError::Noise(_)
                | ClientError::Port(_)
                | ClientError::Exception(10 | 11)
        );
        Trouble { failure: error.into(), passes }
    }
}

impl From<UploadError> for Trouble {
    fn from(error: UploadError) -> Trouble {
        match error {
            UploadError::Client(error) => error.into(),
            error => Failure::Board(error.to_string()).into(),
        }
    }
}

/// Does it, and once more when a trouble that may pass was in the way: what is repeated must bear it.
fn again_and_again<T>(
    name: &str,
    console: &Console,
    mut job: impl FnMut() -> Result<T, Trouble>,
) -> Result<T, Failure> {
    for rest in RESTS {
        match job() {
            Ok(done) => return Ok(done),
            Err(trouble) if trouble.passes && !interrupt::asked() => {
                let why = words(&trouble.failure);
                console.complain(&format!("{name}: {why}; once more in {} s", rest.as_secs()));
                let until = Instant::now() + rest;
                while Instant::now() < until && !interrupt::asked() {
                    std::thread::sleep(LOOK);
                }
            }
            Err(trouble) => return Err(trouble.failure),
        }
    }
    job().map_err(|trouble| trouble.failure)
}

/// Opens the way to a board.
fn connect(member: &Member) -> Result<Board, Failure> {
    let mut board = Client::new(member.link().map_err(Failure::Board)?, member.known.unit);
    board.find()?;
    Ok(board)
}

/// Does the same with all of them, some at a time; the results in their order.
fn each<T: Send>(members: &[Member], job: impl Fn(&Member) -> T + Sync) -> Vec<T> {
    let (next, results) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
    let lock = || results.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    std::thread::scope(|scope| {
        for _ in 0..AT_ONCE.min(members.len()) {
            scope.spawn(|| {
                loop {
                    let n = next.fetch_add(1, Ordering::Relaxed);
                    let Some(member) = members.get(n) else { break };
                    let result = job(member);
                    lock().push((n, result));
                }
            });
        }
    });
    let mut results = results.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
    results.sort_by_key(|(n, _)| *n);
    results.into_iter().map(|(_, result)| result).collect()
}

fn words(failure: &Failure) -> String {
    failure.message().unwrap_or("it ended in a fault").to_owned()
}

/// What was done with a board.
fn tell(member: &Member, done: &Result<String, Failure>, console: &Console) -> Result<(), Failure> {
    let Member { gateway, known } = member;
    if console.json() {
        let mut line = json!({ "board": known.board, "gateway": gateway, "unit": known.unit });
        match done {
            Ok(what) => line["done"] = json!(what),
            Err(failure) => line["error"] = Value::String(words(failure)),
        }
        return console.json_line(&line);
    }
    match done {
        Ok(what) => console.result(&format!("{}: {what}\n", known.board)),
        Err(failure) => {
            console.complain(&format!("{}: {}", known.board, words(failure)));
            Ok(())
        }
    }
}

impl Fleet {
    /// Does it.
    ///
    /// # Errors
    /// The script is wrong, no board is there, or one of them fails.
    pub fn run(&self, options: &Options, console: &Console) -> Result<(), Failure> {
        match &self.what {
            What::Status { which } => status(which, console),
            What::Upload { .. } => self.upload(options, console),
            What::Start { which } => {
                let members = which.all_of_them(console)?;
                one_by_one(&members, console, |member| {
                    let done = control::act(&mut connect(member)?, Action::Start)?;
                    match done.acknowledged {
                        true => Ok("its fault is acknowledged; start it again to run".to_owned()),
                        false => Ok("started".to_owned()),
                    }
                })
            }
            What::Stop { which } => stop(which, console),
        }
    }

    fn upload(&self, options: &Options, console: &Console) -> Result<(), Failure> {
        let What::Upload { file, which, stop, start, watch, replace, any_profile } = &self.what
        else {
            return Ok(());
        };
        let code = script::load_code(file, options, console)?;
        if let (Some(script), Some(compiled)) = (&code.script, &code.compiled) {
            script::must_fit(script, compiled, console)?;
        }
        let members = which.all_of_them(console)?;
        one_by_one(&members, console, |member| {
            let name = &member.known.board;
            // For boards that draw no arcs another one.
            let mut own = None;
            let (mut board, told) = again_and_again(name, console, || {
                let link = member
                    .link()
                    .map_err(|why| Trouble { failure: Failure::Board(why), passes: true })?;
                let mut board = Client::new(link, member.known.unit);
                board.find()?;
                if *stop && !control::is_idle(board.run_state()?.0) {
                    control::act(&mut board, Action::Stop)?;
                }
                if own.is_none() {
                    own = code.for_board(board.identity()?.part(), console)?;
                }
                let code = own.as_ref().unwrap_or(&code);
                let told = bring(&mut board, code, (*replace, *any_profile), console)?;
                Ok((board, told))
            })?;
            if *start {
                return run_for(
                    &mut board,
                    own.as_ref().unwrap_or(&code),
                    Duration::from_secs(*watch),
                )
                .map(|ran| format!("{told}, {ran}"));
            }
            Ok(told.to_owned())
        })
    }
}

/// Shows all of them, and fails when one is missing.
fn status(which: &Which, console: &Console) -> Result<(), Failure> {
    let found = which.find(true)?;
    if found.members.is_empty() && found.missing.is_empty() {
        return Err(nobody());
    }
    let standings: Vec<Standing> = each(&found.members, |member| {
        let look =
            connect(member).and_then(|mut board| Ok(Standing::of(&mut board, &member.known)?));
        look.unwrap_or_else(|failure| Standing::missing(words(&failure)))
    });
    let differ = crate::fleet::differences(&standings);
    if console.json() {
        for ((member, standing), differs) in found.members.iter().zip(&standings).zip(&differ) {
            let mut line = serde_json::to_value(standing).unwrap_or_default();
            line["board"] = json!(member.known.board);
            line["gateway"] = json!(member.gateway);
            line["unit"] = json!(member.known.unit);
            line["tags"] = json!(member.known.tags);
            line["differs"] = json!(differs);
            console.json_line(&line)?;
        }
    } else {
        console.result(&table(&found.members, &standings, &differ))?;
    }
    let silent = standings.iter().filter(|standing| standing.error.is_some()).count();
    for why in &found.missing {
        console.complain(&format!("pasapas: {why}"));
    }
    match (silent, found.missing.len()) {
        (0, 0) => Ok(()),
        (0, _) => Err(Failure::Board("not every gateway answers".to_owned())),
        (n, _) => {
            Err(Failure::Board(format!("{n} of {} boards cannot be seen", found.members.len())))
        }
    }
}

/// Stops whatever can be reached, whatever else fails.
fn stop(which: &Which, console: &Console) -> Result<(), Failure> {
    let found = which.find(false)?;
    let results = each(&found.members, |member| {
        let mut board = connect(member)?;
        control::act(&mut board, Action::Stop).map(|_| "stopped".to_owned())
    });
    for (member, done) in found.members.iter().zip(&results) {
        tell(member, done, console)?;
    }
    for why in &found.missing {
        console.complain(&format!("pasapas: {why}"));
    }
    let failed = results.iter().filter(|done| done.is_err()).count() + found.missing.len();
    match (failed, found.members.is_empty()) {
        (0, true) => Err(nobody()),
        (0, false) => Ok(()),
        _ => Err(Failure::Board("not everything is stopped: see above".to_owned())),
    }
}

/// Does it with one after the other; the first failure ends it and says what was left alone.
fn one_by_one(
    members: &[Member],
    console: &Console,
    mut job: impl FnMut(&Member) -> Result<String, Failure>,
) -> Result<(), Failure> {
    interrupt::watch();
    for (n, member) in members.iter().enumerate() {
        let asked = interrupt::asked();
        let done = if asked { Err(Failure::Board("interrupted".into())) } else { job(member) };
        tell(member, &done, console)?;
        let Err(failure) = done else { continue };
        let left: Vec<&str> =
            members[n + usize::from(!asked)..].iter().map(|one| one.known.board.as_str()).collect();
        if !left.is_empty() {
            console.complain(&format!("left alone: {}", left.join(", ")));
        }
        return Err(match failure {
            Failure::Run => Failure::Run,
            _ => Failure::Board(format!("it ended at {}", member.known.board)),
        });
    }
    Ok(())
}

/// Brings the program to a board that has it not, and leaves its names with the gateway.
fn bring(
    board: &mut Board,
    code: &Code,
    (replace, any_profile): (bool, bool),
    console: &Console,
) -> Result<&'static str, Trouble> {
    if let (Some(script), false) = (&code.script, any_profile) {
        upload::must_match(&board.board_record()?, &script.program.profile)?;
    }
    let there = board.identity()?;
    let crc = lang::image::crc_in(&code.image);
    let has = |identity: &crate::client::identity::Identity| {
        usize::from(identity.program_bytes) == code.image.len() && identity.program_crc == crc
    };
    let told = if has(&there) {
        "it has the program already"
    } else {
        let file = code.script.as_ref().map_or("program", |script| script.source.name());
        board.bring(&code.image, (None, file), replace, &mut |_| ())?;
        if !has(&board.identity()?) {
            let text =
                "the board shows another program than it was sent: somebody else uploads, too";
            return Err(Failure::Board(text.to_owned()).into());
        }
        "uploaded"
    };
    if let (Some(script), Some(compiled)) = (&code.script, &code.compiled) {
        upload::leave(board, compiled, script, console);
    }
    Ok(told)
}

/// Starts a board and sees that it runs for a time, or to its end.
fn run_for(board: &mut Board, code: &Code, time: Duration) -> Result<String, Failure> {
    if control::act(board, Action::Start)?.acknowledged {
        control::act(board, Action::Start)?;
    }
    let begun = Instant::now();
    loop {
        let status = board.status()?;
        let rests = control::is_idle(status.run_state);
        if let Some(fault) = status.fault.filter(|_| rests) {
            let sidecar = code.compiled.as_ref().map(|compiled| &compiled.sidecar);
            let mark = sidecar.and_then(|sidecar| sidecar.at(status.fault_pc.into()));
            let line = mark.map(|mark| mark.line).or(status.line.map(u32::from));
            let line = line.map_or(String::new(), |line| format!(" in line {line}"));
            let text = status.text.unwrap_or_default();
            return Err(Failure::Board(format!("started, and failed: {fault} {text}{line}")));
        }
        match status.last_end {
            Some("done") if rests => return Ok("ran to its end".to_owned()),
            Some(end) if rests => return Err(Failure::Board(format!("its run was {end}"))),
            _ => {}
        }
        if begun.elapsed() >= time {
            return Ok("runs".to_owned());
        }
        std::thread::sleep(LOOK);
    }
}
