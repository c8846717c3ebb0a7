use super::*;

mod numbers;

const MACHINE: &str = r#"pub trait Machine {
    #[cfg_attr(any(), micro(any = "RUN, RUN_ACTIVE"))]
    fn is_active(&self) -> bool;
    #[cfg_attr(any(), micro(place = "EFFECT"))]
    fn effect(&self) -> u8;
    #[cfg_attr(any(), micro(code = "DO first", or = "DO second", holds = "NOT_EQUAL"))]
    fn either(&self) -> bool;
    #[cfg_attr(any(), micro(code = "DO axis_n"))]
    fn axis(&self) -> Axis;
    #[cfg_attr(any(), micro(place = "EFFECT_PC"))]
    fn pc(&self) -> u16;
    #[cfg_attr(any(), micro(place = "VM_CODE"))]
    fn code(&self) -> u16;
    #[cfg_attr(any(), micro(any = "TRACING, T_ON", bit = 1))]
    fn traces(&self) -> bool;
    #[cfg_attr(any(), micro(place = "PHASE"))]
    fn phase(&self) -> u8;
    #[cfg_attr(any(), micro(place = "PHASE"))]
    fn set_phase(&mut self, phase: u8);
    #[cfg_attr(any(), micro(place = "UM"))]
    fn um(&self, axis: Axis) -> i32;
    #[cfg_attr(any(), micro(place = "UM"))]
    fn set_um(&mut self, axis: Axis, um: i32);
    #[cfg_attr(any(), micro(code = "DO to_um", holds = "CARRY"))]
    fn to_um(&self, axis: Axis, steps: i32) -> Option<i32>;
    #[cfg_attr(any(), micro(record = "A_MAX"))]
    fn max(&self, axis: Axis) -> i32;
    #[cfg_attr(any(), micro(has = "HOMED"))]
    fn is_homed(&self, axis: Axis) -> bool;
    #[cfg_attr(any(), micro(off = "HOMED"))]
    fn forget(&mut self, axis: Axis);
    #[cfg_attr(any(), micro(code = "DO time_up", holds = "EQUAL"))]
    fn is_over(&self) -> bool;
    #[cfg_attr(any(), micro(code = "POP_NUMBER {least}, {most}"))]
    fn pop(&mut self, least: u8, most: u8) -> Result<u8, Fault>;
    #[cfg_attr(any(), micro(code = "EVENT {kind}", leaves = 0))]
    fn tell(&mut self, kind: TraceKind, value: i32);
    #[cfg_attr(any(), micro(code = "", sure = 1))]
    fn must(&self) -> Result<(), Fault>;
    #[cfg_attr(any(), micro(code = "DO input"))]
    fn input(&self, n: u8) -> u8;
    #[cfg_attr(any(), micro(code = "DO axis_there", holds = "NOT_EQUAL"))]
    fn is_there(&self, axis: Axis) -> bool;
    #[cfg_attr(any(), micro(on = "HOMED"))]
    fn set_homed(&mut self, axis: Axis);
    #[cfg_attr(any(), micro(code = "DO rate_of"))]
    fn rate(&mut self, axis: Axis, value: i32) -> Scaled;
    #[cfg_attr(any(), micro(place = "SPARE"))]
    fn spare(&self) -> Scaled;
    #[cfg_attr(any(), micro(place = "SPARE"))]
    fn spare_long(&self) -> i32;
    #[cfg_attr(any(), micro(code = "F bound TEMP"))]
    fn least(&mut self, rate: Scaled) -> Scaled;
    #[cfg_attr(any(), micro(record = "A_STEPS"))]
    fn steps(&self, axis: Axis) -> u16;
    #[cfg_attr(any(), micro(any = "BITS, IT", when = "HAS_IT"))]
    fn has_it(&self) -> bool;
    #[cfg_attr(any(), micro(code = "DO axis_pace"))]
    fn take_pace(&mut self, axis: Axis);
    #[cfg_attr(any(), micro(code = "DO output_states"))]
    fn states(&mut self, n: u8);
    #[cfg_attr(any(), micro(is = "RUN, RUN_FAULT"))]
    fn is_fault(&self) -> bool;
    #[cfg_attr(any(), micro(any = "MOTION, M_NEXT", when = "HAS_COURSES"))]
    fn has_next(&self) -> bool;
    #[cfg_attr(any(), micro(code = "LIT 0; F store LEFT"))]
    fn drop_next(&mut self);
    #[cfg_attr(any(), micro(code = "BITS_OFF MOTION, M_NEXT", when = "HAS_COURSES"))]
    fn forget_next(&mut self);
    #[cfg_attr(any(), micro(code = "LET BITS, 1; UP PHASE", when = "HAS_IT", or = "LET PHASE, 0"))]
    fn have_it(&mut self);
    #[cfg_attr(any(), micro(place = "LEFT"))]
    fn set_left(&mut self, number: Scaled);
    #[cfg_attr(any(), micro(code = "", ends = "inc &RUNS; br #motion_reset"))]
    fn begun(&mut self);
}"#;

fn lowered(rules: &str) -> Result<Made, Refused> {
    let rules = format!("#![cfg_attr(any(), micro(module = \"test\"))]\n{rules}");
    let made = lower(&[("rules", MACHINE)], &[("test", &rules)]).map_err(|(_, refused)| refused)?;
    Ok(made.into_iter().next().expect("one file"))
}

fn made(rules: &str) -> String {
    let made = lowered(rules).unwrap_or_else(|refused| panic!("{refused}"));
    made.text.lines().skip(4).map(str::trim).collect::<Vec<_>>().join("; ")
}

#[test]
fn a_number_or_nothing_is_a_jump_over_it() {
    let rule = "fn a(m: &impl Machine) -> u16 { if m.is_active() { 1 << 10 } else { 0 } }";
    let code =
        "a:; IF_NONE RUN, RUN_ACTIVE, .Ltest_m0; LIT16 1024; .Ltest_m0:; RETURN; .balign 2, 0";
    assert_eq!(made(rule), code);
}

#[test]
fn words_share_their_end() {
    let rule = "fn a(m: &impl Machine) -> u16 { let mut w = 0; if m.either() { w |= 3 << 7; } w }
        fn b(m: &impl Machine) -> u16 {
            let mut w = u16::from(m.effect()) << 8; let axis = m.axis(); w |= u16::from(axis.bit()); w }";
    let a = "a:; F clear TEMP; DO first; IF_NOT_EQUAL .Ltest_2; DO second; IF_EQUAL .Ltest_m0; .Ltest_2:; \
        BITS_ON TEMP, 0x80; BITS_ON TEMP+1, 0x1; GOTO .Ltest_m0";
    let b = "b:; F clear TEMP; GET EFFECT; PUT TEMP+1; DO axis_n; DO axis_bit; AXIS_ON TEMP; .Ltest_m0:; \
        F word TEMP; RETURN; .balign 2, 0";
    assert_eq!(made(rule), format!("{a}; {b}"));
}

#[test]
fn a_leaf_is_a_result_and_differences_share_their_end() {
    let rule = "fn a(m: &impl Machine) -> u16 { m.pc().wrapping_sub(m.code()) }
        fn b(m: &impl Machine) -> u16 { m.code().wrapping_sub(m.code()) }
        fn c(m: &impl Machine) -> u16 { u16::from(m.traces()) }";
    let code = "a:; F word EFFECT_PC; GOTO .Ltest_m0; b:; F word VM_CODE; .Ltest_m0:; F sub VM_CODE; RETURN; c:; \
        .if T_ON != 1; .error \"a leaf's bit\"; .endif; GET TRACING; ANDI T_ON; RETURN; .balign 2, 0";
    assert_eq!(made(rule), code);
    let rule = "fn a(m: &impl Machine) -> u16 { u16::from(m.is_active()) }";
    let refused = lowered(rule).expect_err("a bit whose value is not told");
    assert!(refused.text.contains("a leaf of code"), "{refused}");
}

#[test]
fn a_value_stays_where_it_is() {
    let rule = "fn a(m: &mut impl Machine, axis: Axis, steps: i32) -> Result<(), Fault> {
        let um = m.to_um(axis, steps).ok_or(Fault::Overflow)?;
        m.set_um(axis, um);
        if m.is_homed(axis) && m.max(axis).wrapping_sub(m.um(axis)) < 0 { return Err(Fault::SoftLimit); }
        Ok(())
    }";
    // Nothing is known of the record at the entry of a function without a row.
    let code = "a:; DO axis_at; DO to_um; IF_CARRY .Ltest_1; F store UM, AXIS; IF_NOT_AXIS HOMED, .Ltest_2; \
        FR load A_MAX, LONG; F sub UM, AXIS; IF_NOT_NEGATIVE .Ltest_2; FAULT F_SOFT_LIMIT; .Ltest_2:; DONE_; \
        .Ltest_1:; FAULT F_OVERFLOW; .balign 2, 0";
    assert_eq!(made(rule), code);
}

#[test]
fn a_wait_asks_first_of_all_and_returns_by_itself() {
    let rule = "fn a(m: &mut impl Machine, first: bool) -> Progress {
        if first { let n = m.pop(1, 17)?; m.set_phase(n); }
        if !m.is_over() { return NOT_YET; }
        m.tell(TraceKind::WaitIn, i32::from(m.phase()));
        DONE
    }";
    let code = "a:; IF_NOT_EQUAL .Ltest_1; POP_NUMBER 1, 17; PUT PHASE; .Ltest_1:; DO time_up; GET PHASE; \
        EVENT TRACE_WAIT_IN; RETURN; .balign 2, 0";
    assert_eq!(made(rule), code);
}

#[test]
fn what_never_fails_leaves_nothing_to_return() {
    let rule =
        "fn a(m: &mut impl Machine) -> Progress { m.set_phase(m.input(1)); m.must()?; DONE }";
    assert_eq!(made(rule), "a:; LIT 1; DO input; PUT PHASE; DONE_; .balign 2, 0");
}

#[test]
fn phases_are_a_switch_and_the_next_one_is_up() {
    let rule = "const BEGIN: u8 = 1; const REST: u8 = 2;
        fn a(m: &mut impl Machine) -> Progress { match m.phase() {
            BEGIN => { m.set_phase(REST); NOT_YET }
            REST => NOT_YET,
            _ => DONE,
        } }";
    let code = "a:; GET PHASE; DO micro_switch; .byte 0; TO .Ltest_1; TO .Ltest_m0; TO .Ltest_3; PLACES_END; \
        .Ltest_3:; DONE_; .Ltest_1:; UP PHASE; .Ltest_m0:; NOT_YET_; .balign 2, 0";
    assert_eq!(made(rule), code);
}

#[test]
fn what_is_illegal_is_refused_by_one_operation() {
    let rule = "fn a(m: &mut impl Machine, axis: Axis) -> Answer {
            if m.pc() >= 17 { return Err(Exception::IllegalValue); }
            if m.pc() & 7 == 0 { return Err(Exception::IllegalValue); }
            if !m.is_there(axis) { return Err(Exception::IllegalValue); }
            if m.um(axis) == 0 { return Err(Exception::IllegalValue); }
            b(m).map_err(|_| Exception::IllegalValue)?;
            Err(Exception::Busy)
        }
        fn b(m: &mut impl Machine) -> Result<(), Fault> { m.set_phase(3); Ok(()) }";
    let code = "a:; F word EFFECT_PC; BELOW 17; TESTI 7; WANTED; DO axis_at; DO axis_there; WANTED; F load UM, AXIS; \
        DO test_long; WANTED; CALL b; BELOW 1; LIT EX_BUSY; RETURN; .global b; ROUTINE_ODD b, module.test; \
        LET PHASE, 3; DONE_; .balign 2, 0";
    assert_eq!(made(rule), code);
}

#[test]
fn a_word_is_matched_by_how_far_it_lies_below_the_last_one() {
    let rule = "fn a(m: &mut impl Machine) -> Answer { match m.pc() {
            1000 => { m.states(2); Ok(()) }
            1002 => { m.states(0); Ok(()) }
            _ => Err(Exception::IllegalValue),
        } }
        fn b(m: &mut impl Machine) -> Answer { if m.pc() == 1000 { return Ok(()); } Err(Exception::Busy) }";
    // What is subtracted is what the arm wants already, so both are the same.
    let code = "a:; LIT16 1002; F sub EFFECT_PC; BELOW 3; DO micro_switch; TO .Ltest_2; TO .Ltest_3; TO .Ltest_m1; \
        PLACES_END; .Ltest_3:; LIT EX_ILLEGAL_VALUE; RETURN; .Ltest_2:; .Ltest_m1:; DO output_states; \
        .Ltest_m0:; DONE_; \
        b:; LIT16 1000; F cmp EFFECT_PC; IF_EQUAL .Ltest_m0; LIT EX_BUSY; RETURN; .balign 2, 0";
    assert_eq!(made(rule), code);
}

#[test]
fn both_ways_begin_alike_and_axes_go_up() {
    let rule = "fn a(m: &mut impl Machine) { for axis in Axis::UP {
            if m.is_active() { m.set_homed(axis); } else { m.forget(axis); }
        } }";
    let code = "a:; LIT 0; DO axis_select; .Ltest_1:; DO axis_bit; IF_NONE RUN, RUN_ACTIVE, .Ltest_3; AXIS_ON HOMED; \
        GOTO .Ltest_4; .Ltest_3:; AXIS_OFF HOMED; .Ltest_4:; UP_AXIS .Ltest_1; RETURN; .balign 2, 0";
    assert_eq!(made(rule), code);
}

#[test]
fn scaled_numbers_are_formulas() {
    let rule = "fn a(m: &mut impl Machine, axis: Axis, value: i32) -> Scaled {
        m.rate(axis, value).least(m.spare()).times(Scaled::new(m.um(axis) as u32)) }";
    let code =
        "a:; DO axis_at; DO rate_of; F least SPARE; F times UM, AXIS, NEW; RETURN; .balign 2, 0";
    assert_eq!(made(rule), code);
}

#[test]
fn a_number_whose_row_tells_z_is_tested_once() {
    let rule = "fn rate(m: &mut impl Machine, axis: Axis, flags: u8) -> Scaled {
            m.set_phase(flags);
            if !m.is_active() { return Scaled::MAX; }
            let value = m.um(axis);
            rate_of(m, axis, value)
        }
        fn rate_of(m: &mut impl Machine, axis: Axis, value: i32) -> Scaled {
            let mut rate = Scaled::new(value.max(0) as u32);
            if m.traces() { rate = rate.times(Scaled::new(u32::from(m.steps(axis)))); }
            rate
        }";
    // Callers give the record alone.
    let refused = lowered(rule).expect_err("an axis");
    assert!(refused.text.contains("r8 is no longer the axis"), "{refused}");
    let code = "rate:; PUT PHASE; DO scaled_most; IF_NONE RUN, RUN_ACTIVE, .Ltest_m0; F load SPARE; \
        .global rate_of; ROUTINE_ODD rate_of, module.test; DO not_negative; DO new; IF_NONE TRACING, T_ON, .Ltest_2; \
        FR times A_STEPS, SHORT, NEW; .Ltest_2:; .Ltest_m0:; DO test_long; RETURN; .balign 2, 0";
    let made = made(&rule.replace("m.um(axis)", "m.spare_long()"));
    assert_eq!(
        made,
        format!(".global rate; ROUTINE_ODD {}", code.replacen("rate:", "rate, module.test", 1))
    );
}

#[test]
fn an_axis_is_a_result_behind_what_leaves_it() {
    let rule = "fn axis_flags(m: &mut impl Machine, flags: u8) -> Axis {
            let n = flags & 3;
            m.set_phase(n);
            let axis = Axis::new(n);
            m.take_pace(axis);
            axis
        }
        fn a(m: &mut impl Machine) { let axis = axis_flags(m, 5); m.set_homed(axis); }";
    let code = ".global axis_flags; ROUTINE_ODD axis_flags, module.test; ANDI 3; PUT PHASE; DO axis_select; DO axis_pace; \
        RETURN; a:; LIT 5; DO axis_flags; DO axis_bit; AXIS_ON HOMED; RETURN; .balign 2, 0";
    assert_eq!(made(rule), code);
}

#[test]
fn one_of_two_values_in_memory_takes_the_others_place() {
    let rule = "#[cfg_attr(any(), micro(longs = \"SPARE, SPARE_TOO\"))]
        fn a(m: &mut impl Machine, axis: Axis) {
            let a = m.rate(axis, 1);
            let b = m.rate(axis, 2);
            m.set_phase(1);
            m.least(b);
            m.least(if m.is_active() { a } else { b });
        }";
    let code = "a:; LIT 1; DO axis_at; DO rate_of; F store SPARE; LIT 2; DO rate_of; LET PHASE, 1; F store SPARE_TOO; \
        F bound TEMP; F load SPARE_TOO; IF_NONE RUN, RUN_ACTIVE, .Ltest_1; F load SPARE; .Ltest_1:; F bound TEMP; \
        RETURN; .balign 2, 0";
    assert_eq!(made(rule), code);
}

#[test]
fn what_only_some_images_have_is_the_first_of_several_conditions() {
    let rule = "fn a(m: &mut impl Machine, first: bool) -> Progress {
            if first {
                if m.has_it() && m.phase() != 0 { m.set_phase(3); }
                return b(m);
            }
            if m.is_active() { return b(m); }
            DONE
        }
        fn b(m: &mut impl Machine) -> Progress {
            if m.has_it() && m.is_active() && m.spare_long() == 0 { return DONE; }
            NOT_YET
        }";
    let code = "a:; IF_NOT_EQUAL .Ltest_1; .if HAS_IT; IF_NONE BITS, IT, b; IF_ZERO PHASE, b; LET PHASE, 3; .endif; \
        b:; .if HAS_IT; IF_NONE BITS, IT, .Ltest_4; IF_NONE RUN, RUN_ACTIVE, .Ltest_4; F load SPARE; DO test_long; \
        IF_NOT_EQUAL .Ltest_4; RETURN; .endif; .Ltest_4:; NOT_YET_; .Ltest_1:; IF_ANY RUN, RUN_ACTIVE, b; DONE_; .balign 2, 0";
    assert_eq!(made(rule), code);
}

#[test]
fn a_flag_stands_where_ways_meet_that_both_leave_it() {
    let rule = "fn a(m: &mut impl Machine, axis: Axis) {
            let mut way = m.max(axis).wrapping_sub(m.um(axis));
            if m.is_active() { way = way.wrapping_neg(); }
            if way < 0 { m.set_phase(1); }
        }";
    let code = "a:; DO axis_at; FR load A_MAX, LONG; F sub UM, AXIS; IF_NONE RUN, RUN_ACTIVE, .Ltest_1; DO negate; \
        .Ltest_1:; IF_NOT_NEGATIVE .Ltest_m0; LET PHASE, 1; .Ltest_m0:; RETURN; .balign 2, 0";
    assert_eq!(made(rule), code);
}

#[test]
fn what_is_too_far_for_a_byte_goes_by_a_step() {
    let arm = |n: u8| format!("{n} => {{ {} NOT_YET }}", format!("m.states({n}); ").repeat(12));
    let arms = (0..6).map(arm).collect::<String>();
    let code = made(&format!(
        "fn a(m: &mut impl Machine) -> Progress {{ match m.phase() {{ {arms} _ => DONE }} }}"
    ));
    let lines =
        code.split("; ").filter(|line| !line.starts_with(['.', 'P']) || line.ends_with(':'));
    let lines = lines.collect::<Vec<_>>();
    let bytes =
        |line: &&str| if line.ends_with(':') { 0 } else { ops::Op::read(line).size(&|_| true) };
    let mut steps = 0;
    for (at, line) in lines.iter().enumerate() {
        let Some(label) = line.split(' ').nth(1).filter(|word| word.starts_with(".L")) else {
            continue;
        };
        let place = lines.iter().position(|line| *line == format!("{label}:")).expect(label);
        steps += usize::from(lines[place + 1].starts_with("GOTO"));
        let between = lines[at.min(place)..at.max(place)].iter().map(bytes).sum::<usize>();
        assert!(between < 127, "{line}: {between} bytes");
    }
    assert!(steps > 0, "{code}");
}

#[test]
fn a_flag_that_a_jump_has_looked_at_is_the_result() {
    let rule = "#[cfg_attr(any(), micro(holds = \"EQUAL\"))]
        fn a(m: &mut impl Machine, axis: Axis) -> bool {
            if m.is_there(axis) { return false; }
            m.set_phase(3);
            true
        }";
    let code = "a:; DO axis_at; DO axis_there; IF_NOT_EQUAL .Ltest_m0; LET PHASE, 3; LIT 0; DO test_long; \
        .Ltest_m0:; RETURN; .balign 2, 0";
    assert_eq!(made(rule), code);
}

#[test]
fn what_only_some_parts_have_stands_between_if_and_endif() {
    let rule = "fn a(m: &mut impl Machine) { if m.has_next() { m.drop_next(); } m.forget_next(); m.set_phase(0); }";
    let code = "a:; .if HAS_COURSES; IF_NONE MOTION, M_NEXT, .Ltest_1; LIT 0; F store LEFT; .endif; .Ltest_1:; \
        .if HAS_COURSES; BITS_OFF MOTION, M_NEXT; .endif; LET PHASE, 0; RETURN; .balign 2, 0";
    assert_eq!(made(rule), code);
    // A jump that is not there is not taken.
    let rule =
        "fn a(m: &mut impl Machine) { if m.has_next() || m.is_active() { m.set_phase(3); } }";
    let code = "a:; .if HAS_COURSES; IF_ANY MOTION, M_NEXT, .Ltest_2; .endif; IF_NONE RUN, RUN_ACTIVE, .Ltest_m0; \
        .Ltest_2:; LET PHASE, 3; .Ltest_m0:; RETURN; .balign 2, 0";
    assert_eq!(made(rule), code);
    let rule =
        "fn a(m: &mut impl Machine) { if m.is_active() && m.has_next() { m.set_phase(3); } }";
    let refused = lowered(rule).expect_err("no jump where it is never so");
    assert!(refused.text.contains("is an `if` by itself"), "{refused}");
    // Not all parts end there.
    let rule = "fn a(m: &mut impl Machine) { if m.has_next() { return; } m.set_phase(3); }";
    let code = "a:; .if HAS_COURSES; IF_NONE MOTION, M_NEXT, .Ltest_1; RETURN; .endif; .Ltest_1:; LET PHASE, 3; \
        RETURN; .balign 2, 0";
    assert_eq!(made(rule), code);
}

#[test]
fn what_instructions_enter_is_gone_to_behind_their_call() {
    let rule = "#[cfg_attr(any(), micro(entry = \"go\"))]
        fn a(m: &mut impl Machine) { m.set_phase(3); m.begun(); }
        fn b(m: &mut impl Machine) { if m.is_active() { a(m); } }";
    let code = ".balign 2, 0; .global go; go:; MICRO; .Ltest_go:; LET PHASE, 3; END; inc &RUNS; br #motion_reset; \
        b:; IF_ANY RUN, RUN_ACTIVE, .Ltest_go; RETURN; .balign 2, 0";
    assert_eq!(made(rule), code);
}

#[test]
fn code_may_stand_where_it_is_called() {
    let rule = "fn a(m: &mut impl Machine) { b(m); m.set_phase(2); }
        #[cfg_attr(any(), micro(within = 1))]
        fn b(m: &mut impl Machine) { if m.is_active() { return; } m.drop_next(); }";
    let code = "a:; IF_ANY RUN, RUN_ACTIVE, .Ltest_1; LIT 0; F store LEFT; .Ltest_1:; LET PHASE, 2; RETURN; \
        .balign 2, 0";
    assert_eq!(made(rule), code);
    let rule = "fn a(m: &mut impl Machine, n: u8) { b(m); m.set_phase(n); }
        #[cfg_attr(any(), micro(within = 1))]
        fn b(m: &mut impl Machine) { m.drop_next(); }";
    let refused = lowered(rule).expect_err("a variable around it");
    assert!(refused.text.contains("what stands within has no variables"), "{refused}");
}

#[test]
fn a_file_may_be_of_some_parts() {
    let rules =
        "#![cfg_attr(any(), micro(module = \"test\", section = \"run\", when = \"HAS_LINES\"))]
        fn a(m: &mut impl Machine) { m.set_phase(2); }";
    let made = lower(&[("rules", MACHINE)], &[("test", rules)]).expect("a file of rules");
    let text = &made[0].text;
    let code = "\n    .if HAS_LINES\n    .section .text.run,\"axR\",@progbits\nmodule.test:\na:\n    LET PHASE, 2\n    RETURN\n    \
        .balign 2, 0\n    .endif\n";
    assert!(text.ends_with(code), "{text}");
}

#[test]
fn a_long_and_a_number_are_no_sum() {
    let rule = "fn a(m: &mut impl Machine, axis: Axis) -> i32 { m.um(axis).wrapping_sub(1) }";
    let refused = lowered(rule).expect_err("an operation of 8 bits");
    assert!(refused.text.contains("a number with a byte"), "{refused}");
}

#[test]
fn a_number_stands_in_front_of_the_jump_to_what_takes_it() {
    let rule = "fn a(m: &mut impl Machine) { if m.is_active() { return b(m, 3); } m.set_phase(2); }
        fn b(m: &mut impl Machine, how: u8) { m.set_phase(how); }";
    let code = "a:; LIT 3; IF_ANY RUN, RUN_ACTIVE, b; LET PHASE, 2; RETURN; b:; PUT PHASE; RETURN; .balign 2, 0";
    assert_eq!(made(rule), code);
}

#[test]
fn an_end_that_others_jump_to_goes_where_there_is_one() {
    let rule = "fn a(m: &mut impl Machine) {
        if m.is_active() || m.is_fault() { return; }
        m.set_phase(2);
    }";
    let code = "a:; IF_ANY RUN, RUN_ACTIVE, .Ltest_2; IF_IS RUN, RUN_FAULT, .Ltest_m0; LET PHASE, 2; .Ltest_2:; \
        .Ltest_m0:; RETURN; .balign 2, 0";
    assert_eq!(made(rule), code);
}

#[test]
fn what_is_overwritten_and_needed_is_put_by() {
    let rule = "#[cfg_attr(any(), micro(bytes = \"UNIT\"))]
        fn a(m: &mut impl Machine) -> Progress {
            let before = m.input(1); m.set_phase(m.input(2)); if before == m.phase() { return NOT_YET; } DONE }";
    let code = "a:; LIT 1; DO input; PUT UNIT; LIT 2; DO input; PUT PHASE; GET UNIT; COMPARE PHASE; \
        IF_NOT_EQUAL .Ltest_1; NOT_YET_; .Ltest_1:; DONE_; .balign 2, 0";
    assert_eq!(made(rule), code);
    let refused = lowered(&rule[rule.find("fn").expect("a function")..]).expect_err("no room");
    assert!(refused.text.contains("no room for a variable"), "{refused}");
}

#[test]
fn what_the_subset_lacks_is_refused_with_its_line() {
    let cases = [
        ("fn a(m: &impl Machine) -> u16 { m.pc(); m.code() }", "a leaf that writes"),
        ("fn a(m: &impl Machine) -> u32 { 3 }", "u8, u16, i32"),
        ("fn a(n: u8) -> bool { true }", "m: &impl Trait"),
        ("fn a(m: &impl Machine) -> bool { m.um() < 3 }", "as many arguments"),
        ("fn a(m: &impl Machine) -> bool { m.nothing() }", "a leaf that is true or not"),
        ("fn a(m: &impl Machine) -> bool { m.is_active() }", "leaves no flag"),
        ("fn a(m: &impl Machine) -> u16 { let mut w = 0; while m.is_active() {} w }", "a call"),
        (
            "fn a(m: &impl Machine) -> u16 { let mut w = 0; w |= u16::from(axis.bit()); w }",
            "a variable",
        ),
        ("const A: u8 = B;", "a constant is a number or says its name"),
        ("struct A;", "functions, constants, traits of leaves, use"),
        (
            "fn a(m: &mut impl Machine, first: bool) -> Progress { m.set_phase(3); if first { return DONE; } NOT_YET }",
            "asked first of all",
        ),
        (
            "fn a(m: &mut impl Machine, axis: Axis) { let other = m.axis(); m.forget(other); m.forget(axis); }",
            "one axis at a time",
        ),
    ];
    for (rule, text) in cases {
        let refused = lowered(&format!("\n{rule}")).expect_err(rule);
        assert!(refused.text.contains(text), "{rule}: {refused}");
    }
    let refused = lowered("\n\nstruct A;").expect_err("a struct");
    let text =
        "line 4: `struct A ;` is not of the subset: functions, constants, traits of leaves, use";
    assert_eq!(refused.to_string(), text);
}

#[test]
fn a_leaf_that_says_nothing_is_refused() {
    let of = |machine: &str| lower(&[("rules", machine)], &[]).expect_err("a leaf").1.text;
    assert_eq!(of("pub trait Machine { fn a(&self) -> bool; }"), "a says nothing of micro-code");
    let code =
        "pub trait Machine { #[cfg_attr(any(), micro(code = \"DO a\"))] fn a(&self) -> bool; }";
    assert!(of(code).contains("holds"));
}
