//! A virtual board in a thread of this process, in real time, for a host in the same process: the shipped image in the
//! emulator, or the MSP430F5529's machine without it, which takes a fraction of a core's time.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, Sender, TryRecvError};
use std::sync::{Arc, Mutex, PoisonError};

use desk::board::NativeBoard;
use lang::axis::Axis;
use lang::profile::{Profile, Wiring};
use lang::record::BoardRecord;

use super::Build;
use super::hardware::Hardware;
use super::rig::Rig;
use super::serve::{ServeError, Server, Speed};
use crate::client::Client;
use crate::client::identity::differences;
use crate::helm::Board;
use crate::link::{Link, Pipe, pipe};
use crate::sim::world::{Button, Registers, World, WorldError};

/// Time from power-up to the first answer, and some more.
const BOOT_US: u64 = 200_000;

/// Something that a hand does to the machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Touch {
    /// Closes or opens the contact of an input.
    Input(u8, bool),
    /// Presses or lets go a button.
    Button(Button, bool),
    /// Pulls the board's reset pin.
    Reset,
    /// The board homed an axis: it rests at this machine position, from which the world's places count.
    Homed(Axis, i32),
}

enum Order {
    Touch(Touch),
    Attach(Pipe),
}

/// What one can see of the machine itself, without asking the board.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Seen {
    /// Where the motors are, steps from power-up.
    pub motors: [i64; 3],
    /// Outputs, bit n - 1.
    pub outputs: u16,
}

/// The board's end of what connects it with its host.
struct Own<'a> {
    ready: &'a Sender<Result<(), LiveError>>,
    todo: &'a Receiver<Order>,
    shown: &'a Mutex<Seen>,
}

/// A board that runs until this is dropped.
pub struct Live {
    orders: Mutex<Sender<Order>>,
    seen: Arc<Mutex<Seen>>,
    profile: Profile,
    ended: Arc<AtomicBool>,
}

impl Live {
    /// Powers an emulated board of a build up, with the machine of `profile` and a world around it.
    ///
    /// # Errors
    /// The firmware or the world is wrong.
    pub fn start(
        build: &'static Build,
        profile: &Profile,
        world: &World,
    ) -> Result<Live, LiveError> {
        Live::of(profile, world, move |profile, world, own| {
            serve(emulated(build, profile, world), own);
        })
    }

    /// The same without an emulator where the part's machine is a library, else emulated.
    ///
    /// # Errors
    /// The firmware or the world is wrong.
    pub fn light(
        build: &'static Build,
        profile: &Profile,
        world: &World,
    ) -> Result<Live, LiveError> {
        if !build.part.look_ahead {
            return Live::start(build, profile, world);
        }
        Live::of(profile, world, |profile, world, own| serve(native(profile, world), own))
    }

    fn of(
        profile: &Profile,
        world: &World,
        serve: impl FnOnce(&Profile, &World, Own<'_>) + Send + 'static,
    ) -> Result<Live, LiveError> {
        let (orders, todo) = mpsc::channel();
        let (ready, started) = mpsc::channel();
        let seen = Arc::new(Mutex::new(Seen::default()));
        let ended = Arc::new(AtomicBool::new(false));
        let (machine, world) = (profile.clone(), world.clone());
        let (shown, over) = (seen.clone(), ended.clone());
        std::thread::spawn(move || {
            serve(&machine, &world, Own { ready: &ready, todo: &todo, shown: &shown });
            over.store(true, Ordering::SeqCst);
        });
        match started.recv() {
            Ok(Ok(())) => {
                Ok(Live { orders: Mutex::new(orders), seen, profile: profile.clone(), ended })
            }
            Ok(Err(error)) => Err(error),
            Err(_) => Err(LiveError::Firmware("the board's thread ended".to_owned())),
        }
    }

    /// A master on the board, which gets the profile's record first if it has another.
    ///
    /// # Errors
    /// The board does not answer.
    pub fn connect(&self) -> Result<Board, String> {
        if self.ended.load(Ordering::SeqCst) {
            return Err("the virtual board ended: its world's script failed".to_owned());
        }
        let (own, other) = pipe();
        self.order(Order::Attach(other));
        let mut board: Board = Client::new(Box::new(own) as Box<dyn Link>, 1);
        board.set_address(self.profile.link.address);
        let words = |error: crate::client::ClientError| error.to_string();
        if board.find().is_err() {
            // A chip that is fresh from the factory has address 1.
            board.set_address(1);
            board.find().map_err(words)?;
        }
        let held = board.board_record().map_err(words)?;
        let wanted = BoardRecord::of(&self.profile, held.sequence.wrapping_add(1));
        if !differences(&held, &wanted).is_empty() {
            board.set_board_record(&wanted).map_err(words)?;
            board.restart().map_err(words)?;
            board.set_address(self.profile.link.address);
            board.find().map_err(words)?;
        }
        Ok(board)
    }

    /// Does something to the machine.
    pub fn touch(&self, touch: Touch) {
        self.order(Order::Touch(touch));
    }

    fn order(&self, order: Order) {
        let orders = self.orders.lock().unwrap_or_else(PoisonError::into_inner);
        // A board that ended takes none.
        let _ = orders.send(order);
    }

    /// What the machine shows by itself.
    pub fn seen(&self) -> Seen {
        *self.seen.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Why a board did not come up.
#[derive(Debug)]
pub enum LiveError {
    /// The shipped image cannot be read.
    Firmware(String),
    /// The world is wrong.
    World(WorldError),
}

fn emulated(build: &Build, profile: &Profile, world: &World) -> Result<Rig, LiveError> {
    let firmware = build.image().map_err(|error| LiveError::Firmware(error.to_string()))?;
    Rig::new(build, &firmware, profile, world, &Registers::default()).map_err(LiveError::World)
}

fn native(profile: &Profile, world: &World) -> Result<Rig<NativeBoard>, LiveError> {
    let board = NativeBoard::new(match profile.wiring {
        Wiring::Direct => emulator::Wiring::Direct,
        Wiring::Chain => emulator::Wiring::Chain,
    });
    Rig::around(board, profile, world, &Registers::default()).map_err(LiveError::World)
}

/// Powers a board up, tells whether it came, and serves it until its host goes.
fn serve<B: Hardware>(rig: Result<Rig<B>, LiveError>, own: Own<'_>) {
    let booted = rig.and_then(|mut rig| {
        rig.begin();
        rig.run_until(rig.ticks(BOOT_US)).map_err(LiveError::World)?;
        Ok(rig)
    });
    match booted {
        Ok(mut rig) => {
            let _ = own.ready.send(Ok(()));
            // What the world's script does wrong later ends the board: the host loses it.
            let _ = live(&mut rig, own.todo, own.shown);
        }
        Err(error) => drop(own.ready.send(Err(error))),
    }
}

fn live<B: Hardware>(
    rig: &mut Rig<B>,
    todo: &Receiver<Order>,
    shown: &Mutex<Seen>,
) -> Result<(), ServeError> {
    Server::default().run(rig, Speed::Times(1.0), &mut |server, rig| {
        let seen = Seen { motors: rig.motors(), outputs: rig.plant().outputs() };
        *shown.lock().unwrap_or_else(PoisonError::into_inner) = seen;
        loop {
            match todo.try_recv() {
                Ok(Order::Touch(touch)) => act(rig, touch),
                Ok(Order::Attach(pipe)) => server.clients.attach(pipe),
                Err(TryRecvError::Empty) => return false,
                Err(TryRecvError::Disconnected) => return true,
            }
        }
    })
}

fn act<B: Hardware>(rig: &mut Rig<B>, touch: Touch) {
    match touch {
        Touch::Input(n, on) => rig.board().plant_mut().set_input(n, on),
        Touch::Button(Button::Start, down) => rig.board().plant_mut().press_start(down),
        Touch::Button(Button::Stop, down) => rig.board().plant_mut().press_stop(down),
        Touch::Reset => rig.board().reset_pin(),
        Touch::Homed(axis, position) => rig.homed(axis, position),
    }
}
