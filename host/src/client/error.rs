//! Errors of an exchange with a board, as messages.

use std::fmt;
use std::io;

use lang::wire::Exception as Code;

/// Exception of a gateway whose board does not answer (Modbus Application Protocol 1.1b3, 7).
pub(super) const TARGET_SILENT: u8 = 11;

/// Why an exchange failed.
#[derive(Debug)]
pub enum ClientError {
    /// No reply came in time, in all attempts.
    Silent,
    /// Bytes came, but no reply was among them.
    Noise(usize),
    /// The board refused with this exception code.
    Exception(u8),
    /// Program and profile are locked.
    Locked,
    /// The code does not open the lock, or a wrong one was given since reset.
    WrongCode,
    /// The profile has a PWM or an RS-485 line, the board none.
    NoPwm,
    /// The profile wants a STEP that is active low.
    NoStepLow,
    /// The port failed.
    Port(io::Error),
    /// Somebody wants to stop the machine: the request was not sent.
    Interrupted,
}

impl ClientError {
    /// Whether the board answered with this exception.
    pub fn is_exception(&self, exception: Code) -> bool {
        matches!(self, ClientError::Exception(code) if *code == exception as u8)
    }

    /// Whether the board may have carried out the request although it failed: the reply was lost, on this line or
    /// between a gateway and the board. Whoever sent a request that must not be repeated has to find out, or has to
    /// undo what it may have begun.
    pub fn may_be_done(&self) -> bool {
        matches!(
            self,
            ClientError::Silent | ClientError::Noise(_) | ClientError::Exception(TARGET_SILENT)
        )
    }
}

impl fmt::Display for ClientError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ClientError::Silent => f.write_str(
                "the board does not answer; check cable, power, --address and the TX/RX jumpers",
            ),
            ClientError::Noise(bytes) => write!(
                f,
                "{bytes} bytes came, but no answer; another rate, parity or device is on the line"
            ),
            // A gateway's, which are no board's.
            ClientError::Exception(10) => f.write_str(
                "the gateway has no way to the board: there is no such unit, it is not for this client, \
                 or its line is not open",
            ),
            ClientError::Exception(11) => {
                f.write_str("the board does not answer its gateway; check its power and its cable")
            }
            ClientError::Exception(code) => {
                let known = Code::ALL.iter().find(|known| **known as u8 == *code);
                let meaning = match known {
                    Some(Code::IllegalFunction) => {
                        "it does not know the function, or it is a gateway whose file lets this client write nothing: \
                         see `[[client]]` there"
                    }
                    Some(Code::IllegalAddress) => {
                        "it has no such register: its firmware is older than this tool and `pasapas flash` brings \
                         this one's, or what has this address is no board of ours"
                    }
                    Some(Code::IllegalValue) => "a value is out of range",
                    Some(Code::DeviceFailure) => "the program or profile is missing or was refused",
                    Some(Code::Busy) => {
                        "not now: a program runs or an axis moves; `pasapas stop` first"
                    }
                    None => "for a reason that no board of ours has: check what hangs on this line",
                };
                write!(f, "the board refused (exception {code}): {meaning}")
            }
            ClientError::Locked => f.write_str(
                "the board's program and profile are locked; --unlock CODE opens the lock",
            ),
            ClientError::WrongCode => f.write_str(
                "this code does not open the board's lock; behind a wrong one the board takes none \
                 until its next reset: press its reset button and try again",
            ),
            ClientError::NoStepLow => f.write_str(
                "this board makes no STEP that is active low; take step_invert out of the profile and wire the \
                 drivers so that STEP is active high, or take a board with an MSP430F5529",
            ),
            ClientError::NoPwm => f.write_str(
                "this board has no PWM, no RS-485, no analog inputs and no analog output; take [pwm], [rs485], [[analog]], \
                 [[threshold]] and [[aout]] out of \
                 the profile, or a board with an MSP430F5529",
            ),
            ClientError::Port(error) => write!(f, "the port failed: {error}"),
            ClientError::Interrupted => f.write_str("Stop came before it"),
        }
    }
}

impl std::error::Error for ClientError {}

#[cfg(test)]
mod tests {
    use super::{ClientError, Code};

    #[test]
    fn a_refusal_says_what_it_means_and_what_to_do() {
        let told = |code: Code| ClientError::Exception(code as u8).to_string();
        let missing = told(Code::IllegalAddress);
        assert!(missing.contains("older") && missing.contains("`pasapas flash`"), "{missing}");
        assert!(told(Code::IllegalFunction).contains("[[client]]"));
        assert!(told(Code::Busy).contains("`pasapas stop`"));
        let foreign = ClientError::Exception(99).to_string();
        assert!(foreign.contains("no board of ours"), "{foreign}");
    }
}
