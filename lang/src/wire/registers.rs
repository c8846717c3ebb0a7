//! The map of the registers: the one place where a register or a block of them is described.
//!
//! A block is `NAME: Table first + count, flags`, a register `NAME: BLOCK + offset` under what it says. What one shows on
//! each chip is an arm of `firmware/src/machine/map.rs` and a row of `firmware/g2553/link/tables.s`.

/// Hands all rows to a macro: `lang` makes constants and tables of them, the firmware the assembler's symbols.
#[macro_export]
macro_rules! register_rows {
    ($consumer:ident) => {
        $consumer! {
            blocks {
                COILS: Coils 0 + 16, WRITABLE;
                INPUT_BITS: Inputs 0 + 32, 0;
                STATUS_BITS: Inputs 256 + 128, 0;
                STATUS: InputRegisters 1000 + 27, 0;
                PLACES: InputRegisters 1030 + 24, 0;
                GOALS: InputRegisters 1060 + 24, 0;
                ANALOGS: InputRegisters 1090 + 8, 0;
                PROBE_RESULT_TEXT: InputRegisters 1330 + 12, 0;
                PROBE_RESULT: InputRegisters 1350 + 12, 0;
                CNC_STATUS: InputRegisters 3000 + 5, 0;
                OWN_INPUT: InputRegisters 5000 + 200, 0;
                COMMAND: Holding 2000 + 21, WRITABLE;
                AOUTS: Holding 2150 + 8, WRITABLE;
                OUTPUTS: Holding 2160 + 1, WRITABLE;
                POSITIONS: Holding 2400 + 12, WRITABLE | LONG;
                SPEEDS: Holding 2412 + 12, 0;
                OVERRIDES: Holding 2430 + 2, WRITABLE;
                CELLS: Holding 3000 + 72, WRITABLE | LONG;
                KEEPS: Holding 4000 + 16, WRITABLE | LONG;
                OWN: Holding 5000 + 200, WRITABLE;
                PROFILE_WINDOW: Holding 5200 + 32, WRITABLE;
                PROFILE_MORE: Holding 5240 + 19, WRITABLE;
                LIBRARY: Holding 6000 + 1024, 0;
                TRACE_QUEUE: Holding 7100 + 352, 0;
                UPLOAD_WINDOW: Holding 8000 + 1536, WRITABLE;
                STREAM_MACHINE: Holding 9600 + 73, WRITABLE;
                STREAM_PIECE: Holding 9700 + 256, WRITABLE;
                UPLOAD_LARGE: Holding 10000 + 16384, WRITABLE;
            }
            registers {
                /// Inputs 1..16, bit n-1; input 17 is bit 0 of the next register. Also input bits 0...
                INPUTS: STATUS + 0;
                /// Bit 0: input 17, the probe of the chain wiring. F5529: bits 1 to 4 inputs 18 to 21, which thresholds make.
                INPUTS_HIGH: STATUS + 1;
                /// Low byte: moving, bit per axis; high byte: direction, 1 positive. Also bits 256.., 264...
                MOVING: STATUS + 16;
                /// Low byte: homing; high byte: homing error. Also bits 272.., 280...
                HOMING: STATUS + 17;
                /// Low byte: limit at the negative end; high byte: at the positive end. Also bits 288.., 296...
                LIMITS: STATUS + 18;
                /// Bit 13: override is not 100 %. Also bit 333.
                MISC_STATUS: STATUS + 20;
                /// Bit 10: program running. Also bit 346.
                PLC_STATUS: STATUS + 21;
                /// High byte: probing, bit per axis. Also bits 360...
                PROBING: STATUS + 22;
                /// Low byte: probe error, bit per axis. Also bits 368...
                PROBE_ERROR: STATUS + 23;
                /// Bytes of print that wait; the same as holding 5120.
                PRINT_LENGTH: STATUS + 26;
                /// Work positions in steps, 32 bits for each axis; the same as holding 2400. Axes 4 to 6 of the twelve registers are 0, here and in the blocks that follow.
                WORK_POSITIONS: PLACES + 0;
                /// Present speeds in steps/s, signed, 32 bits for each axis; the same as holding 2412.
                ACTUAL_SPEEDS: PLACES + 12;
                /// Targets last commanded, work positions in steps, 32 bits for each axis.
                TARGETS: GOALS + 0;
                /// F5529: speeds that axes on their own are to have, steps/s, signed, 32 bits for each axis; 0 at rest and on a path. Exception 2 on the G2553.
                TARGET_SPEEDS: GOALS + 12;
                /// F5529: voltage at analog inputs 1 to 4, mV, a register each; the four registers behind them are 0. Exception 2 on the G2553.
                ANALOG_INPUTS: ANALOGS + 0;
                /// Free registers of the command buffer: 21 when it takes a command, else 0.
                COMMAND_ROOM: CNC_STATUS + 0;
                /// Bit 0 alarm, 2 homing, 3 program running, 4 paused, 5 jog, 6 door, 8 emergency stop.
                CNC_STATE: CNC_STATUS + 3;
                /// InterpCNC's alarm code of the latched fault, 0 for none.
                CNC_ALARM: CNC_STATUS + 4;
                /// F5529: value of analog output 1, mV or steps of its range, also written while a program runs; the seven registers after it are not written and are 0. Exception 2 on the G2553.
                ANALOG_OUTPUT: AOUTS + 0;
                /// [`WIRE_VERSION`]
                VERSION: OWN + 0;
                /// Firmware version, major in the high byte.
                FIRMWARE_VERSION: OWN + 1;
                /// Fingerprint of the instruction set.
                ISA_FINGERPRINT: OWN + 2;
                /// CRC of the board profile in use.
                PROFILE_HASH: OWN + 3;
                /// Image features ([`crate::record`]) that this firmware runs.
                FEATURES: OWN + 4;
                /// Bytes that the program area has in all.
                AREA_BYTES: OWN + 5;
                /// Largest image that fits beside the stored program.
                FREE_BYTES: OWN + 6;
                /// Length of the stored program in bytes, 0 for none.
                PROGRAM_LENGTH: OWN + 7;
                /// CRC of the stored program.
                PROGRAM_CRC: OWN + 8;
                /// Hash of the axes' profile in the stored program.
                PROGRAM_PROFILE: OWN + 9;
                /// Cells of the stored program.
                PROGRAM_CELLS: OWN + 10;
                /// Why the board came up: bit 0 watchdog, 2 power on, 3 RST pin, 4 NMI; 5: the crystal does not run;
                /// 6: it failed since then, and runs again.
                RESET_CAUSE: OWN + 11;
                /// Bytes of stack never used since reset.
                STACK_FREE: OWN + 12;
                /// Milliseconds that were served more than 2 ms late since reset. G2553: those are in the low byte, modulo 256; in the high byte is the low byte of [`RUN_COUNT`] in the last run that ended with F14 because a line of a path came too late, 0 for none.
                MISSED_DEADLINES: OWN + 13;
                /// Free RAM words of the largest pool, in 16-bit words.
                POOL_WORDS_REGISTER: OWN + 14;
                /// F5529: number in the library of the stored program that these registers tell of: the one that runs or ran last, or is selected.
                PROGRAM_NUMBER: OWN + 15;
                /// F5529: step events that came some us late since reset. No step of them was lost, and no pulse or pause between pulses got shorter than promised.
                LATE_EVENTS: OWN + 16;
                /// F5529: hardware revision of the chip, the byte at 1A06 of its device descriptor.
                CHIP_REVISION: OWN + 17;
                /// Why a streamed run waits for a handler, 0 when it does not. Bits 0..3: [`Called`]; bits 4, 5:
                /// slot of the event; high byte: number of the fault instead. What is read behind it in one
                /// request is of that instant or later.
                STREAM_CALL: OWN + 19;
                /// [`RunState`]
                RUN_STATE: OWN + 20;
                /// Number of the last fault, 0 for none since the last start.
                FAULT: OWN + 21;
                /// Offset in the image's code of the failing effect.
                FAULT_PC: OWN + 22;
                /// Line of the fault when the image tells lines, else 0.
                FAULT_LINE: OWN + 23;
                /// Input that caused it, from 1, or 0.
                FAULT_INPUT: OWN + 24;
                /// Offset in the image's code of the statement that runs; FFFF before a piece's first.
                PROGRAM_COUNTER: OWN + 25;
                /// [`End`] of the last run.
                LAST_END: OWN + 26;
                /// Runs begun since reset.
                RUN_COUNT: OWN + 27;
                /// Homed axes, bit per axis.
                HOMED: OWN + 28;
                /// Input that keeps Start or a move from working, from 1, or 0; 255 before an F5529 has a profile.
                BLOCKING_INPUT: OWN + 29;
                /// Machine positions in steps, 32 bits for each axis.
                MACHINE_POSITIONS: OWN + 30;
                /// Commanded machine positions in steps (trace lines' `to`), 32 bits for each axis.
                COMMANDED: OWN + 36;
                /// Pieces accepted since [`Stream::Open`], modulo 65536.
                STREAM_ACCEPTED: OWN + 42;
                /// Pieces begun; [`PROGRAM_COUNTER`] and [`FAULT_PC`] lie in the newest.
                STREAM_BEGUN: OWN + 43;
                /// 1: the newest piece has ended and no other is there.
                STREAM_DRY: OWN + 44;
                /// How often the axes came to rest because no piece was there.
                STREAM_STARVED: OWN + 45;
                /// [`Refusal`] of the newest piece.
                STREAM_RESULT: OWN + 46;
                /// Write one [`Control`] code.
                RUN_CONTROL: OWN + 50;
                /// 1: trace mode. F5529: write 2 for one in which events are queued.
                TRACE_MODE: OWN + 51;
                /// F5529: milliseconds that what commands move still goes on, 0 without a bound. Write 1 after the command for 300 of them, then 2 while a button is held. 1 is exception 6 while nothing moves, 2 also when the motion has been stopped meanwhile; 0 takes the bound away, as rest does.
                JOG_HOLD: OWN + 52;
                /// F5529: number of the program that Start runs, 0 for none. Writing it selects one, over any reset: exception 3 when there is none of that number, 6 while a program runs.
                SELECTED: OWN + 53;
                /// F5529: line that may write now, 1 the back channel, 2 RS-485; 0: whichever comes first.
                HELM: OWN + 54;
                /// F5529: events that the queue of trace mode holds.
                TRACE_ROOM: OWN + 55;
                /// F5529: number of the last event; write the number up to which all were received.
                TRACE_TAKEN: OWN + 56;
                /// Write one [`Upload`] code.
                UPLOAD_CONTROL: OWN + 60;
                /// Length of the image to come, bytes; bit 15: it uses KEEP.
                UPLOAD_LENGTH: OWN + 61;
                /// [`Refusal`] of the last upload, or of the stored program at power-up.
                UPLOAD_RESULT: OWN + 62;
                /// F5529: number of the program in the library, 1 to 64, that an upload or an erase is for; 0, as behind each of them, for the selected one or a free number.
                UPLOAD_NUMBER: OWN + 63;
                /// Write one [`Stream`] code.
                STREAM_CONTROL: OWN + 64;
                /// Pieces that the board holds.
                STREAM_SLOTS: OWN + 65;
                /// Bytes of code and data that a piece may have.
                STREAM_BYTES: OWN + 66;
                /// Registers that one request may write.
                STREAM_REQUEST: OWN + 67;
                /// F5529: name that the upload gives its program, 8 registers of two characters, the first in the high byte, 0 behind the last.
                UPLOAD_NAME: OWN + 68;
                /// F5529: what TA2 measures at P2.2, P2.3 and P2.4 for a self-test; write 0 for nothing, 1 to count rising edges at P2.2, or 2 for times between an edge at P2.3 and one at P2.4. With 2: bit 3 for ticks of eight cycles instead of one, bits 4 and 5 for rising and falling edges at P2.3, bits 6 and 7 at P2.4. Refused with exception 6 while a program runs or an axis moves.
                MEASURE: OWN + 76;
                /// F5529: what it has found, 6 registers: edges counted, modulo 65536, or samples; shortest and longest time from P2.3 to P2.4, shortest and longest from P2.4 to P2.3, time from the last edge at P2.3 to the last one at P2.4 with its sign; times in ticks.
                MEASURED: OWN + 77;
                /// Trace slot of events with an even number.
                TRACE_EVEN: OWN + 100;
                /// Trace slot of events with an odd number.
                TRACE_ODD: OWN + 108;
                /// Bytes of print that wait.
                PRINT_COUNT: OWN + 120;
                /// Number of the first of them; write to take some.
                PRINT_TAIL: OWN + 121;
                /// 16 registers of text.
                PRINT_TEXT: OWN + 122;
                /// Last `Send`.
                CHAR_OUT: OWN + 140;
                /// Character for `WaitChar` and `CHARIN`.
                CHAR_IN: OWN + 141;
                /// 1 while the program waits with its next effect until a host in trace mode has received the last event.
                WAITS: OWN + 142;
                /// Offset in the image's code of that effect, or of the one under way.
                EFFECT_PLACE: OWN + 143;
                /// Open calls of the program that runs, the outermost first, 0 behind the newest: bits 0..11 the offset it goes back to, above them the kind; on the F5529 two registers each, the offset and the kind in the upper 4 bits.
                OPEN_CALLS: OWN + 144;
            }
        }
    };
}
