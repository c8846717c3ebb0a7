//! Nothing that a program, a file or the wire contains may crash or hang the emulator.

use emulator::{Board, Config, Format, Image, Parity, Rng, Segment, Wiring};
use proptest::prelude::{any, prop, prop_assert, prop_assert_eq, proptest};

use crate::{IDLE, board};

/// Registers of the part that a random write may hit with effect.
const REGISTERS: std::ops::Range<u16> = 0x0000..0x0200;

proptest! {
    #[test]
    fn random_programs_run(seed in any::<u64>(), direct in any::<bool>()) {
        let mut rng = Rng::new(seed);
        let data: Vec<u8> = (0..0x4000).map(|_| rng.bits() as u8).collect();
        let mut image = Image { segments: vec![Segment { addr: 0xC000, data }], ..Image::default() };
        // Somewhere into the noise.
        image.segments.push(Segment { addr: 0xFFFE, data: vec![rng.bits() as u8, 0xC0 | rng.bits() as u8] });
        let wiring = if direct { Wiring::Direct } else { Wiring::Chain };
        let mut board = Board::with_config(&Config { wiring, ..Config::default() }, &image);
        board.record(true);
        for _ in 0..10 {
            board.uart_send(&[rng.bits() as u8]);
            board.plant_mut().set_input(rng.bits() as u8, rng.bits() & 1 != 0);
            let target = board.cycles() + 20_000;
            board.run_until(target);
            prop_assert!(board.cycles() >= target);
        }
        board.reset_pin();
        board.run_us(100);
    }

    #[test]
    fn random_register_accesses_are_survived(seed in any::<u64>()) {
        let mut rng = Rng::new(seed);
        let mut b = board(&IDLE);
        for _ in 0..300 {
            let addr = REGISTERS.start + rng.below(u64::from(REGISTERS.end - REGISTERS.start)) as u16;
            let key = [0x5A00, 0xA500, 0, 0][rng.below(4) as usize];
            let value = rng.bits() as u16;
            match rng.below(4) {
                0 => b.bus_write8(addr, value as u8),
                1 => b.bus_write16(addr & !1, key | value & 0xFF),
                2 => drop(b.bus_read8(addr)),
                _ => drop(b.bus_read16(addr & !1)),
            }
            b.run_for(rng.below(3000));
        }
    }

    #[test]
    fn damaged_files_are_refused_or_loaded_but_never_panic(
        bytes in prop::collection::vec(any::<u8>(), 0..300),
        prefix in prop::sample::select(vec!["", ":", "@C000\n", "\x7fELF\x01\x01\x01", ":10"]),
    ) {
        let mut file = prefix.as_bytes().to_vec();
        file.extend(bytes);
        let _ = Image::parse(&file);
    }

    #[test]
    fn text_images_round_trip(addr in 0xC000u16..0xFF00, data in prop::collection::vec(any::<u8>(), 1..64)) {
        let row: Vec<String> = data.iter().map(|b| format!("{b:02X}")).collect();
        let image = Image::parse(format!("@{addr:04X}\n{}\nq\n", row.join(" ")).as_bytes());
        prop_assert_eq!(image, Image::from_bytes(addr, &data));
    }

    #[test]
    fn every_character_arrives_in_every_format(
        bytes in prop::collection::vec(any::<u8>(), 1..20),
        baud in prop::sample::select(vec![9_600u32, 19_200, 57_600, 115_200]),
        parity in prop::sample::select(vec![Parity::None, Parity::Even, Parity::Odd]),
    ) {
        let mut b = board(&IDLE);
        b.bus_write8(0x26, 0x06);
        b.bus_write8(0x41, 0x06);
        b.bus_write8(0x60, match parity { Parity::None => 0, Parity::Even => 0xC0, Parity::Odd => 0x80 });
        let divider = 16_000_000 / baud;
        let modulation = (16_000_000 % baud * 8 + baud / 2) / baud;
        b.bus_write8(0x62, divider as u8);
        b.bus_write8(0x63, (divider >> 8) as u8);
        b.bus_write8(0x64, (modulation << 1) as u8);
        b.bus_write8(0x61, 0x80);
        b.set_uart_format(Format { baud, parity });
        for byte in &bytes {
            b.uart_send(&[*byte]);
            let end = b.uart_free() + 10;
            b.run_until(end);
            prop_assert_eq!(b.bus_read8(0x66), *byte);
            b.bus_write8(0x67, *byte);
            b.run_us(2000);
        }
        let back: Vec<u8> = b.uart_take().into_iter().map(|(_, byte)| byte).collect();
        prop_assert_eq!(back, bytes);
        prop_assert_eq!(b.uart_errors(), 0);
    }
}
