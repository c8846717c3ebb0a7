//! A run of an accepted image under a judge: what it may do is known from its bytes.

use emulator::Rng;
use lang::effect::Effect;
use lang::fault::Fault;
use lang::image::{Image, crc_in, crc_of};
use lang::isa::{self, Op};
use lang::plain::Plain;
use lang::verify::{Limits, verify};
use lang::vm::{Exit, State, Vm};

/// Instructions of one run.
const STEPS: usize = 300;
/// Bytes on both sides of the VM's memory, which must stay as they are.
const GUARD: u8 = 0xA5;
const GUARDS: usize = 16;
/// Anchors of the verifier, as many as it has for 3 KB.
const ANCHORS: usize = 24;

/// Where instructions begin.
fn beginnings(image: &Image<'_>) -> Vec<bool> {
    let mut begins = vec![false; image.code.len()];
    let mut pc = 0;
    while let Some(place) = begins.get_mut(pc) {
        *place = true;
        let Some((op, _)) = image.code.get(pc).and_then(|code| Op::decode(*code)) else { break };
        pc += 1 + op.row().operands.len(image.header.wide());
    }
    begins
}

/// The image, if layout, CRC and verifier accept it for a device.
fn accepted(bytes: &[u8]) -> Option<Image<'_>> {
    let image = Image::new(bytes).ok()?;
    let whole = bytes.get(..image.header.len)?;
    let limits = Limits::device(image.header.features);
    let good = crc_of(whole) == crc_in(whole) && verify(&image, &limits, &mut [0; ANCHORS]).is_ok();
    good.then_some(image)
}

/// Whether layout, CRC and verifier accept the image for a device.
pub fn is_accepted(bytes: &[u8]) -> bool {
    accepted(bytes).is_some()
}

/// Whether the image is accepted; if so it has run.
///
/// # Errors
/// What an accepted image did that none may.
pub fn try_out(bytes: &[u8], rng: &mut Rng) -> Result<bool, String> {
    accepted(bytes).map_or(Ok(false), |image| judged(image, rng).map(|()| true))
}

/// Runs an image as if it had been accepted.
///
/// # Errors
/// What it did that none may.
pub fn judged(image: Image<'_>, rng: &mut Rng) -> Result<(), String> {
    let begins = beginnings(&image);
    let size = image.header.pool_bytes();
    let mut memory = vec![GUARD; size + 2 * GUARDS];
    memory[GUARDS..GUARDS + size].fill(0);
    let mut state = State::new(&image.header);
    for _ in 0..STEPS {
        let before = state.pc;
        let mut vm = Vm::new(image, &mut state, &mut memory[GUARDS..GUARDS + size]);
        let over = pass(&mut vm, &image, rng).map_err(|text| format!("{text} at {before}"))?;
        if over {
            break;
        }
        if !begins.get(state.pc).copied().unwrap_or(false) {
            return Err(format!("pc {} behind {before} is no instruction", state.pc));
        }
        if state.sp > image.header.stack || state.calls > image.header.calls {
            return Err(format!("stack {} and calls {} at {before}", state.sp, state.calls));
        }
    }
    let (below, rest) = memory.split_at(GUARDS);
    match below.iter().chain(&rest[size..]).all(|byte| *byte == GUARD) {
        true => Ok(()),
        false => Err("memory beside the pool was written".to_owned()),
    }
}

/// One instruction, and what may come behind it: an event, a fault, the end of an effect.
/// `true` ends the run.
fn pass(vm: &mut Vm<'_, '_>, image: &Image<'_>, rng: &mut Rng) -> Result<bool, String> {
    const REFUSED: &str = "an accepted image met what none holds";
    let ended = match vm.run(1) {
        Exit::Budget if rng.below(16) == 0 && vm.can_interrupt() && image.events() > 0 => {
            vm.interrupt(rng.below(u64::from(image.events())) as u8).err()
        }
        Exit::Budget | Exit::HandlerEnd | Exit::Course(_) => None,
        Exit::Effect => {
            let effect = vm.effect().ok_or_else(|| {
                let stack = vm.state.sp;
                format!("an effect that nobody knows, with {stack} values on the stack")
            })?;
            let shape = image.code.get(vm.state.pc).and_then(|code| isa::shape(*code));
            shape.ok_or("an effect without a shape")?;
            match effect {
                Effect::Plain(Plain::Wait, [ms, _]) if ms < 0 => vm.fault(Fault::ValueRange).err(),
                Effect::Probe { .. } if rng.below(4) == 0 => {
                    vm.fault_between(Fault::SoftLimit).err()
                }
                _ => {
                    vm.complete(rng.below(9) as i32 - 4);
                    None
                }
            }
        }
        Exit::Fault(Fault::ImageRefused) => return Err(REFUSED.to_owned()),
        Exit::Fault(fault) => vm.fault(fault).err(),
        Exit::End => return Ok(true),
    };
    match ended {
        Some(Fault::ImageRefused) => Err(REFUSED.to_owned()),
        other => Ok(other.is_some()),
    }
}
