//! What runs need of a chip.

/// What runs look at and do.
pub trait Runs {
    /// The state: [`RunState`](lang::wire::RunState), of which waiting for Start is no part.
    #[cfg_attr(any(), micro(place = "RUN"))]
    fn set_state(&mut self, state: u8);
    /// A run was begun and has not ended.
    #[cfg_attr(any(), micro(any = "RUN, RUN_ACTIVE"))]
    fn is_active(&self) -> bool;
    /// The program runs.
    #[cfg_attr(any(), micro(is = "RUN, RUN_RUNNING"))]
    fn executes(&self) -> bool;
    /// A run rests in a pause.
    #[cfg_attr(any(), micro(is = "RUN, RUN_PAUSED"))]
    fn is_paused(&self) -> bool;
    /// A fault is latched.
    #[cfg_attr(any(), micro(is = "RUN, RUN_FAULT"))]
    fn is_fault(&self) -> bool;
    /// A program is stored, and none runs.
    #[cfg_attr(any(), micro(is = "RUN, RUN_READY"))]
    fn is_ready(&self) -> bool;
    /// A program is stored.
    #[cfg_attr(any(), micro(code = "F word STORED", holds = "NOT_EQUAL"))]
    fn is_stored(&self) -> bool;
    /// How the run ends as soon as everything rests: [`End`](lang::wire::End), 0 for a pause.
    #[cfg_attr(any(), micro(place = "ENDING"))]
    fn ending(&self) -> u8;
    /// See [`Runs::ending`].
    #[cfg_attr(any(), micro(place = "ENDING"))]
    fn set_ending(&mut self, how: u8);
    /// It ends by a fault.
    #[cfg_attr(any(), micro(is = "ENDING, END_FAULT"))]
    fn ends_by_fault(&self) -> bool;
    /// How the last run ended.
    #[cfg_attr(any(), micro(place = "LAST_END"))]
    fn set_last_end(&mut self, how: u8);
    /// The effect's number, which the end is told by.
    #[cfg_attr(any(), micro(place = "N"))]
    fn set_number(&mut self, n: u8);

    /// The Stop button is held.
    #[cfg_attr(any(), micro(any = "BUTTON, P1_STOP"))]
    fn holds_stop(&self) -> bool;
    /// The first input that keeps Start or a move from working, from 1, or 0.
    #[cfg_attr(any(), micro(code = "DO blocking"))]
    fn blocking(&self) -> u8;
    /// The pin of an emergency stop has stopped the steps.
    #[cfg_attr(any(), micro(is = "WATCH, TRIPPED&255"))]
    fn has_tripped(&self) -> bool;
    /// The emergency stop that is on, before the filter; 0 for none.
    #[cfg_attr(any(), micro(code = "DO emergency_now"))]
    fn emergency_now(&self) -> u8;
    /// It is what a fault is by.
    #[cfg_attr(any(), micro(code = "DO emergency_now; PUT FAULT_IN"))]
    fn note_emergency(&mut self);

    /// Everything brakes; the program stands still.
    #[cfg_attr(any(), micro(code = "F clear SPIN; BITS_ON MOTION, M_PAUSE"))]
    fn brake_to_pause(&mut self);
    /// Everything brakes and what was to follow is forgotten.
    #[cfg_attr(any(), micro(code = "DO motion_stop"))]
    fn brake_all(&mut self);
    /// A reference run or a probe by command is given up and counts as failed, and no command's motion goes on.
    #[cfg_attr(any(), micro(code = "DO abandon"))]
    fn give_up(&mut self);
    /// Steps cease at once.
    #[cfg_attr(any(), micro(code = "DO motion_halt"))]
    fn halt(&mut self);
    /// No pin is watched, and none has tripped.
    #[cfg_attr(any(), micro(code = "LET WATCH, 0"))]
    fn unwatch(&mut self);
    /// No axis has homed.
    #[cfg_attr(any(), micro(code = "LET HOMED, 0"))]
    fn forget_homes(&mut self);
    /// Axes move by themselves that the program's end waits for: of the larger chip.
    #[cfg_attr(any(), micro(never = 1))]
    fn goes_on_alone(&mut self) -> bool;
    /// No step comes any more.
    #[cfg_attr(any(), micro(code = "DO motion_rests", holds = "EQUAL"))]
    fn rests(&self) -> bool;
    /// A line goes on through its end.
    #[cfg_attr(any(), micro(any = "MOTION, M_THROUGH", when = "HAS_COURSES"))]
    fn goes_through(&self) -> bool;
    /// The effect under way looks for a switch or inputs.
    #[cfg_attr(
        any(),
        micro(
            code = "GET EFFECT; ADDI -OP_PROBE; CMPI OP_HOME_QUERY-OP_PROBE+1",
            holds = "NO_CARRY"
        )
    )]
    fn seeks(&self) -> bool;
    /// The program goes on with it.
    #[cfg_attr(any(), micro(code = "", ends = "jmp run_goes"))]
    fn go_on(&mut self);

    /// Outputs take the states of an occasion.
    #[cfg_attr(any(), micro(code = "DO output_states"))]
    fn set_outputs_at(&mut self, occasion: u8);
    /// Outputs and inputs are exchanged with the pins.
    #[cfg_attr(any(), micro(code = "CALL io_exchange"))]
    fn exchange(&mut self);
    /// Outputs, number n in bit n - 1.
    #[cfg_attr(any(), micro(place = "OUTPUT"))]
    fn outputs(&self) -> u16;
    /// See [`Runs::outputs`].
    #[cfg_attr(any(), micro(place = "OUTPUT"))]
    fn set_outputs(&mut self, outputs: u16);
    /// Outputs as they were before the pause.
    #[cfg_attr(any(), micro(place = "RESUME_OUTPUT"))]
    fn resume_outputs(&self) -> u16;
    /// See [`Runs::resume_outputs`].
    #[cfg_attr(any(), micro(place = "RESUME_OUTPUT"))]
    fn set_resume(&mut self, outputs: u16);
    /// Level of the spindle's output, 0 without one.
    #[cfg_attr(any(), micro(code = "PROFILE B_SPINDLE; DO output"))]
    fn spindle(&self) -> u8;
    /// How long it takes to come up, ms.
    #[cfg_attr(any(), micro(code = "F base BOARD; FR word B_SPIN_UP, SHORT"))]
    fn spin_up(&self) -> u16;
    /// Milliseconds until motion goes on after a pause.
    #[cfg_attr(any(), micro(place = "SPIN"))]
    fn spin(&self) -> u16;
    /// See [`Runs::spin`].
    #[cfg_attr(any(), micro(place = "SPIN"))]
    fn set_spin(&mut self, ms: u16);

    /// Number of the last fault, 0 for none.
    #[cfg_attr(any(), micro(place = "VM_FAULT"))]
    fn fault(&self) -> u8;
    /// A fault is the last one, and where it is.
    #[cfg_attr(any(), micro(code = "PUT VM_FAULT; F word EFFECT_PC; F put VM_FAULT_PC"))]
    fn latch(&mut self, fault: u8);
    /// A fault that was handled is past.
    #[cfg_attr(any(), micro(code = "LET VM_FAULT, 0"))]
    fn forget_fault(&mut self);
    /// The last fault survives power-off.
    #[cfg_attr(any(), micro(code = "CALL fault_log"))]
    fn log(&mut self);
    /// A line that was to go on waits for its first segment.
    #[cfg_attr(any(), micro(any = "MOTION, M_NEXT", when = "HAS_COURSES"))]
    fn has_next_line(&self) -> bool;
    /// None of its targets may be reached: it has no events.
    #[cfg_attr(any(), micro(code = "LIT 0; F store LEFT"))]
    fn drop_line(&mut self);

    /// Start was pressed: what waits for it goes on.
    #[cfg_attr(any(), micro(code = "BITS_OFF RUN_FLAGS, R_WAITING"))]
    fn release(&mut self);
    /// What comes before a run may begin, 0 for nothing: on the small chip what a command moves.
    #[cfg_attr(any(), micro(place = "MOVING"))]
    fn before_start(&self) -> u8;
    /// Checks the stored program.
    #[cfg_attr(any(), micro(code = "CALL program_attach; F word VM_CODE", holds = "NOT_EQUAL"))]
    fn attach(&mut self) -> bool;
    /// It failed the check.
    #[cfg_attr(any(), micro(code = "LIT F_IMAGE_REFUSED; DO fail"))]
    fn refuse(&mut self);
    /// The VM stands at its beginning; what a run begins with is 0, but for F. On the larger chip the check has put it
    /// there.
    #[cfg_attr(
        any(),
        micro(
            code = "CALL clear_run; F put VM_SP; F put VM_BASE; LIT16 POOL; F put VM_CALLS; \
            F base STORED; FR word SLOT_HEAD+IMAGE_CELLS, SHORT; PUT VM_CELL_COUNT; \
            FR load SLOT_HEAD+IMAGE_CODE-MACHINE_SIZE+MC_FEED, LONG; F store FEED; \
            FR word SLOT_HEAD+IMAGE_ENTRY, SHORT; F add VM_CODE; F put VM_PC; \
            BITS_OFF RUN_FLAGS, R_WAITING|R_TIMED_OUT|R_COURSES",
            sets = "stored"
        )
    )]
    fn enter(&mut self);
    /// The program has courses.
    #[cfg_attr(
        any(),
        micro(
            code = "FR word SLOT_HEAD+IMAGE_CODE-MACHINE_SIZE+MC_FLAGS, SHORT; TESTI MC_COURSES",
            of = "stored",
            holds = "NOT_EQUAL",
            when = "HAS_COURSES"
        )
    )]
    fn program_has_courses(&self) -> bool;
    /// They are taken, and the stack ends in front of them.
    #[cfg_attr(
        any(),
        micro(code = "BITS_ON RUN_FLAGS, R_COURSES; LIT16 COURSE; F put VM_SP; F put VM_BASE")
    )]
    fn take_courses(&mut self);
    /// KEEP values from flash, and the mark by which a reset tells of the run.
    #[cfg_attr(any(), micro(code = "CALL keep_load; LIT16 RUNS_MARK; F put RUNNING"))]
    fn load(&mut self);
    /// The stack ends in front of the ON lines.
    #[cfg_attr(
        any(),
        micro(code = "CALL stack_end; F put VM_SP; F put VM_BASE", when = "HAS_EVENTS")
    )]
    fn set_stack(&mut self);
    /// Nothing was told of the run yet.
    #[cfg_attr(any(), micro(code = "BITS_OFF TRACING, ~(T_ON|T_HEARD|T_LOCKED)&0xff"))]
    fn begin_trace(&mut self);
    /// A host traces that may halt the program.
    #[cfg_attr(any(), micro(any = "TRACING, T_ON", when = "HAS_HALTS"))]
    fn halts(&self) -> bool;
    /// It may do so before the first effect.
    #[cfg_attr(any(), micro(code = "BITS_ON TRACING, T_FULL"))]
    fn halt_first(&mut self);
    /// The run has begun: it is counted, and nothing that moved before counts.
    #[cfg_attr(
        any(),
        micro(
            code = "",
            ends = "/* for an observer of the chip */; .global run_begun; run_begun:; inc &RUNS; br #motion_reset"
        )
    )]
    fn begun(&mut self);

    /// A host that traces has yet to take an event.
    #[cfg_attr(any(), micro(any = "TRACING, T_FULL"))]
    fn tells(&self) -> bool;
    /// What keeps flash from being written, 0 for nothing: on the small chip a reply that is being sent, which an erase
    /// would tear apart.
    #[cfg_attr(any(), micro(place = "LINE_STATE"))]
    fn keeps_flash(&self) -> u8;
    /// KEEP values to flash.
    #[cfg_attr(any(), micro(code = "CALL keep_save"))]
    fn save_kept(&mut self);
    /// A run's courses are given up.
    #[cfg_attr(
        any(),
        micro(code = "BITS_OFF RUN_FLAGS, R_COURSES; F clear JOINS", when = "HAS_COURSES")
    )]
    fn leave_courses(&mut self);
    /// A reset tells of no run, and where an upload stood, which held F while a handler was open, none stands.
    #[cfg_attr(any(), micro(code = "F clear OPEN; F clear RUNNING"))]
    fn unmark(&mut self);
    /// The end is told with its place, which the small chip has already.
    #[cfg_attr(any(), micro(code = ""))]
    fn settle_place(&mut self);
    /// Tells a host that traces of the end, with the last fault.
    #[cfg_attr(any(), micro(code = "EVENT TRACE_END", leaves = 0))]
    fn tell_end(&mut self, fault: i32);
    /// No effect is under way any more.
    #[cfg_attr(any(), micro(code = "F clear EFFECT"))]
    fn forget(&mut self);
    /// The same behind a run: what an effect begins with is 0.
    #[cfg_attr(any(), micro(code = "F clear EFFECT; F clear TIME+2"))]
    fn leave(&mut self);
    /// The chip resets, when it rests without a run.
    #[cfg_attr(any(), micro(code = "BITS_ON RUN_FLAGS, R_RESTART"))]
    fn restart(&mut self);
}
