//! Inputs that a host forces: command 110 (InterpCNC V3 Modbus protocol, Commands).

use lang::profile::{Input, InputRole};
use lang::wire::{RunState, command};

use crate::commands::{BUSY, ILLEGAL, board, mill, order};
use crate::live::Live;

const FREE: u16 = 0xFFFF;

/// Command 110.
fn force(live: &mut Live, input: u16, level: u16) -> u8 {
    order(live, command::FORCE_INPUT, &[&[input, level]])
}

fn inputs(live: &Live) -> u16 {
    live.board.peek16(live.at("INPUT"))
}

#[test]
fn a_forced_input_keeps_its_level_until_it_is_freed() {
    let mut live = board("Wait 1s\n");
    live.board.plant_mut().set_input(2, true);
    live.run_ms(50);
    let before = inputs(&live);
    assert_eq!(before & 0x8003, 2);
    assert_eq!([force(&mut live, 0, 1), force(&mut live, 1, 0), force(&mut live, 15, 1)], [0; 3]);
    assert_eq!(inputs(&live), before & !2 | 0x8001);
    live.board.plant_mut().set_input(1, true);
    live.run_ms(50);
    live.board.plant_mut().set_input(1, false);
    live.run_ms(50);
    assert_eq!(inputs(&live), before & !2 | 0x8001);
    assert_eq!(force(&mut live, 15, 0), 0);
    assert_eq!(inputs(&live), before & !2 | 1);
    for input in [0, 1, 15] {
        assert_eq!(force(&mut live, input, FREE), 0);
    }
    live.run_ms(50);
    assert_eq!(inputs(&live), before);
    // A reset frees what was forced.
    assert_eq!(force(&mut live, 4, 1), 0);
    live.board.reset_pin();
    live.run_ms(100);
    assert_eq!(inputs(&live), before);
}

#[test]
fn a_run_takes_it_and_sees_it() {
    let mut live = board("WaitIn 5, On\nWait 100s\n");
    live.start();
    live.run_ms(50);
    let waits = live.board.peek16(live.at("EFFECT_PC"));
    assert_eq!(force(&mut live, 4, 1), 0);
    live.run_ms(50);
    assert_ne!(live.board.peek16(live.at("EFFECT_PC")), waits);
    assert_eq!(live.state(), RunState::Running);
    // No more than this command has is taken in a run.
    assert_eq!(order(&mut live, command::FORCE_INPUT, &[&[4, 1, 0]]), BUSY);
    assert_eq!(force(&mut live, 4, FREE), 0);
    live.run_ms(50);
    assert_eq!(inputs(&live) & 1 << 4, 0);
}

#[test]
fn what_stops_the_machine_is_never_forced() {
    let mut profile = mill();
    let roles = [
        (12, InputRole::EmergencyStop),
        (13, InputRole::Start),
        (14, InputRole::Stop),
        (15, InputRole::Hold),
        (16, InputRole::Door),
    ];
    for (n, role) in roles {
        profile.inputs.retain(|input| input.n != n && input.role != Some(role));
        let invert = false;
        profile.inputs.push(Input { n, name: None, role: Some(role), invert, filter_ms: 5 });
    }
    let mut live = Live::new(&profile, "Wait 1s\n");
    let before = inputs(&live);
    for (n, role) in roles {
        let expected = if role == InputRole::Start { 0 } else { ILLEGAL };
        assert_eq!(force(&mut live, n as u16 - 1, 1), expected, "{role:?}");
    }
    // The mill's reference switches are inputs 8 to 10 from 0.
    for input in [8, 9, 10, 16, 255, 256] {
        assert_eq!(force(&mut live, input, 1), ILLEGAL, "{input}");
    }
    for level in [2, 3, 256, 0x7FFF, 0xFFFE] {
        assert_eq!(force(&mut live, 0, level), ILLEGAL, "{level}");
    }
    assert_eq!(order(&mut live, command::FORCE_INPUT, &[&[0]]), ILLEGAL, "no level");
    assert_eq!(inputs(&live), before | 1 << 12, "Start alone");
    assert_eq!(live.state(), RunState::Ready);
}
