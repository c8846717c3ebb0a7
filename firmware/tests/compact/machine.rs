//! A machine of three axes in the emulated flash, for routines that look at its record.

use lang::image::HEADER;
use lang::part::slot_head;
use lang::profile::Profile;
use lang::record::{AxisRecord, MachineRecord};

use crate::chip::Chip;

/// Where the code of a stored program would begin; its machine record stands in front of it.
const CODE: u16 = crate::area::AREA + 0x100;

/// The built-in profile `mill`.
pub fn mill() -> MachineRecord {
    MachineRecord::of(&Profile::built_in("mill").expect("mill is built in"))
}

/// Gives the chip a stored program with this machine record.
pub fn install(chip: &mut Chip, machine: &MachineRecord) {
    let first = CODE - u16::try_from(MachineRecord::SIZE).expect("a record is short");
    for (address, byte) in (first..).zip(machine.to_bytes()) {
        chip.board.poke8(address, byte);
    }
    chip.set_word("VM_CODE", CODE);
    // As the boot leaves it: 100 % each.
    chip.set_word("OVERRIDE", 0x6464);
    chip.set_word("STORED", first - (slot_head(1) + HEADER) as u16);
}

/// An axis with this scale.
pub fn scale(steps: u16, um: u16) -> AxisRecord {
    AxisRecord { flags: AxisRecord::PRESENT, steps, um, ..mill().axes[0] }
}
