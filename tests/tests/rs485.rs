//! Eight boards on one RS-485 line, beside their back channels: who drives and when, addresses, and who may write.

use emulator::{Board, Config, Edge, Format, Link, Parity, Signal};
use lang::profile::Profile;
use lang::record::{BoardRecord, MoreRecord};
use lang::wire::{
    CRC_START, Control, Exception, HELM, HELM_MS, OVERRIDES, RUN_CONTROL, RUN_STATE, VERSION, crc16,
};
use pasapas::board::F5529;

/// Ticks of a microsecond.
const US: u64 = 10_000;
/// All boards are brought forward by this at a time: less than a character at the fastest rate.
const SLICE: u64 = 50 * US;

/// A board of this address on the line, with that rate there.
fn board(address: u8, rate: u32, parity: &str) -> Board {
    let text = format!(
        "{}\n[rs485]\naddress = {address}\nrate = {rate}\nparity = \"{parity}\"\n",
        include_str!("../../examples/profiles/mill.toml")
    );
    let profile = Profile::parse(&text).expect("a profile");
    let image = F5529.image().expect("the shipped image");
    let config = Config { part: F5529.chip.clone(), ..Config::default() };
    let mut board = Board::with_config(&config, &image);
    let record = BoardRecord::of(&profile, 1);
    let bytes = record.to_bytes().into_iter().chain(record.more.to_bytes());
    (F5529.part.profiles[0]..).zip(bytes).for_each(|(at, byte)| board.poke8(at, byte));
    assert_ne!(record.more(), &MoreRecord::NONE);
    let parity = if parity == "even" { Parity::Even } else { Parity::None };
    board.set_uart_format_on(Link::Rs485, Format { baud: rate, parity });
    board.record(true);
    board.run_us(250_000);
    // Nobody drives the line yet: what stands at the chip's own pin until then is not on it.
    assert!(!board.take_edges().iter().any(|edge| edge.signal == Signal::Drive));
    board.uart_take_on(Link::Rs485);
    board
}

/// A request with its CRC.
fn framed(bytes: &[u8]) -> Vec<u8> {
    let crc = bytes.iter().fold(CRC_START, |crc, byte| crc16(crc, *byte));
    [bytes, &crc.to_le_bytes()].concat()
}

fn read(address: u8, register: u16, count: u8) -> Vec<u8> {
    let [high, low] = register.to_be_bytes();
    framed(&[address, 3, high, low, 0, count])
}

fn write(address: u8, register: u16, value: u16) -> Vec<u8> {
    let ([high, low], [up, down]) = (register.to_be_bytes(), value.to_be_bytes());
    framed(&[address, 6, high, low, up, down])
}

/// The line with its master.
struct Bus {
    boards: Vec<Board>,
    /// Edges of each board since the last exchange.
    edges: Vec<Vec<Edge>>,
    now: u64,
    /// Ticks of a character at most.
    character: u64,
}

impl Bus {
    fn new(count: u8, rate: u32, parity: &str) -> Bus {
        let boards: Vec<Board> = (1..=count).map(|n| board(10 * n, rate, parity)).collect();
        let now = boards.iter().map(Board::cycles).max().expect("some");
        let bits = if parity == "even" { 11 } else { 10 };
        let edges = vec![Vec::new(); boards.len()];
        Bus { boards, edges, now, character: bits * 1_000_000 * US / u64::from(rate) }
    }

    /// Brings all forward; what one says the others hear. Returns what was said.
    fn slice(&mut self) -> Vec<u8> {
        self.now += SLICE;
        let mut said = Vec::new();
        for n in 0..self.boards.len() {
            self.boards[n].run_until(self.now);
            let bytes: Vec<u8> = self.boards[n]
                .uart_take_on(Link::Rs485)
                .into_iter()
                .map(|(_, byte)| byte)
                .collect();
            self.edges[n].extend(self.boards[n].take_edges());
            for (other, board) in self.boards.iter_mut().enumerate() {
                if other != n && !bytes.is_empty() {
                    board.uart_send_on(Link::Rs485, self.now, &bytes);
                }
            }
            said.extend(bytes);
        }
        said
    }

    /// The master's request, to all boards at once, and what comes within `ms`; when its last bit has left.
    fn ask(&mut self, request: &[u8], ms: u64) -> (u64, Vec<u8>) {
        self.edges.iter_mut().for_each(Vec::clear);
        let (now, mut left) = (self.now, 0);
        for board in &mut self.boards {
            left = board.uart_send_on(Link::Rs485, now, request);
        }
        let mut said = Vec::new();
        while self.now < left + ms * 1000 * US {
            said.extend(self.slice());
        }
        (left, said)
    }

    /// From when to when the board with this number drives.
    fn drives(&self, n: usize) -> Vec<(u64, u64)> {
        let own: Vec<&Edge> =
            self.edges[n].iter().filter(|edge| edge.signal == Signal::Drive).collect();
        assert!(own.len().is_multiple_of(2), "it drives on");
        own.chunks(2).map(|pair| (pair[0].cycle, pair[1].cycle)).collect()
    }

    /// First and last edge of what the board with this number sends.
    fn sends(&self, n: usize) -> Option<(u64, u64)> {
        let mut own = self.edges[n].iter().filter(|edge| edge.signal == Signal::Rs485);
        let first = own.next()?.cycle;
        Some((first, own.next_back().map_or(first, |edge| edge.cycle)))
    }
}

#[test]
fn eight_boards_answer_one_after_the_other_and_never_together() {
    let mut bus = Bus::new(8, 115_200, "none");
    for round in 0..3 {
        for n in 0..8u8 {
            let address = 10 * (n + 1);
            let (left, reply) = bus.ask(&read(address, VERSION, 8 + 20 * round), 40);
            assert_eq!(reply[..3], [address, 3, 2 * (8 + 20 * round)], "board {address}");
            let crc = reply.iter().fold(CRC_START, |crc, byte| crc16(crc, *byte));
            assert_eq!(crc, 0, "board {address}");
            for other in 0..8 {
                let drives = bus.drives(other);
                if other != usize::from(n) {
                    assert_eq!(
                        (drives.len(), bus.sends(other)),
                        (0, None),
                        "board {other} is silent"
                    );
                    continue;
                }
                let (first, last) = bus.sends(other).expect("a reply");
                let [(up, down)] = drives[..] else { panic!("{drives:?}") };
                // 1.75 ms of silence first; then the line is driven from before the start bit to behind the last
                // stop bit, and is let go well before the master may speak again.
                assert!(up >= left + 1750 * US - 10 * US, "{} us", (up - left) / US);
                assert!(up < first, "driven first");
                assert!(
                    down >= last && down <= last + 2 * bus.character,
                    "{} us",
                    (down - last) / US
                );
                let end = first + (reply.len() as u64) * bus.character;
                assert!(
                    down + US >= end,
                    "the last bits are driven: {} us",
                    down.abs_diff(end) / US
                );
            }
        }
    }
}

#[test]
fn slow_lines_wait_3_5_characters_and_parity_is_driven_to_its_end() {
    for (rate, parity) in [(9_600, "even"), (19_200, "none"), (57_600, "even")] {
        let mut bus = Bus::new(2, rate, parity);
        let (left, reply) = bus.ask(&read(20, VERSION, 2), 60);
        assert_eq!(reply[..3], [20, 3, 4], "{rate}");
        let (first, _) = bus.sends(1).expect("a reply");
        let [(up, down)] = bus.drives(1)[..] else { panic!("once") };
        let least = if rate > 19_200 { 1750 * US } else { bus.character * 7 / 2 };
        assert!(up + 20 * US >= left + least, "{rate}: {} us", (up - left) / US);
        let end = first + reply.len() as u64 * bus.character;
        assert!(
            down + US >= end && down < end + 2 * bus.character,
            "{rate}: {}",
            down.abs_diff(end) / US
        );
    }
}

#[test]
fn a_broadcast_reaches_all_and_nobody_answers() {
    let mut bus = Bus::new(8, 115_200, "none");
    let (_, reply) = bus.ask(&write(0, OVERRIDES, 70), 20);
    assert!(reply.is_empty(), "{reply:?}");
    for n in 1..=8 {
        let (_, reply) = bus.ask(&read(10 * n, OVERRIDES, 1), 20);
        assert_eq!(reply[..5], [10 * n, 3, 2, 0, 70]);
    }
}

#[test]
fn damaged_and_foreign_frames_change_nothing() {
    let mut bus = Bus::new(3, 115_200, "none");
    let mut wrong = write(10, OVERRIDES, 50);
    wrong[4] ^= 1;
    for request in [&wrong[..], &write(99, OVERRIDES, 50), &[1, 2, 3], &[0; 200]] {
        let (_, reply) = bus.ask(request, 20);
        assert!(reply.is_empty(), "{reply:?}");
    }
    let (_, reply) = bus.ask(&read(10, OVERRIDES, 1), 20);
    assert_eq!(reply[..5], [10, 3, 2, 0, 100]);
}

/// A request by the board's back channel, and its reply.
fn back(board: &mut Board, request: &[u8]) -> Vec<u8> {
    board.uart_take();
    board.uart_send(request);
    board.run_us(25_000);
    board.uart_take().into_iter().map(|(_, byte)| byte).collect()
}

#[test]
fn both_lines_read_and_one_holds_the_helm() {
    let mut bus = Bus::new(1, 115_200, "none");
    let busy = |function: u8, address: u8| [address, function | 0x80, Exception::Busy as u8];
    // RS-485 writes first and holds the helm.
    let (_, reply) = bus.ask(&write(10, OVERRIDES, 90), 20);
    assert_eq!(reply, write(10, OVERRIDES, 90));
    let board = &mut bus.boards[0];
    assert_eq!(back(board, &write(1, OVERRIDES, 80))[..3], busy(6, 1));
    assert_eq!(back(board, &read(1, OVERRIDES, 1))[..5], [1, 3, 2, 0, 90]);
    assert_eq!(back(board, &read(1, HELM, 1))[..5], [1, 3, 2, 0, 2]);
    // It may stop the machine all the same, and nothing else.
    for (code, taken) in [
        (Control::Stop, true),
        (Control::Pause, true),
        (Control::Start, false),
        (Control::Restart, false),
        (Control::EmergencyStop, true),
    ] {
        let reply = back(board, &write(1, RUN_CONTROL, code as u16));
        assert_eq!(reply.get(1) == Some(&6), taken, "{code:?}: {reply:?}");
    }
    assert_ne!(back(board, &read(1, RUN_STATE, 1))[4], 0);
    // Nor by a stop at the head of others: trace mode behind it.
    let [high, low] = RUN_CONTROL.to_be_bytes();
    let two = [1, 16, high, low, 0, 2, 4, 0, Control::Stop as u8, 0, 1];
    assert_eq!(back(board, &framed(&two))[..3], busy(16, 1));
    // Two seconds behind its last write it is free.
    board.run_us(u64::from(HELM_MS) * 1000);
    assert_eq!(back(board, &read(1, HELM, 1))[..5], [1, 3, 2, 0, 0]);
    assert_eq!(back(board, &write(1, OVERRIDES, 80)), write(1, OVERRIDES, 80));
    bus.now = bus.boards[0].cycles();
    let (_, reply) = bus.ask(&write(10, OVERRIDES, 60), 20);
    assert_eq!(reply[..3], busy(6, 10));
}

#[test]
fn both_lines_are_answered_at_once() {
    let mut bus = Bus::new(1, 115_200, "none");
    for shift in 0..12 {
        let board = &mut bus.boards[0];
        board.uart_take();
        let at = board.cycles() + shift * 157 * US;
        board.uart_send_at(at, &read(1, VERSION, 60));
        let (_, reply) = bus.ask(&read(10, VERSION, 60), 60);
        let other: Vec<u8> = bus.boards[0].uart_take().into_iter().map(|(_, byte)| byte).collect();
        assert_eq!((reply.len(), other.len()), (125, 125), "{shift}");
        assert_eq!(reply[1..11], other[1..11], "{shift}");
        for frame in [reply, other] {
            assert_eq!(frame.iter().fold(CRC_START, |crc, byte| crc16(crc, *byte)), 0, "{shift}");
        }
    }
}
