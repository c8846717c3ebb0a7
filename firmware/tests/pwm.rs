//! The PWM's pulses, period by period, while its width changes and while it is gated, at each phase of a period: one pulse in
//! each period, of a width from the older one to the newer one, and none as soon as it is off.

mod rig;

use emulator::{Board, Signal, Silicon};
use lang::wire::{self, Control};
use rig::{on, wired, write};

/// Registers of TB0: control of the PWM's channel, and the counter.
const TB0CCTL5: u16 = 0x03CC;
const TB0R: u16 = 0x03D0;
/// Counts in a second: those of the processor, as the timer has no divider at these frequencies.
const HZ: u64 = 25_000_000;
/// How exactly it is known when a change comes, us.
const LOOK_US: u64 = 20;
/// Periods that are looked at before a change and after it.
const BEFORE: u64 = 3;
const AFTER: u64 = 5;

/// Widths of pulses, thousandths of full power, each in its turn: wider, narrower, and both at the ends of what there is.
const TURNS: [u32; 9] = [300, 900, 1000, 30, 1000, 960, 5, 500, 490];

/// A spindle at this frequency that gets each width in its turn, is switched off, and on again.
fn board(hz: u64, tb25: bool) -> Board {
    let own = format!(
        "[pwm]\noutput = 1\nkind = \"spindle\"\nfrequency_hz = {hz}\n[[output]]\nn = 1\nrole = \"spindle\"\n"
    );
    let mut script = String::from("Wait 50ms\n");
    for power in TURNS {
        script += &format!("M3 S{power}\nWait 4ms\n");
    }
    script += "M5\nWait 4ms\nM3\nWait 999s\n";
    let silicon = Silicon { tb25, ..Silicon::default() };
    let mut board = on(silicon, &wired("direct", &own), &script);
    write(&mut board, wire::RUN_CONTROL, Control::Start as u16);
    board
}

/// Counts that the pin is to be high for in a period of `top` and one more.
fn width(board: &mut Board, top: u64) -> u64 {
    let gated = board.bus_read16(TB0CCTL5) >> 5 & 7 == 0;
    let power = board.symbol("PASAPAS_POWER").expect("a name");
    let compare = u64::from(board.peek16(power));
    if gated { 0 } else { top.saturating_sub(compare) }
}

/// A change of the width that is wanted: a time when it has not come yet, one when it has, and both widths.
struct Change {
    before: u64,
    after: u64,
    old: u64,
    new: u64,
}

/// All changes of a run.
fn changes(mut board: Board, top: u64) -> Vec<Change> {
    let mut old = width(&mut board, top);
    let mut out = Vec::new();
    for _ in 0..130_000 / LOOK_US {
        let before = board.cycles();
        board.run_us(LOOK_US);
        let new = width(&mut board, top);
        if new != old {
            out.push(Change { before, after: board.cycles(), old, new });
            old = new;
        }
    }
    out
}

/// Pulses of each period: widths in counts. Those of the first period are what the counter that was set left of it.
fn periods(board: &mut Board, first: u64, top: u64, cycle: u64) -> Vec<Vec<u64>> {
    let mut out = vec![Vec::new()];
    let mut rose = None;
    let period = |at: u64| ((at + (top + 1) * cycle - first) / ((top + 1) * cycle)) as usize;
    for edge in board.take_edges().iter().filter(|edge| edge.signal == Signal::Pwm) {
        if edge.level {
            rose = Some(edge.cycle);
            continue;
        }
        let Some(rose) = rose.take() else { continue };
        // It falls with the end of its period, which is the first instant of the next one.
        let n = period(rose);
        out.resize((n + 1).max(out.len()), Vec::new());
        out[n].push((edge.cycle - rose) / cycle);
    }
    let last = period(board.cycles());
    out.resize(last.max(1), Vec::new());
    out
}

/// Holds the periods around a change to what they may be.
fn check(change: &Change, periods: &[Vec<u64>], what: &str) {
    let &Change { old, new, .. } = change;
    let (least, most) = (old.min(new), old.max(new));
    let mut turned = 0;
    for (n, pulses) in periods.iter().enumerate().skip(1) {
        assert!(pulses.len() <= 1, "{what}, period {n}: {periods:?}");
        // No pulse is that of no width.
        let width = pulses.first().copied().unwrap_or(0);
        assert!((least..=most).contains(&width), "{what}, period {n}: {periods:?}");
        if width != old || turned != 0 {
            turned += 1;
        }
        assert!(turned <= 2 || width == new, "{what}, period {n} is not new yet: {periods:?}");
    }
    assert!(turned > 2, "{what}: {periods:?}");
}

#[test]
fn each_phase_of_a_period_has_one_pulse_whatever_changes_there() {
    // What the counter passes while the interrupt works is some 50 counts.
    for (tb25, every) in [(false, 3), (true, 11)] {
        let hz = 20_000;
        let mut board = board(hz, tb25);
        let cycle = board.ticks_per_second() / HZ;
        let top = HZ / hz - 1;
        let period = (top + 1) * cycle;
        let changes = changes(board.clone(), top);
        // From off to the first width, to each one in its turn, off and on.
        assert_eq!(changes.len(), TURNS.len() + 2, "{hz} Hz");
        for change in changes {
            board.run_until(change.before - BEFORE * period);
            // At its top the counter that is set there lets no pin fall.
            for phase in (0..top).step_by(every) {
                let mut board = board.clone();
                board.record(true);
                board.take_edges();
                board.bus_write16(TB0R, phase as u16);
                // The pin falls as the counter comes to its top.
                let first = board.cycles() + (top - phase) * cycle;
                board.run_until(change.after);
                let what = format!("{hz} Hz, {} to {}, phase {phase}", change.old, change.new);
                if change.new == 0 {
                    // At once, and for good.
                    assert!(!high(&mut board), "{what}");
                    let before = pulses(&mut board);
                    board.run_for(AFTER * period);
                    assert_eq!(pulses(&mut board), 0, "{what}: {before} before");
                    continue;
                }
                board.run_for(AFTER * period);
                check(&change, &periods(&mut board, first, top, cycle), &what);
            }
        }
    }
}

/// Edges of the PWM's pin since the last call. The spindle's output has edges of its own.
fn pulses(board: &mut Board) -> usize {
    board.take_edges().iter().filter(|edge| edge.signal == Signal::Pwm).count()
}

/// Level of the PWM's pin.
fn high(board: &mut Board) -> bool {
    const P3IN: u16 = 0x0220;
    board.bus_read8(P3IN) >> 5 & 1 != 0
}
