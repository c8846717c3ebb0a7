//! The planner's arithmetic of the MSP430F5529, routine by routine, against its twin.

use std::cell::RefCell;

use emulator::{Board, Config, Image, Part, Stop};
use firmware::motion::math::{fraction, mul_div};
use firmware::motion::scaled::Scaled;
use proptest::prelude::*;

/// End of the RAM.
const STACK: u16 = 0x4400;
/// Where a routine comes back to: nothing is there.
const BACK: u16 = 0x4300;
/// Three longs.
const VALUES: u16 = 0x4200;
/// Longer than any routine takes.
const LIMIT_US: u64 = 100_000;

fn chip() -> RefCell<Board> {
    let image = Image::parse(include_bytes!("../image/pasapas-f5529.elf")).expect("the image");
    let config = Config { part: Part::F5529, ..Config::default() };
    let mut board = Board::with_config(&config, &image);
    board.set_breakpoint(BACK);
    // WDTCTL: held.
    board.bus_write16(0x015C_u16, 0x5A80);
    RefCell::new(board)
}

/// Calls a routine above 64 KB with two longs and, on the stack, another one.
fn call(chip: &RefCell<Board>, routine: &str, a: u32, b: u32, c: u32) -> u32 {
    let mut board = chip.borrow_mut();
    let far = board.far_symbol(routine).unwrap_or_else(|| panic!("there is no {routine}"));
    // RETA takes four bytes.
    let stack = [BACK, 0, c as u16, (c >> 16) as u16];
    (0..).zip(stack).for_each(|(n, word)| board.poke16(STACK - 8 + 2 * n, word));
    board.set_reg(1, STACK - 8);
    board.set_reg(2, 0_u16);
    for (n, long) in [(12, a), (14, b)] {
        board.set_reg(n, long as u16);
        board.set_reg(n + 1, (long >> 16) as u16);
    }
    board.set_reg(0, far);
    let end = board.cycles() + LIMIT_US * board.ticks_per_second() / 1_000_000;
    assert_eq!(board.run_until(end), Stop::Breakpoint(BACK.into()), "{routine} hangs");
    u32::from(board.reg(13)) << 16 | u32::from(board.reg(12))
}

fn number() -> impl Strategy<Value = Scaled> {
    let some = (1u32 << 23..1 << 24, 1u32..255).prop_map(|(m, e)| Scaled(e << 24 | m));
    let whole = (any::<u32>(), 0u32..32).prop_map(|(n, down)| Scaled::new(n >> down));
    prop_oneof![8 => some, 4 => whole, 1 => Just(Scaled::ZERO)]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2_000))]

    #[test]
    fn scaled_arithmetic_is_the_twins_to_the_bit(x in number(), y in number(), near in 0u32..30) {
        thread_local!(static CHIP: RefCell<Board> = chip());
        CHIP.with(|chip| {
            // Of about the same size, too.
            let z = Scaled(y.0 & 0xFF_FFFF | (x.0 >> 24).saturating_sub(near) << 24);
            for y in [y, if y.0 == 0 { y } else { z }] {
                let two = |name: &str| Scaled(call(chip, &format!("pasapas_scaled_{name}"), x.0, y.0, 0));
                prop_assert_eq!(two("times"), x.times(y));
                prop_assert_eq!(two("over"), x.over(y));
                prop_assert_eq!(two("plus"), x.plus(y));
                prop_assert_eq!(two("minus"), x.minus(y));
                prop_assert_eq!(two("min"), x.least(y));
                prop_assert_eq!(two("max"), x.most(y));
                prop_assert_eq!(two("exponent_over").0 as i8, x.exponent_over(y));
                prop_assert_eq!(two("floor").0, x.floor());
                if (2..253).contains(&(x.0 >> 24)) {
                    prop_assert_eq!(two("root"), x.root());
                }
            }
            Ok(())
        })?;
    }

    #[test]
    fn integers_are_the_twins(value in any::<u32>(), down in 0u32..32) {
        thread_local!(static CHIP: RefCell<Board> = chip());
        CHIP.with(|chip| {
            let value = value >> down;
            prop_assert_eq!(call(chip, "pasapas_scaled_new", value, 0, 0), Scaled::new(value).0);
            let size = Scaled::size(value as i32).0;
            prop_assert_eq!(call(chip, "pasapas_scaled_size", value, 0, 0), size);
            Ok(())
        })?;
    }

    #[test]
    fn sums_of_squares_are_the_twins(
        values in prop::array::uniform3(any::<i32>()),
        down in prop::array::uniform3(0u32..33),
    ) {
        thread_local!(static CHIP: RefCell<Board> = chip());
        let values: [i32; 3] = std::array::from_fn(|n| values[n].checked_shr(down[n]).unwrap_or(0));
        CHIP.with(|chip| {
            for (n, value) in (0..).zip(values) {
                chip.borrow_mut().poke16(VALUES + 4 * n, value as u16);
                chip.borrow_mut().poke16(VALUES + 4 * n + 2, (value >> 16) as u16);
            }
            let sum = call(chip, "pasapas_scaled_squares", VALUES.into(), 0, 0);
            prop_assert_eq!(sum, Scaled::squares(&values).0);
            Ok(())
        })?;
    }

    #[test]
    fn products_and_quotients_are_the_twins(
        [a, b, c] in [any::<u32>(), any::<u32>(), any::<u32>()],
        [da, db, dc] in [0u32..32, 0u32..32, 0u32..32],
    ) {
        thread_local!(static CHIP: RefCell<Board> = chip());
        CHIP.with(|chip| {
            let (a, b, c) = (a >> da, b >> db, c >> dc);
            prop_assert_eq!(call(chip, "gate.pasapas_mul_div", a, b, c), mul_div(a, b, c));
            prop_assert_eq!(call(chip, "gate.pasapas_fraction", a, c, 0), fraction(a, c));
            Ok(())
        })?;
    }
}
