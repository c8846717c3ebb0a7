//! RESUME, SIN, COS, ATAN2, SCALE and PRINT in units on the MSP430F5529's shipped image: the same values as on the host.

mod rig;

use emulator::Silicon;
use lang::trig::{self, wide};
use lang::wire::{self, RunState};
use rig::company::{long, start};
use rig::{machine, on, read, write};

const SCRIPT: &str =
    "DIM sines AT 3000, angles AT 3002, scaled AT 3004, tries AT 3006, made AT 3008
DIM i, n, d AS LENGTH
ON ERROR GOTO oops
tries = 0
d = -2147483647um
FOR i = -40 TO 40
  sines = sines XOR (SIN(i * 12345mdeg) * 7 + COS(i * 54321mdeg))
  angles = angles XOR (ATAN2(i * 91 - 300, i * 700003 + 3) / 1mdeg + i)
  scaled = scaled XOR SCALE(i * 1000003, -40000000, 40000000, -2000000000, 1234567)
NEXT
n = 12 / tries
PRINT d IN mm; d IN in; d IN mm; d IN in; d IN mm; d IN in; d IN mm; d IN in; 5 / (tries - 1)
made = n * 100 + ERR
END
oops:
tries = tries + 1
IF tries < 5 THEN RESUME
";

#[test]
fn the_image_counts_as_the_host_does() {
    let (mut sines, mut angles, mut scaled) = (0, 0, 0);
    for i in -40..=40 {
        sines ^= trig::sin(i * 12_345, wide) * 7 + trig::cos(i * 54_321, wide);
        angles ^= trig::atan2(i * 91 - 300, i * 700_003 + 3, wide) + i;
        let part = trig::mul_div(i * 1_000_003 + 40_000_000, 2_001_234_567, 80_000_000, wide);
        scaled ^= part.expect("it fits") - 2_000_000_000;
    }
    let mut board = on(Silicon::default(), &machine(""), SCRIPT);
    start(&mut board);
    board.run_us(500_000);
    assert_eq!(read(&mut board, wire::RUN_STATE), Some(RunState::Ready as u16));
    let found = [3000, 3002, 3004, 3006, 3008].map(|register| long(&mut board, register));
    // Twelve by one, after two failures of two statements.
    assert_eq!(found, [sines, angles, scaled, 2, 1202]);
    let mut text = String::new();
    loop {
        let tail = read(&mut board, wire::PRINT_TAIL).expect("it answers");
        // 16 registers show what comes next of it.
        let count = read(&mut board, wire::PRINT_COUNT).expect("it answers").min(32);
        if count == 0 {
            break;
        }
        let words = (0..count.div_ceil(2))
            .map(|n| read(&mut board, wire::PRINT_TEXT + n).expect("it answers"));
        let bytes: Vec<u8> = words.flat_map(u16::to_be_bytes).take(count.into()).collect();
        text.extend(bytes.into_iter().map(char::from));
        write(&mut board, wire::PRINT_TAIL, tail.wrapping_add(count));
    }
    let pair = "-2147483.647mm-84546.6003in";
    assert_eq!(text, format!("{}5\n", pair.repeat(4)));
}
