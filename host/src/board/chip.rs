//! Converts a chip of `lang::part` into the emulator's description: the emulator knows cores and modules, and no table of
//! this project.

use emulator::Part;
use lang::part::chip::{self, Chip};

/// What the emulator must know of a chip.
pub(super) const fn emulated(chip: &'static Chip) -> Part {
    let [ram, ram_bytes] = [chip.ram[0] as u32, chip.ram[1] as u32];
    let (usb, info) = (chip.usb_ram as u32, chip.info as u32);
    let [flash, flash_bytes] = chip.flash;
    let like = match chip.family {
        chip::Family::Msp430 => Part::G2553,
        chip::Family::Msp430X => Part::F5529,
    };
    Part {
        name: chip.name,
        family: like.family,
        ticks_per_second: like.ticks_per_second,
        ram: ram + usb..=ram + ram_bytes - 1,
        usb_ram: if usb > 0 { Some(ram..=ram + usb - 1) } else { None },
        info: info..=info + chip.family.info_bytes() - 1,
        flash: flash..=flash + flash_bytes - 1,
        banks: chip.banks,
    }
}

#[cfg(test)]
mod tests {
    use super::{Part, emulated};
    use lang::part::{F5529, G2553};

    #[test]
    fn the_emulators_own_tests_have_these_chips() {
        assert_eq!(emulated(G2553.chip), Part::G2553);
        assert_eq!(emulated(F5529.chip), Part::F5529);
    }
}
