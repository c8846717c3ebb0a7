//! `pasapas board`: a virtual board that stays up.

use std::net::{IpAddr, Ipv4Addr};
use std::path::{Path, PathBuf};

use clap::Args;
use lang::profile::Profile;
use lang::record::{BoardRecord, feature};
use serde_json::json;

use super::console::{Console, Options};
use super::part::Choice;
use super::world;
use crate::board::rig::Rig;
use crate::board::serve::{ServeError, Server, Speed};
use crate::board::turns::Manner;
use crate::client::ClientError;
use crate::failure::Failure;
use crate::interrupt;
use crate::output;
use crate::sim::world::{Registers, World};

/// Time from power-up to the first answer, and some more.
const BOOT_US: u64 = 200_000;

/// `pasapas board`
#[derive(Debug, Args)]
pub struct Board {
    /// Make this a link to the pseudo-terminal that the board hangs on
    #[arg(long, value_name = "LINK")]
    pty: Option<PathBuf>,
    /// Speak Modbus TCP on this port of this machine; 0 takes a free one
    #[arg(long, value_name = "PORT")]
    tcp: Option<u16>,
    /// Speak RTU frames on that port instead, as a serial device server passes them on
    #[arg(long, requires = "tcp")]
    rtu: bool,
    /// Let other machines reach that port, at this address of this machine or at all of them. Modbus
    /// knows no login: whoever reaches the port moves the machine
    #[arg(long, value_name = "ADDRESS", requires = "tcp", num_args = 0..=1,
        default_missing_value = "0.0.0.0")]
    listen: Option<IpAddr>,
    /// Scenario around the board; its time begins at power-up. Without one the reference switches
    /// are out of the way until an axis is homed
    #[arg(long, value_name = "W.rhai")]
    world: Option<String>,
    #[command(flatten)]
    part: Choice,
    /// Pace of the board's time: 1 is real time
    #[arg(long, value_name = "N|max", default_value = "1", value_parser = speed)]
    speed: Speed,
    /// Keep the board's flash in this file between runs
    #[arg(long, value_name = "FILE")]
    flash: Option<PathBuf>,
}

fn speed(text: &str) -> Result<Speed, String> {
    if text.eq_ignore_ascii_case("max") {
        return Ok(Speed::Max);
    }
    match text.parse() {
        Ok(times) if (0.001..=1000.0).contains(&times) => Ok(Speed::Times(times)),
        _ => Err("a pace is a number from 0.001 to 1000, or max".to_owned()),
    }
}

impl Board {
    /// Runs the board until Ctrl-C or SIGTERM ends it; then its flash is saved.
    ///
    /// # Errors
    /// A connection cannot be opened, the world is wrong, or the flash's file fails.
    pub fn run(&self, options: &Options, console: &Console) -> Result<(), Failure> {
        let profile = match options.profile(console)? {
            Some(profile) => profile,
            None => Profile::built_in(lang::profile::DEFAULT_NAME)
                .map_err(|error| Failure::Usage(error.to_string()))?,
        };
        let world = world::load(self.world.as_deref(), World::unattended(), console)?;
        let inputs = [self.world.as_deref(), options.profile.as_deref()];
        let inputs = inputs.map(|name| name.map(Path::new));
        output::keep_inputs(&[("--flash", self.flash.as_ref())], &inputs)?;
        let build = self.part.or_default();
        let firmware =
            build.image().map_err(|error| Failure::Board(format!("firmware: {error}")))?;
        let mut rig = Rig::new(build, &firmware, &profile, &world, &Registers::default())
            .map_err(|error| world::wrong(&error, console))?;
        let mut server = Server::default();
        if world.is_unattended() {
            server.place_switches(build, &profile);
        }
        if let Some(file) = &self.flash {
            server
                .keep_flash(&mut rig, file)
                .map_err(|error| Failure::Board(format!("{}: {error}", file.display())))?;
        }
        // A board whose flash was kept has its profile there.
        if options.profile.is_some() && !self.flash.as_ref().is_some_and(|file| file.exists()) {
            let record = BoardRecord::of(&profile, 1);
            let mut bytes = record.to_bytes().to_vec();
            if record.more_crc != 0 {
                if build.part.lacks_feature(feature::POWER) {
                    return Err(Failure::Board(ClientError::NoPwm.to_string()));
                }
                bytes.extend(record.more.to_bytes());
            }
            if record.flags & BoardRecord::STEP_LOW != 0 && !build.part.shapes_steps {
                return Err(Failure::Board(ClientError::NoStepLow.to_string()));
            }
            let first = build.part.profiles[0];
            (first..).zip(bytes).for_each(|(at, byte)| rig.board().poke8(at, byte));
        }
        rig.begin();
        // A client that comes as soon as the port is there must not meet a chip that still boots.
        rig.run_until(rig.ticks(BOOT_US)).map_err(|error| world::wrong(&error, console))?;
        interrupt::watch();
        self.open(&mut server, console)?;
        match server.run(&mut rig, self.speed, &mut |_, _| interrupt::asked()) {
            Ok(()) => Ok(()),
            Err(ServeError::World(error)) => Err(world::wrong(&error, console)),
            Err(ServeError::Flash(file, error)) => {
                Err(Failure::Board(format!("{} cannot be written: {error}", file.display())))
            }
        }
    }

    /// Opens what was asked for, a pseudo-terminal without a link if nothing was, and says where.
    fn open(&self, server: &mut Server, console: &Console) -> Result<(), Failure> {
        let mut places = Vec::new();
        if self.pty.is_some() || self.tcp.is_none() {
            let device = server.clients.open_pty(self.pty.as_deref()).map_err(|error| {
                let link = self.pty.as_ref().map(|link| format!(" {}", link.display()));
                Failure::Board(format!("pseudo-terminal{}: {error}", link.unwrap_or_default()))
            })?;
            places.push(match &self.pty {
                Some(link) => json!({ "port": link.display().to_string(), "device": device }),
                None => json!({ "port": device }),
            });
        }
        if let Some(port) = self.tcp {
            let on = self.listen.unwrap_or(IpAddr::V4(Ipv4Addr::LOCALHOST));
            let (manner, name) =
                if self.rtu { (Manner::Serial, "rtu") } else { (Manner::Mbap, "tcp") };
            let port = server
                .clients
                .open_tcp(on, port, manner)
                .map_err(|error| Failure::Board(format!("TCP port {port} of {on}: {error}")))?;
            places.push(json!({ "port": format!("{name}:{port}") }));
        }
        for place in places {
            if console.json() {
                console.json_line(&place)?;
            } else {
                let port = place["port"].as_str().unwrap_or_default();
                let manner = if port.starts_with("tcp:") { "TCP" } else { "RTU" };
                console.result(&format!("the board answers Modbus {manner} at {port}\n"))?;
            }
        }
        Ok(())
    }
}
