//! The Modbus slave: serial line, frames, registers.

use crate::consts::constants;
use crate::vm::PART;
use lang::fault::Fault;
use lang::image::at;
use lang::isa::FINGERPRINT;
use lang::wire::{self, BLOCKS, Block, Control, Exception, LONG, Table};

/// The block of a table that begins at an address.
const fn block(table: Table, first: u16) -> Block {
    let mut n = 0;
    while BLOCKS[n].first != first || BLOCKS[n].table != table as u8 {
        n += 1;
    }
    BLOCKS[n]
}

/// Count of a block in one byte, 0 for the upload window.
const fn count(block: Block) -> u16 {
    if block.count > u8::MAX as u16 { 0 } else { block.count }
}

/// Tables of a block: bit n-1 for function n, bit 7 for pairs that are 32-bit values. [`wire::OWN`]
/// stands in two.
const fn tables(block: Block) -> u16 {
    let own = (block.first == wire::OWN) as u16;
    1 << (block.table - 1)
        | own << (Table::InputRegisters as u16 - 1)
        | (block.flags as u16 & LONG as u16) << 6
}

/// Makes of each block `BLOCK_NAME` (its first address), `COUNT_NAME` and `TABLES_NAME`, of each register `AT_NAME`,
/// its offset in the block.
macro_rules! symbols {
    (
        blocks { $($block:ident: $table:ident $first:literal + $count:literal, $flags:expr;)* }
        registers { $($(#[doc = $doc:literal])+ $name:ident: $in:ident + $offset:literal;)* }
    ) => {
        $(core::arch::global_asm!(
            concat!(".set BLOCK_", stringify!($block), ", ", $first),
            concat!(".set COUNT_", stringify!($block), ", {count}"),
            concat!(".set TABLES_", stringify!($block), ", {tables}"),
            count = const count(block(Table::$table, wire::$block)),
            tables = const tables(block(Table::$table, wire::$block)),
        );)*
        core::arch::global_asm!($(concat!(".set AT_", stringify!($name), ", ", $offset),)*);
    };
}

lang::register_rows!(symbols);

const _: () = assert!(LONG == 2 && wire::OWN == wire::OWN_INPUT);

/// InterpCNC's alarm codes (its input register 3004) by fault number.
#[unsafe(no_mangle)]
static ALARMS: [u8; Fault::ALL.len() + 1] = {
    let mut codes = [0; Fault::ALL.len() + 1];
    let mut n = 0;
    while n < codes.len() {
        codes[n] = Fault::alarm_of(n as u8);
        n += 1;
    }
    codes
};

constants! {
    EX_FUNCTION = Exception::IllegalFunction;
    EX_ADDRESS = Exception::IllegalAddress;
    EX_VALUE = Exception::IllegalValue;
    CONTROLS = Control::ALL.len();
    CONTROL_START = Control::Start;
    CONTROL_RESTART = Control::Restart;
    COMMAND_WORDS = firmware::rules::status::COMMAND_WORDS;
    UPLOAD_COUNT = block(Table::Holding, wire::UPLOAD_WINDOW).count;
    WIRE_VERSION = wire::WIRE_VERSION;
    RELEASE = firmware::RELEASE;
    FINGERPRINT = FINGERPRINT;
    HEADER_CRC = at::CRC;
    HEADER_PROFILE = at::PROFILE;
    HEADER_CELLS = at::CELLS;
    PART_FEATURES = PART.features;
    STORE_AREA = PART.room_for(false);
    POOL_WORDS = crate::vm::POOL / 2;
    // LINE_STATE: a frame may come.
    LINE_LISTEN = 0;
    // One has come; its reply is being made.
    LINE_READY = 1;
    // All of the reply is in the ring.
    LINE_LAST = 2;
    // A negative number of registers: all that are left of a list.
    REST = 0x20;
}

// HEAD of a frame with a gap, with its sign.
core::arch::global_asm!(".set SPOILED, {}", const -1i16);

core::arch::global_asm!(include_str!("link/uart.s"), options(raw));
core::arch::global_asm!(include_str!("link/modbus.s"), options(raw));
core::arch::global_asm!(include_str!("link/tables.s"), options(raw));
core::arch::global_asm!(include_str!("link/map.s"), options(raw));
// Made of firmware/src/rules/status.rs; MAP_CODE reaches it behind the registers above.
core::arch::global_asm!(include_str!("generated/status.s"), options(raw));
core::arch::global_asm!(include_str!("link/write.s"), options(raw));
