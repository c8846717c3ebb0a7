//! Addresses of 16 and of 20 bits in one interface.

/// What the calls of a board take as an address or as the value of a register.
pub trait Address: Copy {
    /// The same number in 32 bits.
    fn wide(self) -> u32;
}

impl Address for u16 {
    fn wide(self) -> u32 {
        self.into()
    }
}

impl Address for u32 {
    fn wide(self) -> u32 {
        self
    }
}

/// A literal without a type.
impl Address for i32 {
    fn wide(self) -> u32 {
        self.cast_unsigned()
    }
}
