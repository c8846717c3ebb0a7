//! Power is cut at every single flash operation of an upload and of a KEEP write. After each cut
//! the board answers and holds the old program, the new one, or cleanly none.

use emulator::{Board, Config, Stop};
use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};
use lang::record::BoardRecord;
use lang::wire::{
    CRC_START, Control, KEEPS, PROGRAM_CRC, PROGRAM_LENGTH, RUN_CONTROL, RUN_STATE, RunState,
    UPLOAD_CONTROL, UPLOAD_LENGTH, Upload, crc16, upload_window,
};
use pasapas::board::DEFAULT;

/// From power-up to the main loop, a program's check included.
const BOOT_US: u64 = 200_000;

struct Rig(Board);

fn image(script: &str) -> Vec<u8> {
    let source = Source::new("test.bas", script.to_owned());
    let (program, _) = compile(&source, ProfileChoice::built_in());
    lang::back::compile(&program.expect("the script is sound")).expect("it fits").image
}

impl Rig {
    fn new() -> Rig {
        Rig::with_config(Config { part: DEFAULT.chip.clone(), ..Config::default() })
    }

    fn with_config(config: Config) -> Rig {
        let image = DEFAULT.image().expect("the shipped image");
        let mut rig = Rig(Board::with_config(&config, &image));
        // It is told its wiring: before that it has no outputs.
        let record = BoardRecord::DEFAULT.sealed().to_bytes();
        (DEFAULT.part.profiles[0]..).zip(record).for_each(|(at, byte)| rig.0.poke8(at, byte));
        rig.0.run_us(BOOT_US);
        rig
    }

    /// The reply's body, `None` when the board does not answer or refuses.
    fn ask(&mut self, body: &[u8]) -> Option<Vec<u8>> {
        let crc = |bytes: &[u8]| bytes.iter().fold(CRC_START, |crc, &byte| crc16(crc, byte));
        self.0.uart_take();
        self.0.uart_send(&[body, &crc(body).to_le_bytes()].concat());
        let mut reply = Vec::new();
        // A program that fills the area takes 2 s to check.
        for _ in 0..6000 {
            if self.0.run_us(500) == Stop::NoPower {
                return None;
            }
            let more = self.0.uart_take();
            if more.is_empty() && !reply.is_empty() {
                break;
            }
            reply.extend(more.into_iter().map(|(_, byte)| byte));
        }
        let good = reply.len() > 4 && crc(&reply) == 0 && reply[1] & 0x80 == 0;
        // The board keeps 3.5 characters of silence before it listens again.
        self.0.run_us(2000);
        good.then(|| reply[..reply.len() - 2].to_vec())
    }

    fn read(&mut self, address: u16) -> Option<u16> {
        let [high, low] = address.to_be_bytes();
        let reply = self.ask(&[1, 3, high, low, 0, 1])?;
        Some(u16::from_be_bytes([reply[3], reply[4]]))
    }

    fn write(&mut self, address: u16, values: &[u16]) -> Option<()> {
        let [high, low] = address.to_be_bytes();
        let count = values.len() as u8;
        let mut body = vec![1, 16, high, low, 0, count, 2 * count];
        body.extend(values.iter().flat_map(|value| value.to_be_bytes()));
        self.ask(&body).map(drop)
    }

    fn upload(&mut self, image: &[u8], keep: bool) -> Option<()> {
        let length = image.len() as u16 | u16::from(keep) << 15;
        self.write(UPLOAD_LENGTH, &[length])?;
        self.write(UPLOAD_CONTROL, &[Upload::Begin as u16])?;
        let words: Vec<u16> = image
            .chunks(2)
            .map(|pair| u16::from_le_bytes([pair[0], *pair.get(1).unwrap_or(&0xFF)]))
            .collect();
        for (n, words) in words.chunks(21).enumerate() {
            self.write(upload_window(image.len()) + 21 * n as u16, words)?;
        }
        self.write(UPLOAD_CONTROL, &[Upload::Commit as u16])
    }

    /// Length and CRC of the stored program.
    fn stored(&mut self) -> (u16, u16) {
        let length = self.read(PROGRAM_LENGTH).expect("the board answers");
        (length, self.read(PROGRAM_CRC).expect("the board answers"))
    }

    fn run(&mut self) {
        self.write(RUN_CONTROL, &[Control::Start as u16]);
        for _ in 0..40 {
            self.0.run_us(100_000);
            if self.read(RUN_STATE) == Some(RunState::Ready as u16) {
                return;
            }
        }
    }
}

fn identity(image: &[u8]) -> (u16, u16) {
    (image.len() as u16, lang::image::crc_in(image))
}

#[test]
fn an_upload_cut_anywhere_leaves_the_old_program_or_the_new() {
    let old = image("PRINT \"old\"\nSetOut 1, ON\nWait 5ms");
    let new = image("PRINT \"new\"\nSetOut 2, ON");
    let mut rig = Rig::new();
    rig.upload(&old, false).expect("the old program is taken");
    let flash = rig.0.flash_contents();
    let (mut cuts, mut seen) = (0, [false; 2]);
    loop {
        let mut rig = Rig::new();
        rig.0.set_flash_contents(&flash).expect("it is this part's");
        rig.0.power_cut();
        rig.0.power_up();
        rig.0.run_us(BOOT_US);
        rig.0.cut_at_flash_operation(cuts + 1, cuts);
        let done = rig.upload(&new, false).is_some();
        if done {
            break;
        }
        cuts += 1;
        rig.0.power_cut();
        rig.0.power_up();
        rig.0.run_us(BOOT_US);
        let found = rig.stored();
        assert!(found == identity(&old) || found == identity(&new), "cut {cuts}: {found:?}");
        seen[usize::from(found == identity(&new))] = true;
        // And it takes another upload.
        rig.upload(&old, false).unwrap_or_else(|| panic!("no upload after cut {cuts}"));
        assert_eq!(rig.stored(), identity(&old));
    }
    println!("{cuts} cuts");
    assert!(cuts > 90 && seen[0], "{cuts} cuts");
}

#[test]
fn a_keep_value_cut_anywhere_is_the_old_one_or_the_new() {
    let counter = image("KEEP n\nn = n + 1000");
    let mut rig = Rig::new();
    rig.upload(&counter, true).expect("the program is taken");
    rig.run();
    let kept = |rig: &mut Rig| rig.read(KEEPS).expect("the board answers");
    assert_eq!(kept(&mut rig), 1000);
    let flash = rig.0.flash_contents();
    let mut cuts = 0;
    loop {
        let mut rig = Rig::new();
        rig.0.set_flash_contents(&flash).expect("it is this part's");
        rig.0.power_cut();
        rig.0.power_up();
        rig.0.run_us(BOOT_US);
        rig.0.cut_at_flash_operation(cuts + 1, cuts);
        rig.run();
        if rig.0.powered() {
            assert_eq!(kept(&mut rig), 2000);
            break;
        }
        cuts += 1;
        rig.0.power_up();
        rig.0.run_us(BOOT_US);
        let found = kept(&mut rig);
        assert!(found == 1000 || found == 2000, "cut {cuts}: {found}");
        assert_eq!(rig.stored(), identity(&counter));
    }
    println!("{cuts} cuts");
    assert!(cuts >= 4, "{cuts} cuts");
}

#[test]
fn a_program_that_fills_the_area_is_checked_before_the_fastest_watchdog_bites() {
    let line = |i: u32| format!("G0 X{}.{} Y{}.3\n", i * 7 % 250, i % 10, i * 11 % 180);
    let large = image(&(0..4765).map(line).collect::<String>());
    let room = DEFAULT.part.room_for(false);
    assert!((room - 168..=room).contains(&large.len()), "{} bytes do not fill it", large.len());
    // The VLO's upper limit (SLAS735, VLO frequency): the watchdog's interval is 25 ms.
    let mut rig = Rig::with_config(Config {
        part: DEFAULT.chip.clone(),
        vlo_hz: 20_000,
        ..Config::default()
    });
    rig.upload(&large, false).expect("the program is taken");
    assert_eq!(rig.stored(), identity(&large));
    rig.write(RUN_CONTROL, &[Control::Start as u16]).expect("it starts");
    assert_eq!(rig.read(RUN_STATE), Some(RunState::Running as u16));
}
