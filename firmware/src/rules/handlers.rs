//! Faults of the program: start its error handler, or end the run.
//!
//! Only faults of instructions and statements come here; on a part without handlers each of them ends the run.
#![cfg_attr(
    any(),
    micro(module = "rules.handlers", prefix = "handlers_", section = "run", when = "HAS_LINES")
)]

/// What a fault looks at and does.
pub trait Handles {
    /// A fault is the last one; its place is that of the effect or instruction.
    #[cfg_attr(any(), micro(code = "PUT VM_FAULT; F word EFFECT_PC; F put VM_FAULT_PC"))]
    fn note(&mut self, fault: u8);
    /// No effect is under way any more.
    #[cfg_attr(any(), micro(code = "F clear EFFECT"))]
    fn forget(&mut self);
    /// What was printed of a line comes to nothing; on the small chip the byte that counts it is out of reach.
    #[cfg_attr(any(), micro(code = "BITS_OFF TRACING, T_DROPPED+T_ANNOUNCED"))]
    fn abandon_print(&mut self);
    /// Nothing of a statement is left.
    #[cfg_attr(any(), micro(code = "BITS_OFF VM_FLAGS, VM_MORE|VM_WITHIN", when = "HAS_EVENTS"))]
    fn leave_statement(&mut self);
    /// It is one that no handler takes: no room for calls.
    #[cfg_attr(any(), micro(is = "VM_FAULT, F_STACK"))]
    fn is_beyond_handlers(&self) -> bool;
    /// The handler is open.
    #[cfg_attr(any(), micro(any = "VM_FLAGS, VM_ERROR"))]
    fn is_in_handler(&self) -> bool;
    /// There is one.
    #[cfg_attr(any(), micro(code = "F word VM_HANDLER", holds = "NOT_EQUAL"))]
    fn has_handler(&self) -> bool;
    /// The call stack has an entry for it, by which RESUME NEXT goes on: `false` when there is no room, or no table of
    /// statements.
    #[cfg_attr(any(), micro(code = "CALL handler_open", holds = "NOT_EQUAL"))]
    fn open_handler(&mut self) -> bool;
    /// The fault ends the run.
    #[cfg_attr(any(), micro(code = "GET VM_FAULT; DO fail"))]
    fn fail(&mut self);
    /// The program goes on with the handler.
    #[cfg_attr(any(), micro(code = "BITS_ON VM_FLAGS, VM_ERROR; F word VM_HANDLER; F put VM_PC"))]
    fn enter_handler(&mut self);
    /// F of what it has interrupted is put aside: it has none.
    #[cfg_attr(any(), micro(code = "F load FEED; F store FEED_ASIDE; LIT 0; F store FEED"))]
    fn put_feed_aside(&mut self);
    /// The expression stack is that of the open routine's beginning.
    #[cfg_attr(any(), micro(code = "", ends = "jmp run_unwind"))]
    fn unwind(&mut self);
}

/// A fault of an instruction or statement.
#[cfg_attr(any(), micro(entry = "raise", begins = "clr.b &PRINT_OPEN"))]
pub fn raise(m: &mut impl Handles, fault: u8) {
    m.note(fault);
    m.forget();
    m.abandon_print();
    m.leave_statement();
    if m.is_beyond_handlers() || m.is_in_handler() || !m.has_handler() || !m.open_handler() {
        return m.fail();
    }
    m.enter_handler();
    m.put_feed_aside();
    m.unwind();
}
