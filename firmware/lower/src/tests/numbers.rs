//! Scaled numbers and where they are put by, loops that go on, and what parts have or do otherwise.

use super::{lowered, made};

#[test]
fn scaled_numbers_are_formulas_of_which_the_second_is_in_memory() {
    let rule = "#[cfg_attr(any(), micro(longs = \"TEMP\"))]
        fn a(m: &mut impl Machine) {
            let root = Scaled::new(9).times(m.spare()).root().shifted(-7);
            m.least(m.spare().plus(root.times(root)));
            let one = Scaled::new(1);
            m.least(m.spare().most(one).minus(m.spare()));
        }";
    let code = "a:; LIT 9; DO new; F times SPARE; DO root; SHIFT -7; F store TEMP; F times TEMP; F plus SPARE; F bound TEMP; \
        LIT 1; DO new; F most SPARE; F minus SPARE; F bound TEMP; RETURN; .balign 2, 0";
    assert_eq!(made(rule), code);
}

#[test]
fn one_scaled_number_is_below_another_by_carry() {
    let rule = "fn a(m: &mut impl Machine, rate: Scaled) {
            if rate < m.spare() { m.set_phase(1); }
            if m.spare() >= m.spare() { m.set_phase(2); }
        }";
    let code = "a:; F sub SPARE; IF_CARRY .Ltest_1; LET PHASE, 1; .Ltest_1:; F load SPARE; F sub SPARE; IF_CARRY .Ltest_3; \
        RETURN; .Ltest_3:; LET PHASE, 2; RETURN; .balign 2, 0";
    assert_eq!(made(rule), code);
}

#[test]
fn what_is_about_to_be_read_keeps_its_place() {
    let rule = "#[cfg_attr(any(), micro(longs = \"TEMP, TEMP+4\"))]
        fn a(m: &mut impl Machine, percent: i32) {
            let hundred = Scaled::new(100);
            m.least(Scaled::new(percent as u32).over(hundred));
        }";
    let code = "a:; F store TEMP; LIT 100; DO new; F store TEMP+4; F load TEMP, NEW; F over TEMP+4; F bound TEMP; RETURN; \
        .balign 2, 0";
    assert_eq!(made(rule), code);
    let rule = "#[cfg_attr(any(), micro(longs = \"LEFT\"))]
        fn a(m: &mut impl Machine) { m.set_left(m.spare()); let nine = Scaled::new(9); m.least(nine.times(nine)); }";
    let refused = lowered(rule).expect_err("LEFT is not free").text;
    assert!(refused.contains("put by in LEFT, which the function has written"), "{refused}");
}

#[test]
fn a_number_is_added_to_a_long() {
    let rule = "#[cfg_attr(any(), micro(longs = \"TEMP\"))]
        fn a(m: &mut impl Machine, way: i32) { if way.wrapping_add(1) >= 0 { m.set_phase(1); } }";
    let code = "a:; F store TEMP; LIT 1; F add TEMP; IF_NEGATIVE .Ltest_m0; LET PHASE, 1; .Ltest_m0:; RETURN; .balign 2, 0";
    assert_eq!(made(rule), code);
}

#[test]
fn what_a_turn_does_not_need_is_not_put_by_for_the_next_one() {
    let rule = "fn a(m: &mut impl Machine) {
            for axis in Axis::UP {
                let way = m.um(axis);
                if m.is_homed(axis) { m.least(m.spare()); continue; }
                m.set_um(axis, way.wrapping_neg());
            }
        }";
    let code = "a:; LIT 0; DO axis_select; .Ltest_1:; F load UM, AXIS; IF_NOT_AXIS HOMED, .Ltest_3; F load SPARE; \
        F bound TEMP; GOTO .Ltest_2; .Ltest_3:; DO negate; F store UM, AXIS; .Ltest_2:; UP_AXIS .Ltest_1; RETURN; \
        .balign 2, 0";
    assert_eq!(made(rule), code);
}

#[test]
fn a_loop_ends_by_a_return() {
    let rule = "fn a(m: &mut impl Machine) { m.set_phase(1); loop { if m.is_active() { return m.begun(); } } }";
    let code = "a:; LET PHASE, 1; .Ltest_1:; IF_NONE RUN, RUN_ACTIVE, .Ltest_1; END; inc &RUNS; br #motion_reset; \
        .balign 2, 0";
    assert_eq!(made(rule), code);
}

#[test]
fn other_parts_do_otherwise() {
    let rule = "fn a(m: &mut impl Machine, rate: Scaled) {
            m.have_it();
            let least = if m.has_it() { m.set_phase(1); m.spare() } else { m.set_left(rate); rate };
            m.least(least);
            if m.has_it() { if m.phase() != 0 { m.set_phase(2); } }
        }";
    let code = "a:; .if HAS_IT; LET BITS, 1; UP PHASE; .else; LET PHASE, 0; .endif; \
        .if HAS_IT; IF_NONE BITS, IT, .Ltest_1; LET PHASE, 1; F load SPARE; GOTO .Ltest_2; .endif; \
        .Ltest_1:; F store LEFT; .Ltest_2:; F bound TEMP; \
        .if HAS_IT; IF_NONE BITS, IT, .Ltest_3; IF_ZERO PHASE, .Ltest_4; LET PHASE, 2; .endif; .Ltest_4:; .Ltest_3:; RETURN; \
        .balign 2, 0";
    assert_eq!(made(rule), code);
}
