//! Images that were damaged, with their CRC made good again: the verifier refuses them, or the VM
//! runs them without ever leaving its memory. A VM that meets what a verified image cannot hold
//! reports F15, so F15 is what must not come.

use lang::effect::{Effect, Read};
use lang::fault::Fault;
use lang::image::{self, HEADER, Image, at};
use lang::plain::Plain;
use lang::record::MachineRecord;
use lang::vm::{Exit, State, Vm};
use proptest::prelude::*;
use std::sync::OnceLock;

/// Instructions of one run.
const STEPS: usize = 2_000;
/// A byte that the VM must not touch stands on both sides of its memory.
const GUARD: u8 = 0xA5;
const GUARDS: usize = 64;

fn images() -> &'static [Vec<u8>] {
    static IMAGES: OnceLock<Vec<Vec<u8>>> = OnceLock::new();
    IMAGES.get_or_init(|| {
        let files = ["run", "back", "check/ok"].into_iter().flat_map(super::scripts);
        let texts = files.map(|file| std::fs::read_to_string(file).unwrap());
        let parts =
            texts.flat_map(|text| text.split("' ---\n").map(str::to_owned).collect::<Vec<_>>());
        parts.map(|part| super::compile(&part).image).collect()
    })
}

/// Runs an image that the verifier accepted; events and faults come as they may.
fn run(bytes: &[u8], image: Image<'_>) {
    let size = image.header.pool_bytes();
    let mut memory = vec![GUARD; size + 2 * GUARDS];
    memory[GUARDS..GUARDS + size].fill(0);
    let (pool_start, pool_end) = (GUARDS, GUARDS + size);
    let mut state = State::new(&image.header);
    for step in 0..STEPS {
        let mut vm = Vm::new(image, &mut state, &mut memory[pool_start..pool_end]);
        let fault = match vm.run(1) {
            Exit::Budget => {
                // Between instructions, as a host would: events, and a fault that comes as one.
                if step % 17 == 0 && vm.can_interrupt() && image.events() > 0 {
                    vm.interrupt((step % usize::from(image.events())) as u8).err()
                } else {
                    None
                }
            }
            Exit::HandlerEnd | Exit::Course(_) => None,
            Exit::Effect => {
                let effect = vm.effect().expect("the verifier knows every flag");
                match effect {
                    Effect::Plain(Plain::Wait, [ms, _]) if ms < 0 => {
                        vm.fault(Fault::ValueRange).err()
                    }
                    Effect::Probe { .. } if step % 5 == 0 => {
                        vm.fault_between(Fault::SoftLimit).err()
                    }
                    effect => {
                        let looks = matches!(effect, Effect::Read(Read::In(_)));
                        vm.complete(if looks { (step as i32) & 1 } else { step as i32 - 500 });
                        None
                    }
                }
            }
            Exit::Fault(fault) => {
                assert_ne!(fault, Fault::ImageRefused, "at {} of {bytes:02X?}", vm.state.pc);
                vm.fault(fault).err()
            }
            Exit::End => return,
        };
        if let Some(fault) = fault {
            assert_ne!(fault, Fault::ImageRefused, "{bytes:02X?}");
            break;
        }
    }
    let (below, rest) = memory.split_at(pool_start);
    assert!(below.iter().chain(&rest[size..]).all(|&byte| byte == GUARD));
}

fn try_out(bytes: &mut [u8]) -> bool {
    image::seal(bytes);
    let Ok(image) = super::check(bytes) else { return false };
    run(bytes, image);
    true
}

#[test]
fn undamaged_images_run() {
    for image in images() {
        assert!(try_out(&mut image.clone()));
    }
}

#[test]
fn every_single_byte_may_be_anything() {
    let mut accepted = 0;
    for image in images().iter().take(8) {
        for at in (0..HEADER).chain(HEADER + MachineRecord::SIZE..image.len()) {
            for bit in 0..8 {
                let mut damaged = image.clone();
                damaged[at] ^= 1 << bit;
                accepted += usize::from(try_out(&mut damaged));
            }
        }
    }
    assert!(accepted > 100, "a test that refuses everything shows nothing");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 4_000, ..ProptestConfig::default() })]
    #[test]
    fn a_few_bytes_may_be_anything(
        which in 0usize..1000,
        changes in prop::collection::vec((0usize..10_000, any::<u8>()), 1..6),
        moved in prop::option::of((0usize..10_000, 0usize..10_000, 1usize..20)),
    ) {
        let images = images();
        let mut image = images[which % images.len()].clone();
        // Header and code are where the VM could be led astray; the profile is the motion's.
        let places: Vec<usize> =
            (14..HEADER).chain(HEADER + MachineRecord::SIZE..image.len()).collect();
        for (at, byte) in changes {
            image[places[at % places.len()]] = byte;
        }
        if let Some((from, to, len)) = moved {
            for i in 0..len {
                let byte = image[places[(from + i) % places.len()]];
                image[places[(to + i) % places.len()]] = byte;
            }
        }
        try_out(&mut image);
    }

    #[test]
    fn any_code_at_all(
        code in prop::collection::vec(any::<u8>(), 1..60),
        cells in prop_oneof![0u8..20, 253u8..],
        depths in (0u8..16, 0u8..16, 0u8..16),
    ) {
        let mut bytes = images()[0].clone();
        let start = HEADER + MachineRecord::SIZE;
        bytes.truncate(start);
        bytes.extend(&code);
        // No instruction falls off the end; a little data for those that read some.
        bytes.push(0);
        bytes.extend([1, 2, 10, 0, 20, 0, 3, b'a', b'b', b'c']);
        let len = bytes.len();
        bytes[at::LEN..][..2].copy_from_slice(&(len as u16).to_le_bytes());
        bytes[at::CODE_LEN..][..2].copy_from_slice(&(code.len() as u16 + 1).to_le_bytes());
        bytes[1] = 0;
        bytes[at::ENTRY..][..2].fill(0);
        bytes[at::CELLS] = cells;
        (bytes[at::STACK], bytes[at::FRAME], bytes[at::CALLS]) = depths;
        (bytes[at::KEEPS], bytes[at::KEEP_BASE]) = (0, 0);
        try_out(&mut bytes);
    }

    #[test]
    fn junk_is_refused_without_harm(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        prop_assert!(super::check(&bytes).is_err());
    }
}
