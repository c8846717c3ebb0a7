//! The gateway with light boards, through the TCP port that clients have.

use std::io::{ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use super::backoff::Health;
use super::inside::{ADDRESS, Inside};
use super::light::Mishap;
use super::light::{self, Light, Memory, first_value};
use super::line::Open;
use super::{Config, Running};
use crate::client::{Client, ClientError, Patience};
use crate::link::adu::Mbap;
use crate::link::{Link, Mode};
use lang::wire::{self, Control, Upload};

/// Everything of these tests ends long before this, on a loaded machine too.
const PATIENCE: Duration = Duration::from_secs(20);

/// Opens a line of light boards.
fn open(memory: &Arc<Mutex<Memory>>) -> Open {
    let memory = memory.clone();
    Box::new(move || {
        let link: Box<dyn Link> = Box::new(Light::new(memory.clone()));
        Ok(Client::new(link, 1))
    })
}

/// A gateway with boards 1 to `count` on one line, and more of its file.
fn stand(count: u8, more: &str) -> (Arc<Mutex<Memory>>, Running) {
    let mut text = "[modbus]\nlisten = \"127.0.0.1:0\"\nclients = 200\n".to_owned();
    for address in 1..=count {
        text += &format!("[[board]]\nname = \"b{address}\"\nport = \"p\"\naddress = {address}\n");
    }
    let config = Config::parse("test", &(text + more)).expect("a good file");
    let addresses: Vec<u8> = (1..=count).collect();
    let memory = light::boards(&addresses);
    let running = Running::with(&config, |_, _| open(&memory)).expect("it starts");
    (memory, running)
}

struct Guest(TcpStream, Vec<u8>);

impl Guest {
    fn new(address: SocketAddr) -> Guest {
        let stream = TcpStream::connect(address).expect("it listens");
        stream.set_read_timeout(Some(PATIENCE)).expect("a socket");
        stream.set_nodelay(true).expect("a socket");
        Guest(stream, Vec::new())
    }

    fn send(&mut self, transaction: u16, unit: u8, pdu: &[u8]) {
        let message = Mbap { transaction, unit, pdu: pdu.to_vec() };
        self.0.write_all(&message.bytes()).expect("open");
    }

    fn receive(&mut self) -> Mbap {
        Mbap::read(&mut self.0, &mut self.1).expect("an answer")
    }

    fn ask(&mut self, unit: u8, pdu: &[u8]) -> Vec<u8> {
        self.send(7, unit, pdu);
        let Mbap { transaction, unit: own, pdu } = self.receive();
        assert_eq!((transaction, own), (7, unit));
        pdu
    }

    fn is_closed(&mut self) -> bool {
        match self.0.read(&mut [0; 16]) {
            Ok(count) => count == 0,
            Err(error) => error.kind() == ErrorKind::ConnectionReset,
        }
    }
}

/// A read of holding registers.
fn read(first: u16, count: u8) -> Vec<u8> {
    let [high, low] = first.to_be_bytes();
    vec![3, high, low, 0, count]
}

fn value(unit: u8, register: u16) -> Vec<u8> {
    [vec![3, 2], first_value(unit, register).to_be_bytes().to_vec()].concat()
}

fn heard(memory: &Mutex<Memory>) -> usize {
    memory.lock().unwrap_or_else(PoisonError::into_inner).heard.len()
}

#[test]
fn answers_come_from_their_board_in_the_order_of_the_requests() {
    let (_memory, running) = stand(3, "");
    let mut guest = Guest::new(running.address());
    for n in 0..30u16 {
        guest.send(1000 + n, (n % 3) as u8 + 1, &read(100 + n, 1));
    }
    for n in 0..30u16 {
        let reply = guest.receive();
        assert_eq!(reply.transaction, 1000 + n);
        assert_eq!(reply.pdu, value((n % 3) as u8 + 1, 100 + n));
    }
}

#[test]
fn a_unit_that_there_is_not_and_a_board_that_is_dead_are_told_at_once() {
    let (memory, running) = stand(2, "");
    memory.lock().unwrap_or_else(PoisonError::into_inner).dead.push(2);
    let mut guest = Guest::new(running.address());
    assert_eq!(guest.ask(9, &read(1, 1)), [0x83, 0x0A]);
    assert_eq!(guest.ask(0, &read(1, 1)), [0x83, 0x0A], "two boards: none is meant");
    assert_eq!(guest.ask(2, &read(1, 1)), [0x83, 0x0B]);
    let exchanges = heard(&memory);
    for n in 0..200 {
        assert_eq!(guest.ask(2, &read(n, 1)), [0x83, 0x0B]);
    }
    // Within its rests it is asked once or twice more, not two hundred times.
    assert!(heard(&memory) - exchanges <= 6, "{}", heard(&memory) - exchanges);
    assert_eq!(guest.ask(1, &read(1, 1)), value(1, 1));
    memory.lock().unwrap_or_else(PoisonError::into_inner).dead.clear();
    let begun = Instant::now();
    while guest.ask(2, &read(1, 1)) != value(2, 1) {
        assert!(begun.elapsed() < PATIENCE, "it is not found again");
        std::thread::sleep(Duration::from_millis(50));
    }
}

#[test]
fn a_stop_reaches_a_board_whose_reply_was_lost_at_once() {
    let rule = "[[client]]\nfrom = \"any\"\nwrite = [\"RUN_CONTROL\"]\n";
    let (memory, running) = stand(1, rule);
    let mut guest = Guest::new(running.address());
    let [high, low] = lang::wire::RUN_CONTROL.to_be_bytes();
    let (start, stop) = ([6, high, low, 0, 1], [6, high, low, 0, 2]);
    assert_eq!(guest.ask(1, &start), start);
    let dead = |dead: Vec<u8>| {
        memory.lock().unwrap_or_else(PoisonError::into_inner).dead = dead;
    };
    dead(vec![1]);
    assert_eq!(guest.ask(1, &start), [0x86, 0x0B]);
    dead(Vec::new());
    let exchanges = heard(&memory);
    assert_eq!(guest.ask(1, &start), [0x86, 0x0B], "it is left alone for half a second");
    assert_eq!(heard(&memory), exchanges);
    assert_eq!(guest.ask(1, &stop), stop);
    // Of a board that is dead the others have more than stops that nobody hears.
    dead(vec![1]);
    let exchanges = heard(&memory);
    for _ in 0..100 {
        assert_eq!(guest.ask(1, &stop), [0x86, 0x0B]);
    }
    assert!(heard(&memory) - exchanges <= 6, "{}", heard(&memory) - exchanges);
}

#[test]
fn who_sees_a_board_may_stop_it_and_no_more() {
    let [high, low] = lang::wire::RUN_CONTROL.to_be_bytes();
    let (start, stop, emergency) = (
        [6, high, low, 0, 1],
        [6, high, low, 0, 2],
        [6, high, low, 0, Control::EmergencyStop as u8],
    );
    let stop_and_more = [16, high, low, 0, 2, 4, 0, 2, 0, 1];
    for rule in ["", "[[client]]\nfrom = \"any\"\nwrite = [\"coils 0..3\"]\n"] {
        let (_, running) = stand(1, rule);
        let mut guest = Guest::new(running.address());
        assert_eq!(guest.ask(1, &stop), stop, "{rule}");
        assert_eq!(guest.ask(1, &emergency), emergency, "{rule}");
        let code = if rule.is_empty() { 1 } else { 2 };
        assert_eq!(guest.ask(1, &start), [0x86, code], "{rule}");
        assert_eq!(guest.ask(1, &stop_and_more), [0x90, code], "{rule}");
    }
    let (memory, running) = stand(2, "[[client]]\nfrom = \"any\"\nunits = [1]\nstop = false\n");
    let mut guest = Guest::new(running.address());
    assert_eq!(guest.ask(1, &stop), [0x86, 1]);
    assert_eq!(guest.ask(2, &stop), [0x86, 0x0A], "a unit that it does not see");
    assert_eq!(heard(&memory), 0);
}

#[test]
fn nothing_is_written_unless_the_file_says_so() {
    let write = |register: u16, value: u8| {
        let [high, low] = register.to_be_bytes();
        vec![6, high, low, 0, value]
    };
    let (memory, running) = stand(1, "");
    let mut guest = Guest::new(running.address());
    assert_eq!(guest.ask(1, &write(3000, 5)), [0x86, 1]);
    assert_eq!(heard(&memory), 0);
    let rule =
        "[[client]]\nfrom = \"127.0.0.0/8\"\nunits = [1]\nwrite = [\"registers 3000..3003\"]\n";
    let (memory, running) = stand(2, rule);
    let mut guest = Guest::new(running.address());
    assert_eq!(guest.ask(1, &write(3004, 5)), [0x86, 2]);
    assert_eq!(guest.ask(2, &read(3000, 1)), [0x83, 0x0A], "a unit that it does not see");
    assert_eq!(heard(&memory), 0);
    assert_eq!(guest.ask(1, &read(3000, 1)), value(1, 3000));
    assert_eq!(guest.ask(1, &write(3000, 5)), write(3000, 5));
    // What was read before the write is not given again.
    assert_eq!(guest.ask(1, &read(3000, 1)), [3, 2, 0, 5]);
    let counters = guest.ask(247, &read(100, 20));
    let word = |n: usize| u16::from_be_bytes([counters[2 + 2 * n], counters[3 + 2 * n]]);
    let of = |name: &str| {
        let at = super::counters::COUNTERS.iter().position(|(own, _)| *own == name);
        word(2 * at.expect("a counter"))
    };
    assert_eq!((of("unit"), of("health"), of("requests"), of("refused")), (1, 1, 4, 1));
    assert_eq!(guest.ask(247, &write(0, 1)), [0x86, 1]);
    assert_eq!(guest.ask(247, &read(60_000, 1)), [0x83, 2]);
}

#[test]
fn what_is_young_comes_from_memory_and_what_is_wanted_fresh_does_not() {
    let text = "fresh_unit = 101\n";
    let (memory, running) = stand(1, text);
    let mut guest = Guest::new(running.address());
    let begun = Instant::now();
    let asked = 40;
    for _ in 0..asked {
        assert_eq!(guest.ask(1, &read(500, 10)).len(), 22);
    }
    // One exchange in 50 ms, whoever asks.
    let most = begun.elapsed().as_millis() as usize / 50 + 1;
    assert!(heard(&memory) <= most, "{} exchanges", heard(&memory));
    let before = heard(&memory);
    for _ in 0..5 {
        assert_eq!(guest.ask(101, &read(500, 1)), value(1, 500));
    }
    assert_eq!(heard(&memory) - before, 5);
    assert_eq!(running.counters()[0][3] as usize, asked + 5 - heard(&memory));
}

#[test]
fn clients_that_say_nothing_or_half_of_it_harm_nobody() {
    let (_memory, running) = stand(1, "");
    let address = running.address();
    let mut good = Guest::new(address);
    assert_eq!(good.ask(1, &read(1, 1)), value(1, 1));
    // More than there is room for: the silent ones make room, the one that asks stays.
    let mut silent = Vec::new();
    for n in 0..400 {
        let mut guest = Guest::new(address);
        if n % 2 == 0 {
            guest.0.write_all(&[0, 1, 0, 0, 0]).expect("open");
        }
        silent.push(guest);
        if n % 10 == 0 {
            assert_eq!(good.ask(1, &read(1, 1)), value(1, 1));
        }
    }
    let mut foreign = Guest::new(address);
    foreign.0.write_all(b"GET / HTTP/1.1\r\n\r\n").expect("open");
    assert!(foreign.is_closed());
    assert_eq!(good.ask(1, &read(1, 1)), value(1, 1));
    let totals = good.ask(247, &read(0, 14));
    let word = |n: usize| usize::from(u16::from_be_bytes([totals[2 + 2 * n], totals[3 + 2 * n]]));
    assert!(word(2) <= 200, "{} clients", word(2));
    assert!(word(6) >= 200, "{} made room", word(6));
    assert!(silent[0].is_closed());
}

#[test]
fn a_line_that_cannot_be_opened_is_told_and_found_later() {
    let config = "[modbus]\nlisten = \"127.0.0.1:0\"\n[[board]]\nname = \"b\"\nport = \"p\"\n";
    let config = Config::parse("test", config).expect("good");
    let memory = light::boards(&[1]);
    let there = Arc::new(Mutex::new(false));
    let own = there.clone();
    let running = Running::with(&config, |_, _| {
        let (memory, there) = (memory.clone(), own.clone());
        Box::new(move || {
            if !*there.lock().expect("whole") {
                return Err("no such port".to_owned());
            }
            let link: Box<dyn Link> = Box::new(Light::new(memory.clone()));
            let mut client = Client::new(link, 1);
            client.set_mode(Mode::DEFAULT).expect("it has modes");
            Ok(client)
        })
    });
    let running = running.expect("it starts");
    let mut guest = Guest::new(running.address());
    assert_eq!(guest.ask(255, &read(1, 1)), [0x83, 0x0A]);
    *there.lock().expect("whole") = true;
    let begun = Instant::now();
    while guest.ask(255, &read(1, 1)) != value(1, 1) {
        assert!(begun.elapsed() < PATIENCE, "it is not found again");
        std::thread::sleep(Duration::from_millis(50));
    }
}

#[test]
fn one_client_with_many_requests_takes_nobodys_turn() {
    let (_memory, running) = stand(2, "[[client]]\nfrom = \"any\"\nfresh = true\n");
    let address = running.address();
    let until = Instant::now() + Duration::from_secs(2);
    let count = move |unit: u8| {
        std::thread::spawn(move || {
            let mut guest = Guest::new(address);
            let mut count = 0;
            while Instant::now() < until {
                assert_eq!(guest.ask(unit, &read(300, 10)).len(), 22);
                count += 1;
            }
            count
        })
    };
    // Four on one board, one on the other; one client sends all it can without waiting.
    let mut greedy = Guest::new(address);
    for n in 0..500 {
        greedy.send(n, 1, &read(300, 10));
    }
    let counts: Vec<_> = [1, 1, 1, 2].into_iter().map(count).collect();
    let counts: Vec<i32> = counts.into_iter().map(|one| one.join().expect("it counts")).collect();
    let (least, most) = (counts.iter().min().expect("four"), counts.iter().max().expect("four"));
    assert!(*least > 20, "{counts:?}");
    // A request more or less at either end of the time.
    assert!(most - least <= 2 + most / 20, "{counts:?}");
}

/// A client inside the gateway: its requests take their turns on the line like all others.
fn inside(running: &Running) -> Client<Inside> {
    Client::new(Inside::new(&running.gateway, 0, 9), ADDRESS)
}

fn befall(memory: &Mutex<Memory>, mishaps: &[(u16, Mishap)]) {
    memory.lock().unwrap_or_else(PoisonError::into_inner).mishaps = mishaps.to_vec();
}

#[test]
fn a_write_whose_replies_are_lost_twice_is_done() {
    let (memory, running) = stand(1, "");
    let mut client = inside(&running);
    for lost in 0..=2 {
        befall(&memory, &[(300, Mishap::Lost)].repeat(lost));
        client.write(300, 7).unwrap_or_else(|error| panic!("{lost} lost: {error}"));
        assert!(memory.lock().unwrap_or_else(PoisonError::into_inner).mishaps.is_empty());
    }
    // What must not be repeated is asked once, and told.
    befall(&memory, &[(300, Mishap::Lost)]);
    let once = client.once(|client| client.write(300, 7));
    assert!(once.is_err_and(|error| error.may_be_done()));
}

/// The board checks its program before it replies: of 32 KB for two seconds.
#[test]
fn a_start_and_a_commit_are_waited_for_as_long_as_the_board_checks() {
    let (memory, running) = stand(1, "");
    let mut client = inside(&running);
    client.set_patience(Patience { reply: PATIENCE, attempts: 1 });
    let checked = [
        (wire::RUN_CONTROL, Control::Start as u16),
        (wire::UPLOAD_CONTROL, Upload::Commit as u16),
        (wire::SELECTED, 1),
    ];
    for (register, value) in checked {
        befall(&memory, &[(register, Mishap::Late(Duration::from_millis(1_600)))]);
        client.write(register, value).unwrap_or_else(|error| panic!("{register}: {error}"));
    }
    // To a board that is gone none of them goes: the line is not kept for two seconds.
    memory.lock().unwrap_or_else(PoisonError::into_inner).dead.push(1);
    let exchanges = heard(&memory);
    assert!(matches!(client.write(wire::RUN_CONTROL, 1), Err(ClientError::Exception(11))));
    let memory = memory.lock().unwrap_or_else(PoisonError::into_inner);
    assert!(memory.heard[exchanges..].iter().all(|(_, function)| *function == 3));
}

/// The gateway repeats a read. A board that is late answers both, and the second reply looks like one to the next read
/// of as many registers.
#[test]
fn a_late_reply_is_no_reply_to_the_next_request() {
    let (memory, running) = stand(2, "");
    let mut guest = Guest::new(running.address());
    for n in 0..20 {
        assert_eq!(guest.ask(1, &read(n, 1)), value(1, n));
        assert_eq!(guest.ask(2, &read(n, 1)), value(2, n));
    }
    for n in (100..200).step_by(10) {
        befall(&memory, &[(n, Mishap::Late(Duration::from_millis(80)))]);
        for register in n..n + 10 {
            let reply = guest.ask(1, &read(register, 1));
            // On a machine under load it may be too late for both attempts.
            if reply != [0x83, 0x0B] {
                assert_eq!(reply, value(1, register), "{register}");
            }
        }
        while guest.ask(1, &read(1, 2)).len() != 6 {
            std::thread::sleep(Duration::from_millis(50));
        }
    }
}

#[test]
fn orders_of_mqtt_and_cards_leave_a_board_alone_that_is_gone() {
    let (memory, running) = stand(2, "");
    let line = &running.gateway.lines[0];
    let order = |station: usize| {
        let (to, done) = std::sync::mpsc::channel();
        let job = Box::new(move |board: Result<&mut super::line::Board, &str>| {
            let _ = to.send(board.is_ok_and(|board| board.holding(1, 1).is_ok()));
        });
        line.order(9, station, false, job);
        done.recv_timeout(PATIENCE).expect("an answer")
    };
    let dead = |dead: Vec<u8>| memory.lock().unwrap_or_else(PoisonError::into_inner).dead = dead;
    assert!(order(0));
    // The job tells before the line has seen what came of it.
    let settled = |health| {
        let begun = Instant::now();
        while line.stations[0].health() != health {
            assert!(begun.elapsed() < PATIENCE, "it is not {health:?}");
            std::thread::sleep(Duration::from_millis(5));
        }
    };
    settled(Health::Up);
    dead(vec![1]);
    assert!(!order(0));
    settled(Health::Silent);
    let exchanges = heard(&memory);
    let begun = Instant::now();
    for _ in 0..100 {
        assert!(!order(0));
    }
    // Within its rests it is asked now and then, not a hundred times.
    assert!(heard(&memory) - exchanges <= 6, "{}", heard(&memory) - exchanges);
    assert!(begun.elapsed() < PATIENCE);
    assert!(order(1));
    dead(Vec::new());
    let begun = Instant::now();
    while !order(0) {
        assert!(begun.elapsed() < PATIENCE, "it is not found again");
        std::thread::sleep(Duration::from_millis(50));
    }
    settled(Health::Up);
}

#[test]
fn a_jog_of_a_client_that_asks_no_more_is_ended_though_another_one_polls() {
    let (memory, running) = stand(2, "[[client]]\nfrom = \"any\"\nwrite = [\"all\"]\n");
    let (mut mover, mut other) = (Guest::new(running.address()), Guest::new(running.address()));
    let [high, low] = wire::COMMAND.to_be_bytes();
    let run = [16, high, low, 0, 6, 12, 0, 102, 0, 1, 0x4E, 0x20, 0, 0, 3, 0xE8, 0, 0];
    assert_eq!(mover.ask(1, &run), run[..5]);
    let command = |unit: u8| {
        let memory = memory.lock().unwrap_or_else(PoisonError::into_inner);
        let at = |register: u16| memory.registers[&unit].get(&register).copied();
        [at(wire::COMMAND), at(wire::COMMAND + 1)]
    };
    // As long as its client asks, of whatever, it goes on.
    let begun = Instant::now();
    while begun.elapsed() < Duration::from_secs(3) {
        mover.ask(1, &read(1, 1));
        other.ask(1, &read(2, 1));
        std::thread::sleep(Duration::from_millis(20));
    }
    assert_eq!(command(1), [Some(102), Some(1)]);
    let begun = Instant::now();
    while command(1) != [Some(1200), Some(133)] {
        assert!(begun.elapsed() < PATIENCE, "nothing ends it");
        other.ask(1, &read(2, 1));
        std::thread::sleep(Duration::from_millis(20));
    }
    assert!(begun.elapsed() > Duration::from_millis(1_900), "{:?}", begun.elapsed());
    assert_eq!(command(2), [None, None]);
}
