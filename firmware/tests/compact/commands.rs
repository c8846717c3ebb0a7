//! Commands over the link on the running board (InterpCNC V3 Modbus protocol, Commands).

use emulator::plant::Contact;
use lang::profile::{Input, InputRole, Profile};
use lang::wire::{CRC_START, Control, Exception, RunState, command, crc16};

use crate::live::Live;

/// Illegal value, as the board answers.
pub const ILLEGAL: u8 = Exception::IllegalValue as u8;
/// Busy.
pub const BUSY: u8 = Exception::Busy as u8;

/// The mill.
pub fn mill() -> Profile {
    Profile::built_in("mill").expect("mill is built in")
}

/// A mill with this program.
pub fn board(script: &str) -> Live {
    Live::new(&mill(), script)
}

/// Low word and high word.
pub fn long(value: i32) -> [u16; 2] {
    let bits = value.cast_unsigned();
    [bits as u16, (bits >> 16) as u16]
}

/// Writes registers by function 16 and brings the exception, 0 for none.
fn write(live: &mut Live, first: u16, values: &[u16]) -> u8 {
    let count = u16::try_from(values.len()).expect("few");
    let mut frame = vec![1, 16];
    frame.extend([first, count].iter().flat_map(|word| word.to_be_bytes()));
    frame.push(2 * values.len() as u8);
    frame.extend(values.iter().flat_map(|word| word.to_be_bytes()));
    let crc = frame.iter().fold(CRC_START, |crc, &byte| crc16(crc, byte));
    frame.extend(crc.to_le_bytes());
    live.board.uart_take();
    live.board.uart_send(&frame);
    live.run_ms(40);
    let reply: Vec<u8> = live.board.uart_take().into_iter().map(|(_, byte)| byte).collect();
    match reply[..] {
        [1, 0x90, exception, ..] => exception,
        [1, 16, ..] => 0,
        _ => panic!("{reply:?}"),
    }
}

/// Writes a command with its arguments.
pub fn order(live: &mut Live, code: u16, arguments: &[&[u16]]) -> u8 {
    let words: Vec<u16> = [code].into_iter().chain(arguments.concat()).collect();
    write(live, lang::wire::COMMAND, &words)
}

/// Command 103 at 2000 steps/s.
pub fn move_to(live: &mut Live, axis: u16, target: i32) -> u8 {
    let [ramp, speed] = [long(20_000), long(2_000)];
    order(live, command::MOVE_TO, &[&[axis], &ramp, &speed, &ramp, &long(target)])
}

/// Command 106 on input `input` from 0: 1000 and 200 steps/s, 2000 steps at most, 10 ms of rest.
fn home(live: &mut Live, input: u16, level: u16, positive: u16, place: i32, clearance: i32) -> u8 {
    let [fast, slow, ramp] = [long(1_000), long(200), long(20_000)];
    let head = [1, 0, input, level, positive];
    let tail = [long(2_000).as_slice(), &[10], &long(place), &long(clearance)].concat();
    order(live, command::HOME, &[&head, &fast, &slow, &ramp, &ramp, &tail])
}

#[test]
fn an_axis_moves_to_a_work_position() {
    let mut live = board("Wait 1s\n");
    assert_eq!(move_to(&mut live, 1, 500), 0);
    live.run_ms(1_000);
    assert_eq!(live.motors(), [500, 0, 0]);
    // The present position becomes 100, by the command and by the register.
    assert_eq!(order(&mut live, command::SET_POSITION, &[&[1], &long(100)]), 0);
    assert_eq!(move_to(&mut live, 1, 50), 0);
    assert_eq!(move_to(&mut live, 2, 50), BUSY);
    live.run_ms(1_000);
    assert_eq!(live.motors(), [450, 0, 0]);
    assert_eq!(write(&mut live, lang::wire::POSITIONS, &long(0)), 0);
    assert_eq!(move_to(&mut live, 1, -20), 0);
    live.run_ms(500);
    assert_eq!(live.motors(), [430, 0, 0]);
    assert_eq!(live.longs("STEPS"), [430, 0, 0]);
}

#[test]
fn an_axis_moves_by_a_distance() {
    let mut live = board("Wait 1s\n");
    let by = |live: &mut Live, distance| {
        let [ramp, speed] = [long(20_000), long(2_000)];
        order(live, command::MOVE_BY, &[&[1], &ramp, &speed, &ramp, &long(distance)])
    };
    assert_eq!(order(&mut live, command::SET_POSITION, &[&[1], &long(100)]), 0);
    for (distance, place) in [(300, 300), (-70, 230)] {
        assert_eq!(by(&mut live, distance), 0);
        assert_eq!(by(&mut live, 1), BUSY);
        live.run_ms(1_000);
        assert_eq!(live.motors(), [place, 0, 0]);
    }
    assert_eq!(by(&mut live, i32::MAX), ILLEGAL);
}

#[test]
fn arguments_out_of_range_are_refused() {
    let mut live = board("Wait 1s\n");
    let [ramp, none] = [long(20_000), long(0)];
    assert_eq!(move_to(&mut live, 0, 5), ILLEGAL);
    assert_eq!(move_to(&mut live, 4, 5), ILLEGAL);
    let stands = [&[1u16][..], &ramp, &none, &ramp, &long(5)];
    assert_eq!(order(&mut live, command::MOVE_TO, &stands), ILLEGAL);
    assert_eq!(order(&mut live, 999, &[&[1]]), ILLEGAL);
    assert_eq!(order(&mut live, command::DIRECT, &[&[7]]), ILLEGAL);
    assert_eq!(home(&mut live, 17, 1, 0, 0, 0), ILLEGAL);
    assert_eq!(home(&mut live, 3, 2, 0, 0, 0), ILLEGAL);
    let homed = live.at("HOMED");
    live.board.poke8(homed, 1);
    assert_eq!(move_to(&mut live, 1, -1), ILLEGAL, "beyond the travel");
    assert_eq!(live.motors(), [0; 3]);
}

#[test]
fn nothing_moves_while_an_input_blocks() {
    let mut profile = mill();
    let blocked = |profile: &Profile| {
        let mut live = Live::new(profile, "Wait 1s\n");
        live.board.plant_mut().set_input(12, true);
        live.run_ms(30);
        move_to(&mut live, 1, 10)
    };
    assert_eq!(blocked(&profile), 0);
    let role = Some(InputRole::EmergencyStop);
    profile.inputs.push(Input { n: 12, name: None, role, invert: false, filter_ms: 5 });
    assert_eq!(blocked(&profile), BUSY);
}

#[test]
fn an_axis_homes_by_the_commands_own_parameters() {
    for (level, positive, switch, place, clearance) in
        [(1, 0, -300, 40, 25), (1, 1, 300, -7, -30), (0, 0, 300, 0, 10)]
    {
        let mut live = board("Wait 1s\n").with_switch(0, switch, positive == 1 || level == 0);
        // The third switch is closed above and opens below: off means closed.
        let from = if level == 0 { 500 } else { 0 };
        if level == 0 {
            assert_eq!(move_to(&mut live, 1, from), 0);
            live.run_ms(1_500);
        }
        assert_eq!(home(&mut live, 8, level, positive, place, clearance), 0);
        live.run_ms(20);
        assert_eq!(move_to(&mut live, 2, 5), BUSY);
        live.run_ms(4_000);
        assert_eq!(live.byte("EFFECT"), 0);
        assert_eq!(live.byte("HOMING_ERROR"), 0);
        assert_eq!(live.byte("HOMED"), 1);
        assert_eq!(live.longs("ACTUAL")[0], place + clearance);
        let opens = if positive == 1 {
            299
        } else if level == 0 {
            300
        } else {
            -299
        };
        assert_eq!(live.motors()[0], opens + i64::from(clearance), "level {level}");
    }
}

#[test]
fn a_reference_run_by_the_profile_may_fail_or_be_stopped() {
    let mut profile = mill();
    for axis in [&mut profile.x, &mut profile.y, &mut profile.z].into_iter().flatten() {
        axis.home.stroke_um = 10_000;
    }
    let mut live = Live::new(&profile, "Wait 1s\n").with_switch(1, -200, false);
    assert_eq!(order(&mut live, command::HOME_PROFILE, &[&[2]]), 0);
    live.run_ms(4_000);
    assert_eq!((live.byte("HOMED"), live.byte("HOMING_ERROR")), (2, 0));
    assert_eq!(order(&mut live, command::HOME_PROFILE, &[&[1]]), 0);
    live.run_ms(4_000);
    assert_eq!((live.byte("HOMED"), live.byte("HOMING_ERROR")), (2, 1));
    assert_eq!(order(&mut live, command::HOME_PROFILE, &[&[3]]), 0);
    live.run_ms(50);
    assert_eq!(order(&mut live, command::STOP_AXES, &[&[7]]), 0);
    live.run_ms(300);
    assert_eq!((live.byte("EFFECT"), live.byte("HOMING_ERROR")), (0, 5));
    let rests = live.motors();
    live.run_ms(300);
    assert_eq!(live.motors(), rests);
    assert_eq!(live.longs("STEPS").map(i64::from)[2], rests[2]);
}

#[test]
fn an_axis_probes_by_command() {
    let probe = |live: &mut Live, input, level, distance: i32| {
        let [ramp, speed] = [long(20_000), long(300)];
        order(live, command::PROBE, &[&[3, input, level], &ramp, &speed, &ramp, &long(distance)])
    };
    let mut live = board("Wait 1s\n");
    let contact = Contact { axis: 2, position: -90, above: false };
    live.board.plant_mut().probes[2] = Some(contact);
    assert_eq!(probe(&mut live, 16, 1, -50), 0);
    live.run_ms(1_000);
    assert_eq!((live.byte("PROBE_OK"), live.byte("PROBE_ERROR")), (0, 4));
    assert_eq!(probe(&mut live, 16, 1, -200), 0);
    live.run_ms(1_000);
    assert_eq!((live.byte("PROBE_OK"), live.byte("PROBE_ERROR")), (4, 0));
    assert_eq!(live.longs("PROBED")[2], -90);
    // It answers already.
    assert_eq!(probe(&mut live, 16, 1, -200), 0);
    live.run_ms(100);
    assert_eq!((live.byte("PROBE_OK"), live.byte("PROBE_ERROR")), (0, 4));
    assert_eq!(live.byte("EFFECT"), 0);
    assert_eq!(probe(&mut live, 17, 1, -200), ILLEGAL);
    assert_eq!(probe(&mut live, 256, 1, -200), ILLEGAL);
}

#[test]
fn an_axis_probes_by_masks() {
    let mut live = board("Wait 1s\n");
    let probe = |live: &mut Live, and, xor| {
        let [ramp, speed] = [long(20_000), long(300)];
        let pace = [ramp, speed, ramp].concat();
        order(live, command::PROBE_MASK, &[&[1], &long(and), &long(xor), &pace, &long(900)])
    };
    // Input 3 on or input 4 off: input 4 is off.
    assert_eq!(probe(&mut live, 12, 8), 0);
    live.run_ms(100);
    assert_eq!((live.byte("PROBE_OK"), live.byte("PROBE_ERROR")), (0, 1));
    live.board.plant_mut().set_input(4, true);
    live.run_ms(100);
    assert_eq!(probe(&mut live, 12, 8), 0);
    live.run_ms(500);
    live.board.plant_mut().set_input(3, true);
    live.run_ms(500);
    assert_eq!((live.byte("PROBE_OK"), live.byte("PROBE_ERROR")), (1, 0));
    let at = live.longs("PROBED")[0];
    assert!((130..180).contains(&at), "{at}");
}

#[test]
fn a_run_takes_stops_and_direct_functions_only() {
    let mut live = board("MoveAxe X, 20mm\nWait 10s\n");
    live.start();
    assert_eq!(move_to(&mut live, 1, 5), BUSY);
    assert_eq!(order(&mut live, command::DIRECT, &[&[130]]), 0);
    live.run_ms(300);
    assert_eq!(live.state(), RunState::Paused);
    assert_eq!(order(&mut live, command::DIRECT, &[&[129]]), 0);
    live.run_ms(300);
    assert_eq!(live.state(), RunState::Running);
    assert_eq!(order(&mut live, command::STOP_AXIS, &[&[1]]), 0);
    live.run_ms(1_000);
    assert_eq!(live.state(), RunState::Ready);
    assert_eq!(write(&mut live, lang::wire::RUN_CONTROL, &[Control::Start as u16]), 0);
    live.run_ms(30);
    assert_eq!(live.state(), RunState::Running);
    assert_eq!(order(&mut live, command::DIRECT, &[&[255]]), 0);
    live.run_ms(1_000);
    assert_eq!(live.state(), RunState::Ready);
}

#[test]
fn a_reference_run_watches_no_probe_that_was_given_up() {
    let mut live = board("Probe Z, -10mm, 1mm/s\n").with_switch(0, -200, false);
    live.start();
    live.run_ms(100);
    assert_ne!(live.byte("WATCH"), 0);
    assert_eq!(order(&mut live, command::STOP_AXIS, &[&[1]]), 0);
    live.run_ms(300);
    assert_eq!(live.state(), RunState::Ready);
    assert_eq!(order(&mut live, command::HOME_PROFILE, &[&[1]]), 0);
    live.run_ms(100);
    assert_eq!(live.byte("WATCH"), 0, "it would write where the switch opened");
    live.run_ms(3_000);
    assert_eq!(live.byte("HOMED"), 1);
    assert_eq!(live.longs("ACTUAL")[0], 0);
}
