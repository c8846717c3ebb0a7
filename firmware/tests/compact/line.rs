//! Lines and single axes: what they hand to the step engine, against `Path` and `Single`.

use std::cell::RefCell;

use firmware::motion::scaled::Scaled;
use firmware::motion::{Block, Feed, Manner, Pace, Path, PathSegment, Segment, Single};
use lang::record::{AxisRecord, MachineRecord};
use proptest::prelude::*;

use crate::chip::{CLOCK, Chip};
use crate::machine::{install, mill};
use crate::ramp::segment;

/// Segments of a motion that are compared.
const SEGMENTS: usize = 100;
/// P2OUT and its DIR pins.
const P2OUT: u16 = 0x29;
const DIR: [u8; 3] = [0x08, 0x40, 0x80];

pub fn axis() -> impl Strategy<Value = AxisRecord> {
    let ramp = prop_oneof![100u32..5_000, 5_000u32..2_000_000];
    (1u16..5_000, 1u16..5_000, 0u16..2_000, 100u32..60_000, ramp.clone(), ramp, any::<bool>())
        .prop_map(|(steps, um, start_rate, top_rate, accel, decel, invert)| AxisRecord {
            flags: AxisRecord::PRESENT | if invert { AxisRecord::INVERT } else { 0 },
            steps,
            um,
            start_rate,
            top_rate,
            accel,
            decel,
            ..mill().axes[0]
        })
}

fn axes() -> impl Strategy<Value = [AxisRecord; 3]> {
    [axis(), axis(), axis()]
}

fn distance() -> impl Strategy<Value = i32> {
    prop_oneof![Just(0), -20..20i32, -3_000..3_000i32, -2_000_000..2_000_000i32]
}

fn feed() -> impl Strategy<Value = Feed> {
    let value = prop_oneof![0u32..1_000, 1_000u32..2_000_000];
    prop_oneof![
        Just(Feed::Rapid),
        value.clone().prop_map(Feed::Um),
        (1u32..100_000).prop_map(Feed::Steps),
    ]
}

/// Puts positions into the chip: where the axes stand and where they shall go.
pub fn aim(chip: &mut Chip, from: [i32; 3], to: [i32; 3]) {
    for n in 0..3 {
        chip.set_long("ACTUAL", 4 * n, from[usize::from(n)] as u32);
        chip.set_long("STEPS", 4 * n, to[usize::from(n)] as u32);
    }
}

/// What FEED holds for a feed.
pub fn feed_word(feed: Feed) -> u32 {
    match feed {
        Feed::Rapid => 0,
        Feed::Um(um) => um.max(1),
        Feed::Steps(steps) => steps.wrapping_neg(),
    }
}

/// A feed in steps/s makes the step the unit along the path, where the twin's is always the um: to it
/// each step is a um then.
pub fn in_the_unit_of(feed: Feed, axes: [AxisRecord; 3]) -> (Feed, [AxisRecord; 3]) {
    match feed {
        Feed::Steps(steps) => {
            (Feed::Um(steps), axes.map(|axis| AxisRecord { steps: 1, um: 1, ..axis }))
        }
        _ => (feed, axes),
    }
}

/// Starting pins of the engine, as bits of P2OUT.
fn dir_pins(axes: &[AxisRecord; 3], negative: u8) -> u8 {
    (0..3)
        .filter(|n| (negative >> n & 1 == 0) != (axes[*n as usize].flags & AxisRecord::INVERT != 0))
        .map(|n| DIR[n as usize])
        .sum()
}

#[test]
fn lines_are_planned_as_one_block_of_a_path() {
    let chip = RefCell::new(Chip::new());
    let steps = [distance(), distance(), distance()];
    let from = [-1_000_000..1_000_000i32, -1_000_000..1_000_000i32, -1_000_000..1_000_000i32];
    proptest!(ProptestConfig::with_cases(400), |(
        axes in axes(), steps in steps, from in from, feed in feed(), mask in 1u8..8, rapid: bool, percents in [10u8..=200, 10..=100]
    )| {
        let mut chip = chip.borrow_mut();
        install(&mut chip, &MachineRecord { axes, ..mill() });
        let to = [0, 1, 2].map(|n| from[n] + steps[n]);
        aim(&mut chip, from, to);
        chip.set_long("FEED", 0, feed_word(feed));
        chip.set_byte("MOVING", 0);
        for (at, percent) in (chip.at("OVERRIDE")..).zip(percents) {
            chip.board.poke8(at, percent);
        }
        chip.call(if rapid { "line_rapid" } else { "line_begin" }, &[(12, mask.into())]);
        let steps = [0, 1, 2].map(|n| if mask >> n & 1 != 0 { steps[n] } else { 0 });
        let moving: u8 = (0..3).filter(|n| steps[*n] != 0).map(|n| 1 << n).sum();
        prop_assert_eq!(chip.byte("MOVING"), moving);
        let (feed, axes) = in_the_unit_of(feed, axes);
        let feed = if rapid { Feed::Rapid } else { feed };
        let mut path = Path::new(0, CLOCK);
        // Without a feed the axes go as fast as they can, by the override of feeds.
        let fastest = if rapid { percents[1] } else { percents[0].min(100) };
        path.set_override(percents[0], fastest);
        let manner = Manner::new(feed, true);
        path.push_ending(&axes, &Block { steps, um: [0; 3], manner }, Scaled::ZERO);
        let mut planned = PathSegment::default();
        for n in 0..SEGMENTS {
            let going = path.next_segment(&axes, &mut planned);
            if n == 0 && going {
                for a in 0..3 {
                    prop_assert_eq!(chip.long("INC", 4 * a), planned.inc[usize::from(a)]);
                    prop_assert_eq!(chip.long("ACC", 4 * a), 1 << 31);
                }
                let moving_pins: u8 = (0..3).filter(|n| moving >> n & 1 != 0).map(|n| DIR[n]).sum();
                prop_assert_eq!(chip.byte("NEGATIVE") & moving, planned.negative);
                let pins = chip.board.bus_read8(P2OUT) & moving_pins;
                prop_assert_eq!(pins, dir_pins(&axes, planned.negative) & moving_pins);
            }
            let (made, _) = segment(&mut chip, "SLOT0");
            prop_assert_eq!(made, going.then_some(planned.ramp), "segment {}", n);
            if !going {
                break;
            }
        }
    });
}

#[test]
fn single_axes_are_planned_as_single() {
    let chip = RefCell::new(Chip::new());
    let pace = (1u32..100_000, 1u32..1_000_000, 1u32..1_000_000, 0i8..10);
    proptest!(ProptestConfig::with_cases(400), |(
        axes in axes(), n in 0u16..3, from in -1_000_000..1_000_000i32, by in distance(),
        (speed, accel, decel, slow) in pace, percent in 10u8..=200
    )| {
        let mut chip = chip.borrow_mut();
        install(&mut chip, &MachineRecord { axes, ..mill() });
        let i = usize::from(n);
        let pace = Pace::of(&axes[i]).with_steps(speed).with_ramps(
            Scaled::new(accel).shifted(-slow),
            Scaled::new(decel).shifted(-slow),
        );
        let (mut start, mut end) = ([7, -8, 9], [10, 11, 12]);
        start[i] = from;
        end[i] = from + by;
        aim(&mut chip, start, end);
        chip.set_byte("MOVING", 0);
        for (at, part) in [(0, pace.speed), (4, pace.accel), (8, pace.decel)] {
            chip.set_long("TEMP", at, part.0);
        }
        chip.set_byte("OVERRIDE", percent);
        chip.set_byte("N", n as u8);
        chip.call("axis_begin", &[(12, 1 << n)]);
        prop_assert_eq!(chip.byte("MOVING"), if by == 0 { 0 } else { 1 << n });
        let mut single = Single::new(from, CLOCK);
        single.percent = percent;
        single.go(&axes[i], end[i], pace);
        // Nothing is planned for who stands there already.
        for a in (0..3u16).filter(|_| by != 0) {
            prop_assert_eq!(chip.long("INC", 4 * a), if a == n { u32::MAX } else { 0 });
        }
        let mut planned = Segment::NONE;
        for k in 0..SEGMENTS {
            let going = single.next_segment(&mut planned);
            let (made, _) = segment(&mut chip, "SLOT1");
            prop_assert_eq!(made, going.then_some(planned), "segment {}", k);
            if !going {
                break;
            }
            let negative = chip.byte("NEGATIVE") >> n & 1 != 0;
            prop_assert_eq!(negative, single.negative());
        }
    });
}
