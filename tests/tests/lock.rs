//! A locked board: nothing brings another program or profile to it, or reads one back, but the code
//! (`lang::wire`, Lock). On both parts, with the shipped firmware in the emulator.

use emulator::Config;
use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};
use lang::profile::Profile;
use lang::record::BoardRecord;
use lang::wire::{
    BLOCKS, Control, Exception, LOCK_CODE, PROFILE_HASH, PROFILE_WINDOW, RunState, Table,
    UPLOAD_CONTROL, UPLOAD_LENGTH, UPLOAD_WINDOW, Upload,
};
use pasapas::board::{BUILDS, Build};
use pasapas::client::lock::words_of;
use pasapas::torture::stand::{Answer, Stand, identity, read_body};

/// The right code.
const CODE: &str = "tilleul";
/// Longest wait for a short run, us.
const RUN_US: u64 = 400_000;

fn image(build: &Build, script: &str) -> Vec<u8> {
    let source = Source::new("test.bas", script.to_owned());
    let (program, _) = compile(&source, ProfileChoice::built_in());
    let compiled = lang::back::compile(&program.expect("the script is sound")).expect("it fits");
    assert!(compiled.image.len() < build.part.room_for(false));
    compiled.image
}

fn refused() -> Answer {
    Answer::Exception(Exception::DeviceFailure as u8)
}

/// The record of the built-in profile `mill` with a lock code.
fn record(sequence: u16, lock: [u16; 2]) -> Vec<u16> {
    let mill = Profile::built_in("mill").expect("built in");
    let record = BoardRecord { lock, ..BoardRecord::of(&mill, sequence) }.sealed();
    record.to_bytes().chunks_exact(2).map(|pair| u16::from_le_bytes([pair[0], pair[1]])).collect()
}

fn set_profile(stand: &mut Stand, words: &[u16]) -> Answer {
    match stand.write(PROFILE_WINDOW, &words[..16]) {
        Answer::Reply(_) => stand.write(PROFILE_WINDOW + 16, &words[16..]),
        other => other,
    }
}

/// A board with a program and a lock, behind the reset from which it holds.
fn locked(build: &Build) -> (Stand, Vec<u8>) {
    let program = image(build, "SetOut 1, ON\nWait 5ms\nSetOut 1, OFF");
    let mut stand = Stand::new(build, &Config::default()).expect("the shipped image");
    stand.upload(&program, false).expect("a board without a lock takes a program");
    assert!(matches!(set_profile(&mut stand, &record(1, words_of(CODE))), Answer::Reply(_)));
    assert!(stand.power_cycle());
    (stand, program)
}

fn unlock(stand: &mut Stand, code: &str) -> Answer {
    stand.write(LOCK_CODE, &words_of(code))
}

/// Whatever replaces a program or a profile is refused, and the program is the one that it was.
fn holds(stand: &mut Stand, program: &[u8]) {
    for code in [Upload::Begin, Upload::Replace, Upload::Commit, Upload::Erase] {
        stand.write(UPLOAD_LENGTH, &[8]);
        assert_eq!(stand.write(UPLOAD_CONTROL, &[code as u16]), refused(), "{code:?}");
    }
    assert_eq!(stand.write(UPLOAD_WINDOW, &[0]), refused());
    assert_eq!(set_profile(stand, &record(2, [0, 0])), refused());
    for register in 0..32 {
        if !(LOCK_CODE..LOCK_CODE + 2).contains(&(PROFILE_WINDOW + register)) {
            assert_eq!(stand.write(PROFILE_WINDOW + register, &[0]), refused(), "{register}");
        }
    }
    assert_eq!(stand.stored(), Some(identity(program)));
}

#[test]
fn a_locked_board_gives_up_nothing_and_runs() {
    for build in BUILDS {
        let (mut stand, program) = locked(build);
        holds(&mut stand, &program);
        assert_eq!(stand.read(PROFILE_HASH), Some(0));
        assert!(matches!(stand.control(Control::Start), Answer::Reply(_)));
        stand.board.run_us(RUN_US);
        assert_eq!(stand.state(), Some(RunState::Ready as u16));
        holds(&mut stand, &program);
    }
}

#[test]
fn no_request_reads_program_profile_or_code_of_a_locked_board() {
    for build in BUILDS {
        let (mut stand, program) = locked(build);
        let code = words_of(CODE);
        let window: Vec<[u8; 4]> =
            program.windows(4).map(|part| [part[0], part[1], part[2], part[3]]).collect();
        for block in BLOCKS.iter().filter(|block| block.table >= Table::Holding as u8) {
            let mut all = Vec::new();
            for first in (0..block.count).step_by(32) {
                let count = (block.count - first).min(32) as u8;
                let mut body = read_body(block.first + first, count);
                body[1] = block.table;
                if let Answer::Reply(reply) = stand.ask(&body) {
                    all.extend_from_slice(&reply[3..]);
                }
            }
            let words: Vec<u16> =
                all.chunks_exact(2).map(|pair| u16::from_be_bytes([pair[0], pair[1]])).collect();
            assert!(!words.windows(2).any(|pair| pair == code), "code in block {}", block.first);
            // Four bytes of the program that are not just zeroes, in either order of a register.
            let swapped: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
            for bytes in [&all, &swapped] {
                let shown = bytes.windows(4).any(|part| {
                    part.iter().all(|&byte| byte != 0) && window.iter().any(|held| held == part)
                });
                assert!(!shown, "a part of the program in block {}", block.first);
            }
            if block.first == PROFILE_WINDOW {
                assert!(words.iter().all(|&word| word == 0));
            }
        }
    }
}

#[test]
fn the_right_code_opens_until_the_next_reset() {
    for build in BUILDS {
        let (mut stand, program) = locked(build);
        assert!(matches!(unlock(&mut stand, CODE), Answer::Reply(_)));
        assert_ne!(stand.read(PROFILE_HASH), Some(0));
        let other = image(build, "SetOut 2, ON");
        stand.upload(&other, false).expect("an open board takes a program");
        assert_eq!(stand.stored(), Some(identity(&other)));
        assert!(stand.power_cycle());
        holds(&mut stand, &other);
        // The lock goes with the code that made it.
        assert!(matches!(unlock(&mut stand, CODE), Answer::Reply(_)));
        assert!(matches!(set_profile(&mut stand, &record(2, [0, 0])), Answer::Reply(_)));
        assert!(stand.power_cycle());
        stand.upload(&program, false).expect("a board without a lock takes a program");
    }
}

#[test]
fn behind_a_wrong_code_the_right_one_is_wrong_until_reset() {
    for build in BUILDS {
        let (mut stand, program) = locked(build);
        let [low, high] = words_of(CODE);
        // Each half wrong, the high one alone, none.
        let wrong: [&[(u16, u16)]; 4] = [
            &[(0, low ^ 1), (1, high)],
            &[(0, low), (1, high ^ 0x8000)],
            &[(0, 0), (0, low), (1, high)],
            &[(1, high ^ 1), (0, low), (1, high)],
        ];
        for tries in wrong {
            let (last, before) = tries.split_last().expect("not empty");
            for (register, word) in before {
                stand.write(LOCK_CODE + register, &[*word]);
            }
            assert_eq!(stand.write(LOCK_CODE + last.0, &[last.1]), refused(), "{tries:?}");
            assert_eq!(unlock(&mut stand, CODE), refused());
            holds(&mut stand, &program);
            assert!(stand.power_cycle());
        }
        // The high word alone opens nothing.
        assert_eq!(stand.write(LOCK_CODE + 1, &[high]), refused());
        assert!(matches!(unlock(&mut stand, CODE), Answer::Reply(_)));
    }
}

#[test]
fn a_power_cut_at_any_flash_operation_leaves_the_lock_closed() {
    for build in BUILDS {
        let (stand, program) = locked(build);
        let other = record(2, words_of("sapin"));
        let mut cuts = 0;
        loop {
            let mut stand = stand.clone();
            assert!(matches!(unlock(&mut stand, CODE), Answer::Reply(_)));
            stand.board.cut_at_flash_operation(cuts + 1, cuts);
            let done = matches!(set_profile(&mut stand, &other), Answer::Reply(_));
            assert!(stand.power_cycle());
            holds(&mut stand, &program);
            let old = matches!(unlock(&mut stand, CODE), Answer::Reply(_));
            let new = !old && {
                assert!(stand.power_cycle());
                matches!(unlock(&mut stand, "sapin"), Answer::Reply(_))
            };
            assert!(old || new, "no code opens behind a cut at operation {}", cuts + 1);
            assert!(new || !done);
            cuts += 1;
            if done {
                break;
            }
        }
        assert!(cuts > 30, "a profile is 32 words: {cuts}");
    }
}
