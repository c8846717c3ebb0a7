//! Reference switches of a live board without a world.
//!
//! They stay out of the way until their axis is homed for the first time, so that a CAM job runs
//! wherever its origin is; then they stand 20 mm beyond the farthest point that the axis has reached, as in `sim`
//! ([`crate::sim::world::World::unattended`]). `sim` knows the program and can look ahead. A live board cannot: a client
//! may home the axis, too. So whenever an axis comes farther towards its switch than before, the question whether it is
//! homing is asked of a copy of the board, which leaves the board itself unchanged.

use emulator::plant::Contact;
use lang::profile::{Direction, Profile};
use lang::record::BoardRecord;
use lang::wire;

use super::Build;
use super::rig::Rig;
use crate::link::adu;
use crate::sim::scene::SWITCH_AWAY_UM;

/// New land that an axis crosses before the board is asked, um: by so much less than 20 mm may the
/// switch stand beyond it.
const LOOK_UM: i64 = 2_000;
/// Time between two looks for the board's answer, us, and how many there are.
const ANSWER_US: u64 = 3_000;
const ANSWER_LOOKS: u32 = 10;

/// See the module.
#[derive(Debug)]
pub struct Switches {
    /// The furthest place of each axis towards its switch, steps from power-up, times the sign of
    /// that direction.
    furthest: [i64; 3],
    /// Where the board keeps its profile.
    records: [u16; 2],
}

impl Switches {
    /// All of them out of the way.
    pub fn new(build: &Build) -> Switches {
        Switches { furthest: [0; 3], records: build.part.profiles }
    }

    /// Looks at the axes; puts the switch of one that homes.
    pub fn look(&mut self, rig: &mut Rig, profile: &Profile) {
        for (axis, own) in profile.axes() {
            let i = axis.index();
            if rig.plant().switches[i].is_some() {
                continue;
            }
            let sign = i64::from(own.home.direction.sign());
            let steps = |um: i64| um * i64::from(own.scale.steps) / i64::from(own.scale.um).max(1);
            let at = rig.motors()[i] * sign;
            if at < self.furthest[i] + steps(LOOK_UM).max(1) {
                continue;
            }
            match self.homing(rig) {
                Some(axes) if axes >> i & 1 != 0 => {
                    let position = sign * (self.furthest[i] + steps(SWITCH_AWAY_UM));
                    let above = own.home.direction == Direction::Positive;
                    let switch = Contact { axis: i, position, above };
                    rig.board().plant_mut().switches[i] = Some(switch);
                }
                Some(_) => self.furthest[i] = at,
                // It was in the middle of a frame: the next look asks again.
                None => {}
            }
        }
    }

    /// Bit per axis that homes, by program or command; nothing where the board does not answer.
    fn homing(&self, rig: &mut Rig) -> Option<u8> {
        let stored = self.records.map(|first| {
            let bytes: [u8; BoardRecord::SIZE] =
                std::array::from_fn(|n| rig.board().peek8(first.wrapping_add(n as u16)));
            BoardRecord::from_bytes(&bytes).address
        });
        let mut addresses = [stored[0], stored[1], 1].to_vec();
        addresses.retain(|address| (1..=247).contains(address));
        addresses.dedup();
        let [high, low] = wire::HOMING.to_be_bytes();
        addresses.into_iter().find_map(|address| {
            rig.set_aside();
            rig.follow_uart();
            let _ = rig.board().uart_take();
            rig.board().uart_send(&adu::rtu(address, &[4, high, low, 0, 1]));
            let mut heard = Vec::new();
            for _ in 0..ANSWER_LOOKS {
                let until = rig.now() + rig.ticks(ANSWER_US);
                let ran = rig.run_until(until);
                heard.extend(rig.board().uart_take().into_iter().map(|(_, byte)| byte));
                if ran.is_err() || adu::open_rtu(&heard).is_some() {
                    break;
                }
            }
            rig.come_back();
            match adu::open_rtu(&heard)? {
                (_, [4, 2, _, axes]) => Some(*axes),
                _ => None,
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use lang::wire::command;

    use super::Switches;
    use crate::board::rig::Rig;
    use crate::board::{BUILDS, Build};
    use crate::client::orders;
    use crate::link::adu;
    use crate::sim::world::{Registers, World};
    use lang::axis::Axis;
    use lang::profile::Profile;

    /// Writes a command, then lets the board run, looking each ms.
    fn run(rig: &mut Rig, switches: &mut Switches, profile: &Profile, order: &[u16], ms: u64) {
        let mut pdu = vec![16];
        pdu.extend(lang::wire::COMMAND.to_be_bytes());
        pdu.extend((order.len() as u16).to_be_bytes());
        pdu.push(2 * order.len() as u8);
        order.iter().for_each(|word| pdu.extend(word.to_be_bytes()));
        rig.follow_uart();
        rig.board().uart_send(&adu::rtu(1, &pdu));
        for _ in 0..ms {
            let until = rig.now() + rig.ticks(1000);
            rig.run_until(until).expect("no world fails");
            switches.look(rig, profile);
        }
    }

    fn live(build: &'static Build) {
        let mill = Profile::built_in("mill").expect("built in");
        let image = build.image().expect("an image");
        let mut rig = Rig::new(build, &image, &mill, &World::unattended(), &Registers::default())
            .expect("a rig");
        rig.begin();
        rig.run_until(rig.ticks(300_000)).expect("it boots");
        let mut switches = Switches::new(build);
        let own = mill.axis(Axis::X).expect("X");
        // 45 mm towards the switch, by a move: nothing is in the way.
        let order = orders::move_to(Axis::X, orders::ramps(own), 8000, -4500);
        assert_eq!(order[0], command::MOVE_TO);
        run(&mut rig, &mut switches, &mill, &order, 1500);
        assert_eq!(rig.motors()[0], -4500, "{}", build.part.name);
        assert!(rig.plant().switches.iter().all(Option::is_none), "{}", build.part.name);
        // Homing finds the switch 20 mm beyond it.
        let order = orders::home(&mill, Axis::X).expect("X homes");
        run(&mut rig, &mut switches, &mill, &order, 3000);
        let switch = rig.plant().switches[0].expect("a switch");
        assert!((-6500..=-6300).contains(&switch.position), "{switch:?}");
        assert!((switch.position - 5..=switch.position + 5).contains(&rig.motors()[0]));
        assert!(rig.plant().switches[1].is_none() && rig.plant().switches[2].is_none());
    }

    #[test]
    fn a_switch_stands_beyond_all_that_its_axis_has_reached_when_it_is_homed() {
        BUILDS.into_iter().for_each(live);
    }
}
