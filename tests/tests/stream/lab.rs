//! A job on the simulation and streamed to the emulated board.

use lang::back;
use lang::fault::Fault;
use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};
use lang::hir::Program;
use lang::profile::Profile;
use lang::wire::CHAR_IN;
use pasapas::bench::stand::Stand;
use pasapas::board::rig::HostAction;
use pasapas::client::trace::Tracer;
use pasapas::sim::trace::{Event, What, to_text};
use pasapas::sim::world::World;
use pasapas::sim::{Engine, Options, run_traced};
use pasapas::stream::feed::Feed;
use pasapas::stream::job::Job;
use pasapas::stream::pump::{self, Outcome};

/// A job with its world.
pub struct Case {
    pub script: String,
    pub world: String,
}

/// What a run left.
pub struct Run {
    pub trace: Vec<What>,
    pub fault: Option<Fault>,
    pub line: u32,
    pub motors: [i64; 3],
}

pub fn program(script: &str) -> Program {
    let source = Source::new("job.bas", script.to_owned());
    let (program, diags) = compile(&source, ProfileChoice::built_in());
    program.unwrap_or_else(|| panic!("{script}\n{}", diags.render(&source)))
}

/// Lines are the streamed job's own matter: its pieces have addresses of their own.
fn bare(what: What) -> What {
    match what {
        What::Home { axis, ok, pos, .. } => What::Home { line: 0, axis, ok, pos },
        What::Move { kind, to, .. } => What::Move { line: 0, kind, to },
        What::Out { n, v, sync, .. } => What::Out { line: 0, n, v, sync, pos: None },
        What::Aout { n, mv, share, sync, .. } => {
            What::Aout { line: 0, n, mv, share, sync, pos: None }
        }
        What::Wait { ms, .. } => What::Wait { line: 0, ms },
        What::WaitIn { n, v, ok, .. } => What::WaitIn { line: 0, n, v, ok },
        What::Probe { axis, ok, pos, .. } => What::Probe { line: 0, axis, ok, pos },
        What::Print { text, .. } => What::Print { line: 0, text },
        What::Send { c, .. } => What::Send { line: 0, c },
        What::WaitChar { c, ok, .. } => What::WaitChar { line: 0, c, ok },
        What::WaitStart { .. } => What::WaitStart { line: 0 },
        What::Speed { axis, v, .. } => What::Speed { line: 0, axis, v },
        What::Stop { axis, .. } => What::Stop { line: 0, axis },
        What::Run { program, .. } => What::Run { line: 0, program },
        What::End { status, fault, text, pos, .. } => {
            What::End { status, fault, text, line: 0, pos }
        }
    }
}

/// The trace as text, without lines.
pub fn text(trace: &[What]) -> String {
    let events: Vec<Event> =
        trace.iter().map(|what| Event { what: what.clone(), us: None }).collect();
    to_text(&events)
}

/// Runs a case on the simulation.
pub fn simulate(case: &Case) -> Run {
    let program = program(&case.script);
    let world = World::parse("world", &case.world).expect("a world");
    let options = Options { limit_us: 600_000_000, ..Options::default() };
    let (outcome, events) =
        run_traced(&program, Engine::Vm, &world, &options).expect("a simulation");
    Run {
        trace: events.into_iter().map(|event| bare(event.what)).collect(),
        fault: outcome.end.fault,
        line: outcome.end.line,
        motors: [0; 3],
    }
}

/// Streams a case; `traced`: the program waits until each event of its trace was read.
pub fn stream(case: &Case, traced: bool) -> (Run, Outcome, String) {
    let program = program(&case.script);
    let compiled = back::compile(&program).expect("it fits");
    let world = World::parse("world", &case.world).expect("a world");
    let profile: Profile = program.profile.clone();
    let mut stand = Stand::in_world(&profile, &world).expect("a board");
    let rig = stand.rig();
    let client = stand.client();
    let slots = client.stream_slots().expect("an answer").expect("it can stream");
    let mut job = Job::new(Feed::new(&compiled).expect("an image"), slots.bytes.into());
    // Half of the traced cases wait for each event, the others have a queue of them.
    let queued =
        traced && client.begin_trace(case.script.len().is_multiple_of(2)).expect("trace mode");
    let mut tracer = Tracer::new(profile, Box::new(|_| 0)).queued(queued);
    let mut trace = Vec::new();
    let mut begun = false;
    let mut printed = Vec::new();
    let mut print = |bytes: &[u8]| printed.extend_from_slice(bytes);
    let outcome = pump::run_observed(
        client,
        &mut job,
        slots,
        &mut |_| None,
        if traced { None } else { Some(&mut print) },
        &mut |client, _, _| {
            // The world begins with the first look behind the start: 15 ms later, with the link.
            if !std::mem::replace(&mut begun, true) {
                rig.borrow_mut().begin();
            }
            let actions = rig.borrow_mut().take_host_actions();
            for action in actions {
                if let HostAction::Char(c) = action {
                    client.write(CHAR_IN, u16::try_from(c).unwrap_or(0))?;
                }
            }
            while queued && let Some(event) = tracer.poll(client)? {
                trace.push(event);
            }
            // The second look tells the board that an event was received.
            for _ in 0..if traced && !queued { 3 } else { 0 } {
                trace.extend(tracer.poll(client)?);
            }
            Ok(())
        },
    );
    let outcome = outcome.unwrap_or_else(|error| panic!("{error}\n{}", case.script));
    for _ in 0..if traced { 12 } else { 0 } {
        trace.extend(tracer.poll(client).expect("an answer"));
    }
    let motors = stand.motors();
    let run = Run {
        trace: trace.into_iter().map(bare).collect(),
        fault: outcome.fault,
        line: outcome.line,
        motors,
    };
    (run, outcome, String::from_utf8(printed).expect("text"))
}

/// Both runs of a case leave the same trace.
///
/// # Errors
/// The two, where they differ.
pub fn compare(case: &Case) -> Result<(), String> {
    let simulated = simulate(case);
    let (streamed, outcome, _) = stream(case, true);
    let (a, b) = (text(&simulated.trace), text(&streamed.trace));
    let same_line = simulated.fault.is_none() || simulated.line == streamed.line;
    if a != b || simulated.fault != streamed.fault || !same_line {
        return Err(format!(
            "{}\n// {}\nsimulated, ends in line {}:\n{a}\nstreamed, {outcome:?}:\n{b}",
            case.script, case.world, simulated.line
        ));
    }
    Ok(())
}
