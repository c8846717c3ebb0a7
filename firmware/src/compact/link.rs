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

/// Makes of each block `BLOCK_NAME` (its first address), `COUNT_NAME` and `TABLES_NAME`.
macro_rules! blocks {
    ($($name:ident: $table:ident;)*) => {
        $(core::arch::global_asm!(
            concat!(".set BLOCK_", stringify!($name), ", {first}"),
            concat!(".set COUNT_", stringify!($name), ", {count}"),
            concat!(".set TABLES_", stringify!($name), ", {tables}"),
            first = const wire::$name,
            count = const count(block(Table::$table, wire::$name)),
            tables = const tables(block(Table::$table, wire::$name)),
        );)*
    };
}

/// Makes of each register `AT_NAME`: its offset in the block.
macro_rules! registers {
    ($($block:ident: $($name:ident)*;)*) => {
        $($(core::arch::global_asm!(
            concat!(".set AT_", stringify!($name), ", {}"),
            const wire::$name - wire::$block,
        );)*)*
    };
}

blocks! {
    COILS: Coils;
    INPUT_BITS: Inputs;
    STATUS_BITS: Inputs;
    STATUS: InputRegisters;
    PROBE_RESULT_TEXT: InputRegisters;
    PROBE_RESULT: InputRegisters;
    CNC_STATUS: InputRegisters;
    COMMAND: Holding;
    OUTPUTS: Holding;
    POSITIONS: Holding;
    SPEEDS: Holding;
    OVERRIDES: Holding;
    CELLS: Holding;
    KEEPS: Holding;
    OWN: Holding;
    PROFILE_WINDOW: Holding;
    UPLOAD_WINDOW: Holding;
}

registers! {
    STATUS:
        INPUTS_HIGH MOVING HOMING LIMITS PLC_STATUS PROBING PROBE_ERROR WORK_POSITIONS
        ACTUAL_SPEEDS TARGETS;
    CNC_STATUS:
        COMMAND_ROOM CNC_STATE CNC_ALARM;
    OWN:
        VERSION FIRMWARE_VERSION ISA_FINGERPRINT PROFILE_HASH FEATURES AREA_BYTES FREE_BYTES
        PROGRAM_LENGTH PROGRAM_CRC RESET_CAUSE STACK_FREE MISSED_DEADLINES POOL_WORDS_REGISTER
        RUN_STATE FAULT FAULT_PC FAULT_LINE FAULT_INPUT PROGRAM_COUNTER LAST_END RUN_COUNT HOMED
        BLOCKING_INPUT MACHINE_POSITIONS COMMANDED RUN_CONTROL TRACE_MODE UPLOAD_CONTROL
        UPLOAD_LENGTH UPLOAD_RESULT TRACE_EVEN PRINT_COUNT PRINT_TAIL PRINT_TEXT CHAR_OUT CHAR_IN;
}

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
}

core::arch::global_asm!(include_str!("link/uart.s"), options(raw));
core::arch::global_asm!(include_str!("link/modbus.s"), options(raw));
core::arch::global_asm!(include_str!("link/tables.s"), options(raw));
core::arch::global_asm!(include_str!("link/map.s"), options(raw));
// Made of firmware/src/rules/status.rs; MAP_CODE reaches it behind the registers above.
core::arch::global_asm!(include_str!("made/status.s"), options(raw));
core::arch::global_asm!(include_str!("link/write.s"), options(raw));
