//! The kinds of `pasapas torture` can lose: each is shown a fault that it must find. And what they
//! found once, as scripts.

use emulator::{Config, Reset, Rng};
use lang::fault::Fault;
use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};
use lang::image::{Image, seal};
use lang::isa::Op;
use lang::part::SEGMENT;
use lang::profile::Profile;
use lang::record::{BoardRecord, feature};
use lang::wire::{
    Control, FAULT, FAULT_INPUT, HOMED, MACHINE_POSITIONS, PROFILE_WINDOW, RUN_STATE, RunState,
};
use pasapas::board::{BUILDS, DEFAULT};
use pasapas::sim::trace::What;
use pasapas::torture::generate::{Case, generate, generate_still};
use pasapas::torture::images::{self, judge};
use pasapas::torture::line::{self, slave};
use pasapas::torture::power::Failure;
use pasapas::torture::programs::{
    against_the_board, against_the_machine, make, make_for, on_board, on_the_host, reference, tape,
};
use pasapas::torture::stand::{Fresh, Stand, words};
use pasapas::torture::{Length, Settings, Verdict};
use pasapas::torture::{people, power, time};

const SETTINGS: Settings =
    Settings { length: Length::Short, count: None, seed: 11, from: 0, builds: &BUILDS };

/// The image with every `from` replaced by `to`.
fn replaced(image: &[u8], from: Op, to: Op) -> Vec<u8> {
    let read = Image::new(image).expect("an image of our own");
    let wide = read.header.wide();
    let start = image.len() - read.code.len() - read.data.len();
    let mut spoilt = image.to_vec();
    let mut pc = 0;
    while let Some((op, _)) = read.code.get(pc).and_then(|code| Op::decode(*code)) {
        if op == from {
            spoilt[start + pc] = to.code();
        }
        pc += 1 + op.row().operands.len(wide);
    }
    seal(&mut spoilt);
    spoilt
}

/// Whether any of `count` cases is lost.
fn is_found(count: u64, case: impl Fn(u64) -> Option<Verdict>) -> bool {
    (0..count).any(|n| matches!(case(n), Some(Verdict::Lost(_))))
}

/// Generated programs do on the firmware's machine what `rhai` says of them.
#[test]
fn generated_programs_run_on_the_machine_without_an_emulator() {
    let mut run = 0;
    for n in 0..120 {
        let Some(made) = make(generate_still(DEFAULT.part, &tape(&SETTINGS, "native", n))) else {
            continue;
        };
        let Some(wanted) = reference(DEFAULT.part, &made) else { continue };
        match against_the_machine(&made, &made.compiled.image, &wanted) {
            Verdict::Survived => run += 1,
            Verdict::Skipped => {}
            Verdict::Lost(text) => panic!("case {n}: {text}"),
        }
    }
    assert!(run > 30, "only {run} were run");
}

/// Generated programs do on the emulated board of each part what `rhai` says of them.
#[test]
fn generated_programs_run_on_the_board_of_every_part() {
    for build in BUILDS {
        let mut run = 0;
        for n in 0..60 {
            if run == 6 {
                break;
            }
            let case = generate_still(build.part, &tape(&SETTINGS, "every part", n));
            let Some(made) = make_for(build, case) else { continue };
            let Some(wanted) = reference(build.part, &made) else { continue };
            match against_the_board(build, &made, &made.compiled.image, &wanted).0 {
                Verdict::Survived => run += 1,
                Verdict::Skipped => {}
                Verdict::Lost(text) => panic!("{}, case {n}: {text}", build.part.name),
            }
        }
        assert_eq!(run, 6, "were run on {}", build.part.name);
    }
}

#[test]
fn programs_find_a_fault_seeded_into_any_engine() {
    let on_vm = is_found(300, |n| {
        let made = make(generate(&tape(&SETTINGS, "vm", n)))?;
        let mut spoilt = made.compiled.clone();
        spoilt.image = replaced(&made.compiled.image, Op::Add, Op::Sub);
        Some(on_the_host(&made, Some(&spoilt)))
    });
    assert!(on_vm, "an ADD that subtracts on the vm");
    let on_machine = is_found(60, |n| {
        let made = make(generate_still(DEFAULT.part, &tape(&SETTINGS, "machine", n)))?;
        let wanted = reference(DEFAULT.part, &made)?;
        let spoilt = replaced(&made.compiled.image, Op::Add, Op::Sub);
        Some(against_the_machine(&made, &spoilt, &wanted))
    });
    assert!(on_machine, "an ADD that subtracts on the machine");
    let on_board = is_found(60, |n| {
        let made = make(generate_still(DEFAULT.part, &tape(&SETTINGS, "board", n)))?;
        let wanted = reference(DEFAULT.part, &made)?;
        let image = replaced(&made.compiled.image, Op::Add, Op::Sub);
        Some(against_the_board(DEFAULT, &made, &image, &wanted).0)
    });
    assert!(on_board, "an ADD that subtracts on the board");
    let on_rhai = is_found(60, |n| {
        let case = generate_still(DEFAULT.part, &tape(&SETTINGS, "rhai", n));
        let other = Case { script: case.script.replace(" + ", " - "), ..case.clone() };
        let (made, other) = (make(case)?, make(other)?);
        let wanted = reference(DEFAULT.part, &other)?;
        Some(against_the_board(DEFAULT, &made, &made.compiled.image, &wanted).0)
    });
    assert!(on_rhai, "a + that subtracts in rhai");
}

/// Scripts on which the board once differed from the other engines.
const ONCE_DIFFERENT: [(&str, &str, &str); 13] = [
    ("a line longer than the ring of print", "PRINT \"LONG\"\nWait 5ms\nPRINT 7", ""),
    (
        "a PRINT that fails leaves nothing in the ring",
        "DIM a\nON ERROR GOTO oops\nPRINT \"p\"; 1 / a\nEND\noops:\nPRINT ERR\nRESUME NEXT",
        "",
    ),
    (
        "only WaitIn? changes TIMEDOUT",
        "ON ERROR GOTO oops\nWaitIn 3, ON, 20ms\nPRINT TIMEDOUT\nWaitIn? 3, ON, 20ms\n\
         WaitIn 4, ON, 20ms\nPRINT TIMEDOUT\nEND\noops:\nRESUME NEXT",
        "at(0, || set_in(4, true));",
    ),
    ("StopAll tells of each axis", "START MoveRel X, 30st\nWaitMove\nStopAll\nPRINT 1", ""),
    (
        "SetPos and G92 need a resting axis",
        "ON ERROR GOTO oops\nSTART MoveRel X, 3000st\nWait 20ms\nSetPos X, 0mm\nMoveAxe X, 0mm\n\
         START MoveRel X, 3000st\nWait 20ms\nG92 X0\nMoveAxe X, 0mm\nEND\noops:\nPRINT ERR\n\
         RESUME NEXT",
        "",
    ),
    (
        "homing takes no step from an axis that moves on its own",
        "Home Y\nSTART MoveRel X, 300st\nHome Y\nWaitMove",
        "switch_at(\"Y\", -150);",
    ),
    (
        "MoveSpeed against the end of the travel is refused",
        "Home Y\nMoveSpeed Y, -300st/s\nWait 40ms",
        "switch_at(\"Y\", -150);",
    ),
    (
        "an arc ends at a switch before the block behind its next one begins",
        "Wait 20ms\nG91 F1200\nG2 X3 Y3 R-5\nG2 X3 Y3 R-5\nG2 X3 Y3 R-5",
        "switch_at(\"X\", -300);",
    ),
    (
        "a limit switch ends the statement that runs into it where nothing looks ahead",
        "G64 G1 Y-2 F600\nPRINT 1",
        "switch_at(\"Y\", -150);",
    ),
    (
        "of the words of a block Z is looked at first",
        "DIM far AS LENGTH\nHome Z\nSetPos X, -1000mm\nfar = 2147483mm\nG1 X[far] Z[far] F600",
        "switch_at(\"Z\", 120);",
    ),
    (
        "a move's speed is looked at before its target",
        "DIM far AS LENGTH, slow AS SPEED\nSetPos X, -1000mm\nfar = 2147483mm\nMoveAxe X, far, slow",
        "",
    ),
    (
        "a probe's input is looked at before its limit",
        "DIM far AS LENGTH, n\nSetPos X, -1000mm\nfar = 2147483mm\nn = 40\nProbe X, far, 1mm/s, n",
        "",
    ),
    ("a path may be followed by SetPos", "G1 X5 Y5 F600\nSetPos X, 0mm\nG92 Y1\nPRINT POS(X)", ""),
];

#[test]
fn the_board_does_as_the_other_engines_where_it_once_did_not() {
    for (what, script, world) in ONCE_DIFFERENT {
        let script = script.replace("LONG", &"long ".repeat(50));
        let case = Case { script, world: world.to_owned(), independent: false };
        assert!(make(case.clone()).is_some(), "{what}: it does not compile");
        for build in BUILDS {
            let Some(made) = make_for(build, case.clone()) else { continue };
            let wanted = reference(build.part, &made);
            let wanted = wanted.unwrap_or_else(|| panic!("{what}: hangs on an instant"));
            let (verdict, _) = against_the_board(build, &made, &made.compiled.image, &wanted);
            assert_eq!(verdict, Verdict::Survived, "{what}, {}", build.part.name);
        }
    }
}

#[test]
fn a_relative_move_of_an_axis_that_runs_begins_where_it_is() {
    let script = "MoveAxe X, 800st\nMoveSpeed X, 1000st/s\nWait 300ms\nMoveAxe X, 800st\n\
                  MoveSpeed X, -1000st/s\nWait 300ms\nMoveRel X, 500st";
    let case = Case { script: script.to_owned(), world: String::new(), independent: false };
    let made = make(case).expect("it compiles");
    let (run, _) = on_board(DEFAULT, &made, &made.compiled.image).expect("the board runs it");
    let targets: Vec<i32> = run.trace.iter().filter_map(|event| target_x(&event.what)).collect();
    // Back to where it had been sent before it ran; then from 300 steps below, and as many more as the
    // host took for the lines of the trace.
    let [800, 800, relative] = targets[..] else { panic!("{:?}", run.trace) };
    assert!((800..1_010).contains(&relative), "{relative}");
}

fn target_x(what: &What) -> Option<i32> {
    match what {
        What::Move { to, .. } => to.x,
        _ => None,
    }
}

#[test]
fn images_find_a_verifier_that_accepts_everything() {
    let corpus = images::corpus(DEFAULT, &SETTINGS).expect("programs compile");
    let on_host = is_found(2_000, |n| {
        let mut rng = Rng::new(n);
        let image = images::damaged(&mut rng, &corpus);
        let read = Image::new(&image).ok()?;
        judge::judged(read, &mut rng).err().map(Verdict::Lost)
    });
    assert!(on_host, "the host's VM on images that nobody verified");
    let mut stand = Stand::new(DEFAULT, &Config::default()).expect("the shipped image");
    // clr r12; ret: no image has a flaw.
    let verify = stand.board.symbol("pasapas_verify").expect("the image has the routine");
    stand.board.poke16(verify, 0x430C);
    stand.board.poke16(verify + 2, 0x4130);
    let fresh = Fresh::new(stand);
    let on_board = is_found(60, |n| {
        let mut rng = Rng::new(n);
        let image = images::damaged(&mut rng, &corpus);
        images::board::try_out(DEFAULT, &mut fresh.copy(), &image, &mut rng)
            .err()
            .map(Verdict::Lost)
    });
    assert!(on_board, "a board that accepts everything");
}

#[test]
fn a_second_run_moves_the_way_it_counts() {
    let script = "MoveRel X, -50st\nMoveAxe Z, -30st".to_owned();
    let case = Case { script, world: String::new(), independent: false };
    let made = make(case).expect("it compiles");
    let mut stand = Stand::new(DEFAULT, &Config::default()).expect("the shipped image");
    stand.upload(&made.compiled.image, false).expect("it is taken");
    for run in 1..=3 {
        stand.control(Control::Start);
        stand.board.run_us(600_000);
        assert_eq!(stand.read_long(MACHINE_POSITIONS), Some(-50 * run));
        assert_eq!(stand.board.plant().motors[0].position, i64::from(-50 * run));
        assert_eq!(stand.board.plant().motors[2].position, -30);
    }
}

#[test]
fn people_find_a_direction_that_is_the_wrong_way_round() {
    let mut stand = Stand::new(DEFAULT, &Config::default()).expect("the shipped image");
    for motor in &mut stand.board.plant_mut().motors {
        motor.inverted = true;
    }
    let fresh = Fresh::new(stand);
    let found = is_found(40, |n| {
        let case = generate(&tape(&SETTINGS, "people", n));
        let made = make(Case { world: String::new(), ..case })?;
        people::try_out(fresh.copy(), &made, Rng::new(n)).err().map(Verdict::Lost)
    });
    assert!(found, "motors that turn the other way");
}

#[test]
fn power_finds_a_program_that_a_cut_damaged() {
    let writes = power::writes(DEFAULT).expect("the shipped image");
    let upload = &writes[0];
    // A bit of each segment of the program area, in the middle of the images.
    let spoil = |stand: &mut Stand| {
        let area = 0xFE00 - (SEGMENT * usize::from(DEFAULT.part.segments)) as u16;
        for segment in (area..0xFE00).step_by(SEGMENT) {
            let at = segment + 100;
            let byte = stand.board.peek8(at);
            stand.board.poke8(at, byte ^ 1);
        }
    };
    assert_eq!(upload.fail(Failure::Cut, 20, 1, &|_| {}), Some(Verdict::Survived));
    assert!(matches!(upload.fail(Failure::Cut, 20, 1, &spoil), Some(Verdict::Lost(_))));
}

#[test]
fn line_finds_a_slave_that_takes_what_is_no_frame_or_leaves_one() {
    let request = line::any_request(&mut Rng::new(1));
    let mut damaged = request.clone();
    damaged[3] ^= 1;
    assert_eq!(slave::try_out(&request, line::is_sound), Ok(()));
    assert_eq!(slave::try_out(&damaged, line::is_sound), Ok(()));
    assert!(slave::try_out(&request, |_, _| false).is_err(), "an answer to no frame");
    assert!(slave::try_out(&damaged, |_, _| true).is_err(), "no answer to a frame");
}

#[test]
fn time_finds_a_program_that_ended_and_a_board_that_nobody_hears() {
    let stand = |script| {
        let mut stand = Stand::new(DEFAULT, &Config::default()).expect("the shipped image");
        let image = power::image(script).expect("it compiles");
        stand.upload(&image, false).expect("it is taken");
        stand
    };
    assert_eq!(time::busy(&mut stand("DO\nLOOP"), &mut Rng::new(1)), Ok(()));
    assert!(time::busy(&mut stand("PRINT 1"), &mut Rng::new(1)).is_err());
    let mut deaf = stand("DO\nLOOP");
    deaf.board.set_uart_noise(1, 200_000);
    assert!(time::busy(&mut deaf, &mut Rng::new(1)).is_err());
}

/// A board that runs `script` by itself behind a power-up, with an emergency stop at input 4.
fn autorunning(build: &'static pasapas::board::Build, script: &str) -> Stand {
    let mut stand = Stand::new(build, &Config::default()).expect("the shipped image");
    let mut record = BoardRecord { sequence: 1, ..BoardRecord::DEFAULT };
    record.emergency[0] = 4;
    let record = BoardRecord { flags: record.flags | BoardRecord::AUTORUN, ..record };
    for (n, part) in words(&record.sealed().to_bytes()).chunks(16).enumerate() {
        stand.write(PROFILE_WINDOW + 16 * n as u16, part);
    }
    let image = power::image(script).expect("it compiles");
    stand.upload(&image, false).expect("it is taken");
    stand.board.power_cut();
    stand.board.power_up();
    stand
}

#[test]
fn autorun_never_acknowledges_a_fault() {
    for build in BUILDS {
        let name = build.part.name;
        let mut stand = autorunning(build, "DO\nLOOP");
        stand.board.run_us(300_000);
        stand.board.plant_mut().set_input(4, true);
        stand.board.run_us(50_000);
        stand.board.plant_mut().set_input(4, false);
        stand.board.run_us(1_500_000);
        assert_eq!(stand.state(), Some(RunState::Fault as u16), "{name}");
        assert_eq!(stand.read(FAULT), Some(Fault::EmergencyStop as u16), "{name}");
        // What it is called decides: somebody's Start acknowledges, and the next one begins a run.
        stand.control(Control::Acknowledge);
        stand.board.run_us(1_500_000);
        assert_eq!(stand.state(), Some(RunState::Ready as u16), "{name}: it starts behind a fault");
    }
}

/// What the manual says of RST: the steps end, the run is F14 without an input, and nothing starts by itself, behind another RST
/// either.
#[test]
fn rst_is_no_emergency_stop() {
    for build in BUILDS {
        let name = build.part.name;
        let mut stand = autorunning(build, "MoveAxe X, 200mm\n");
        stand.board.run_us(900_000);
        assert_eq!(stand.state(), Some(RunState::Running as u16), "{name}");
        stand.board.reset_pin();
        stand.board.run_us(1_500_000);
        let told = [RUN_STATE, FAULT, FAULT_INPUT, HOMED].map(|register| stand.read(register));
        let wanted = [RunState::Fault as u16, Fault::EmergencyStop as u16, 0, 0];
        assert_eq!(told, wanted.map(Some), "{name}");
        let steps = stand.board.plant().motors[0].pulses;
        stand.board.reset_pin();
        stand.board.run_us(1_500_000);
        println!("{name} behind a second RST: {:?}", stand.state());
        assert_ne!(stand.state(), Some(RunState::Running as u16), "{name}");
        assert_eq!(stand.board.plant().motors[0].pulses, steps, "{name}");
    }
}

#[test]
fn only_a_power_up_starts_the_program_by_itself() {
    for build in BUILDS {
        let mut stand = Stand::new(build, &Config::default()).expect("the shipped image");
        let record = BoardRecord { sequence: 1, start: 5, ..BoardRecord::DEFAULT };
        let record = BoardRecord { flags: record.flags | BoardRecord::AUTORUN, ..record };
        for (n, part) in words(&record.sealed().to_bytes()).chunks(16).enumerate() {
            stand.write(PROFILE_WINDOW + 16 * n as u16, part);
        }
        let image = power::image("DO\nLOOP").expect("it compiles");
        stand.upload(&image, false).expect("it is taken");
        let name = build.part.name;
        type Reset = (&'static str, fn(&mut Stand));
        let resets: [Reset; 2] = [
            ("a restart that a host asked for", |stand| {
                stand.control(Control::Restart);
            }),
            ("RST", |stand| stand.board.reset_pin()),
        ];
        for (reset, act) in resets {
            for _ in 0..2 {
                act(&mut stand);
                stand.board.run_us(1_500_000);
                assert_eq!(stand.state(), Some(RunState::Ready as u16), "{name}: {reset}");
            }
        }
        stand.board.power_cut();
        stand.board.power_up();
        stand.board.run_us(700_000);
        assert_eq!(stand.state(), Some(RunState::Running as u16), "{name} autoruns");
        // RST in the run: the fault stays until somebody acknowledges it.
        stand.board.reset_pin();
        stand.board.run_us(1_500_000);
        assert_eq!(stand.state(), Some(RunState::Fault as u16), "{name}: RST in a run");
        stand.control(Control::Acknowledge);
        stand.board.run_us(1_500_000);
        assert_eq!(stand.state(), Some(RunState::Ready as u16), "{name}: acknowledged");
        stand.control(Control::Start);
        stand.board.run_us(100_000);
        // And a second Start button begins the next run.
        stand.control(Control::Stop);
        stand.board.run_us(100_000);
        stand.board.plant_mut().set_input(5, true);
        stand.board.run_us(100_000);
        assert_eq!(stand.state(), Some(RunState::Running as u16), "{}", build.part.name);
    }
}

#[test]
fn a_machine_that_demands_homing_takes_set_pos_for_it_within_a_run() {
    let mut profile = Profile::built_in("mill").expect("it is built in");
    profile.require_homing = true;
    let image_of = |script: &str| {
        let choice = ProfileChoice::Given(Box::new(profile.clone()));
        let (program, _) = compile(&Source::new("g.bas", script.to_owned()), choice);
        lang::back::compile(&program.expect("it is right")).expect("it fits").image
    };
    let not_homed = u16::from(Fault::NotHomed.number());
    for build in BUILDS {
        let fresh = Stand::new(build, &Config::default()).expect("the shipped image");
        for (script, fault) in [
            ("SetPos X, 1mm\nMoveAxe X, 0mm\nMoveAxe X, 1mm", 0),
            ("SetPos X, 0mm\nMoveAxe X, 1mm", 0),
            ("SetPos X, 1mm\nMoveAxe Y, 1mm", not_homed),
            ("SetPos X, 1mm\nMotors OFF\nMoveAxe X, 0mm", not_homed),
            ("IF OUT(2) THEN SetPos X, 1mm\nMoveAxe X, 0mm", not_homed),
        ] {
            let mut stand = fresh.clone();
            stand.upload(&image_of(script), false).expect("it is taken");
            for run in 1..=2 {
                stand.control(Control::Start);
                stand.board.run_us(600_000);
                let told = stand.read(FAULT);
                assert_eq!(told, Some(fault), "{}, run {run}: {script}", build.part.name);
                stand.control(Control::Acknowledge);
            }
        }
    }
}

#[test]
fn a_handler_without_a_table_of_statements_takes_no_fault() {
    let script = "DIM a\nON ERROR GOTO h\na = 7 + 1 / a\nMoveSpeed X, 5mm/s\n\
        Probe Z, -1mm, 1mm/s, 3, ON\nEND\nh:\nRESUME NEXT";
    let mut image = power::image(script).expect("it compiles");
    image[1] &= !(feature::LINES as u8);
    seal(&mut image);
    for n in 0..300 {
        assert_eq!(judge::try_out(&image, &mut Rng::new(n)), Ok(true));
    }
    let mut stand = Stand::new(DEFAULT, &Config::default()).expect("the shipped image");
    stand.upload(&image, false).expect("it is taken");
    stand.control(Control::Start);
    stand.board.run_us(300_000);
    assert_eq!(stand.read(FAULT), Some(Fault::DivisionByZero.number().into()));
    assert_eq!(stand.state(), Some(RunState::Fault as u16));
}

#[test]
fn a_watchdog_reset_in_the_middle_of_steps_is_over_at_once() {
    let mut stand = Stand::new(DEFAULT, &Config::default()).expect("the shipped image");
    let image = power::image("DO\nMoveRel X, 40mm\nMoveRel X, -40mm\nLOOP").expect("it compiles");
    stand.upload(&image, false).expect("it is taken");
    stand.control(Control::Start);
    stand.board.run_us(300_000);
    time::hang(&mut stand);
    // The watchdog bites once; nothing of the step engine is left that could reset the chip again.
    stand.board.run_us(130_000);
    assert_eq!(stand.board.last_reset(), Reset::Watchdog);
    assert!(stand.answers());
}
