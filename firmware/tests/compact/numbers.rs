//! The scaled numbers of the planner.

use std::cell::RefCell;

use firmware::motion::scaled::Scaled;
use proptest::prelude::*;

use crate::chip::Chip;

fn call(chip: &RefCell<Chip>, routine: &str, a: Scaled, b: Scaled) -> Scaled {
    let (a, b) = (a.0, b.0);
    let pair = [(12, a as u16), (13, (a >> 16) as u16), (14, b as u16), (15, (b >> 16) as u16)];
    chip.borrow_mut().call(routine, &pair);
    Scaled(chip.borrow().result())
}

#[test]
fn scaled_arithmetic_is_the_twins_to_the_bit() {
    let chip = RefCell::new(Chip::new());
    proptest!(|(a in any::<u32>(), b in 1u32..)| {
        let (x, y) = (Scaled::new(a), Scaled::new(b));
        prop_assert_eq!(call(&chip, "pasapas_scaled_times", x, y), x.times(y));
        prop_assert_eq!(call(&chip, "pasapas_scaled_over", x, y), x.over(y));
        prop_assert_eq!(call(&chip, "pasapas_scaled_root", x, y), x.root());
    });
}

#[test]
fn sums_of_any_two_scaled_numbers_are_the_twins() {
    let chip = RefCell::new(Chip::new());
    let number = || {
        let some = (1u32 << 23..1 << 24, 1u32..255).prop_map(|(m, e)| Scaled(e << 24 | m));
        prop_oneof![8 => some, 1 => any::<u32>().prop_map(Scaled::new), 1 => Just(Scaled::ZERO)]
    };
    proptest!(|(x in number(), y in number(), near in 0u32..30)| {
        // of about the same size, too
        let z = Scaled(y.0 & 0xFF_FFFF | (x.0 >> 24).saturating_sub(near) << 24);
        for y in [y, if y.0 == 0 { y } else { z }] {
            prop_assert_eq!(call(&chip, "pasapas_scaled_plus", x, y), x.plus(y));
            prop_assert_eq!(call(&chip, "pasapas_scaled_plus", y, x), y.plus(x));
            prop_assert_eq!(call(&chip, "pasapas_scaled_minus", x, y), x.minus(y));
            prop_assert_eq!(call(&chip, "pasapas_scaled_minus", y, x), y.minus(x));
            prop_assert_eq!(call(&chip, "pasapas_scaled_floor", x, y).0, x.floor());
        }
    });
}

#[test]
fn division_is_that_of_rust() {
    let chip = RefCell::new(Chip::new());
    let wide = prop_oneof![0..20u32, any::<u32>(), Just(u32::MAX)];
    proptest!(|(a in wide.clone(), b in wide)| {
        prop_assume!(b != 0);
        let (a, b) = (Scaled(a), Scaled(b));
        prop_assert_eq!(call(&chip, "pasapas_udivmod", a, b).0, a.0 / b.0);
    });
}
