//! ON IN and ON EVERY: what is remembered, in which order it is served, what a handler leaves alone.

use lang::wire::RunState;

use crate::rig::Rig;

/// Counts edges of input 3 in `a`, of input 4 in `b`.
const HANDLERS: &str = "END\none: a = a + 1\nRETURN\ntwo: b = b + 1\nRETURN\n";

fn rig(script: &str) -> Rig {
    let mut rig = Rig::new("mill", &format!("DIM a, b\n{script}{HANDLERS}"));
    rig.start();
    rig
}

#[test]
fn edges_are_served_in_waits_and_waits_go_on() {
    let mut rig = rig("ON IN 3 RISE GOSUB one\nON IN 4 FALL GOSUB two\nWait 500ms\nPRINT a; b\n");
    for on in [true, false, true] {
        rig.input(3, on);
        rig.input(4, on);
    }
    assert_eq!(rig.state(), RunState::Running);
    rig.ms(500);
    assert_eq!(rig.printed, "21\n");
    assert_eq!(rig.state(), RunState::Ready);
}

#[test]
fn an_edge_is_remembered_once_and_in_a_pause_too() {
    let mut rig = rig("ON IN 3 RISE GOSUB one\nWait 500ms\nPRINT a\n");
    rig.stop();
    for on in [true, false, true] {
        rig.input(3, on);
    }
    rig.start();
    rig.ms(600);
    assert_eq!(rig.printed, "1\n");
}

#[test]
fn lines_that_came_together_are_served_one_behind_the_other_before_the_next_statement() {
    let script = "ON IN 3 RISE GOSUB one\nON IN 4 RISE GOSUB two\nSetOut 1, ON\nWaitIn 5, ON\nPRINT \"on\"\nEND\none: PRINT \"one\"\nRETURN\ntwo: PRINT \"two\"\nRETURN\n";
    let mut rig = Rig::new("mill", script);
    rig.start();
    let plant = rig.chip.board.plant_mut();
    for n in [5, 4, 3] {
        plant.set_input(n, true);
    }
    rig.ms(50);
    assert_eq!(rig.printed, "one\ntwo\non\n");
}

#[test]
fn ticks_keep_their_time_and_stand_still_in_a_pause() {
    let mut rig = rig("ON EVERY 100ms GOSUB one\nWait 1050ms\nON EVERY OFF\nWait 500ms\nPRINT a\n");
    rig.ms(300);
    rig.stop();
    rig.ms(1000);
    rig.start();
    rig.ms(1400);
    assert_eq!(rig.printed, "10\n");
}

#[test]
fn off_forgets_one_input_alone_and_a_wait_keeps_its_own_end() {
    let mut rig = rig(
        "ON IN 3 RISE GOSUB one\nON IN 17 RISE GOSUB two\nON IN 3 OFF\nWait 200ms\nPRINT a; b\n",
    );
    rig.input(1, true);
    rig.input(3, true);
    rig.input(17, true);
    rig.ms(150);
    assert_eq!(rig.printed, "01\n");
}

#[test]
fn a_handler_has_no_feed_and_leaves_that_of_the_program() {
    let script = "G1 X0 F600\nON IN 3 RISE GOSUB h\nWait 300ms\nEND\nh: Wait 50ms\nRETURN\n";
    let mut rig = Rig::new("mill", script);
    rig.start();
    let feed = rig.chip.long("FEED", 0);
    assert_ne!(feed, 0);
    rig.input(3, true);
    assert_eq!(rig.chip.long("FEED", 0), 0);
    rig.ms(60);
    assert_eq!(rig.chip.long("FEED", 0), feed);
    assert_eq!(rig.state(), RunState::Running);
}

#[test]
fn a_pulse_ends_in_time_while_a_handler_runs() {
    let script =
        "ON IN 3 RISE GOSUB h\nPulse 2, 150ms\nPRINT \"over\"\nEND\nh: Wait 300ms\nRETURN\n";
    let mut rig = Rig::new("mill", script);
    rig.start();
    rig.input(3, true);
    assert!(rig.output(2));
    rig.ms(120);
    assert!(!rig.output(2));
    assert_eq!(rig.printed, "");
    rig.ms(200);
    assert_eq!(rig.printed, "over\n");
}

#[test]
fn errors_find_their_lines_behind_on_lines() {
    let script = "DIM a, b\nON ERROR GOTO bad\nON IN 3 RISE GOSUB h\nON EVERY 20ms GOSUB h\nb = 1 / a\nPRINT \"next\"\nEND\nh: b = b + 1\nRETURN\nbad: PRINT ERR; \" \"; ERL\nWait 90ms\nRESUME NEXT\n";
    let mut rig = Rig::new("mill", script);
    rig.start();
    rig.ms(150);
    assert_eq!(rig.printed, "2 5\nnext\n");
    assert_eq!(rig.state(), RunState::Ready);
}
