use super::{Here, Plan, Refusal, Sync, plan};
use crate::grbl::Error;
use crate::grbl::block::Block;
use crate::grbl::modal::{Modal, Offsets, Point};
use crate::grbl::order::Order;
use crate::grbl::settings::Machine;
use lang::profile::Profile;

/// Lines one after the other on a machine whose axes are all homed.
struct Lines {
    machine: Machine,
    modal: Modal,
    offsets: Offsets,
    at: Point,
}

impl Lines {
    fn on(name: &str) -> Lines {
        let machine = Machine::of(&Profile::built_in(name).expect("built in"));
        Lines { machine, modal: Modal::default(), offsets: Offsets::default(), at: [0.0; 3] }
    }

    fn try_line(&mut self, text: &str) -> Result<Plan, Refusal> {
        let block = Block::read(text).map_err(Refusal::Error)?;
        let here = Here {
            machine: &self.machine,
            modal: &self.modal,
            offsets: &self.offsets,
            at: self.at,
            homed: [true; 3],
            speed_override: 100,
        };
        let done = plan(&block, &here)?;
        self.modal = done.modal.clone();
        if let Some(offsets) = &done.offsets {
            self.offsets = *offsets.clone();
        }
        self.at = done.to;
        Ok(done)
    }

    fn line(&mut self, text: &str) -> Plan {
        self.try_line(text).unwrap_or_else(|refusal| panic!("{text}: {refusal:?}"))
    }

    fn error(&mut self, text: &str) -> u8 {
        match self.try_line(text) {
            Err(Refusal::Error(Error(n)) | Refusal::Told(Error(n), _)) => n,
            other => panic!("{text}: {other:?}"),
        }
    }
}

fn straight(x: i32, feed: i32) -> Order {
    Order::Line { to: [Some(x), None, None], feed, power: None }
}

#[test]
fn modal_words_hold_over_lines_and_offsets_are_sums() {
    let mut lines = Lines::on("mill");
    assert_eq!(lines.line("G1X10F600").orders, [straight(10_000, 10_000)]);
    assert_eq!(lines.line("G91X5").orders, [straight(15_000, 10_000)]);
    assert_eq!(lines.line("X5").at(), [20.0, 0.0, 0.0]);
    lines.line("G90G10L20P1X0Y0");
    assert_eq!(lines.offsets.wcs[0], [20.0, 0.0, 0.0]);
    assert_eq!(lines.line("X5").orders, [straight(25_000, 10_000)]);
    lines.line("G92X0");
    assert_eq!(lines.line("X1").orders, [straight(26_000, 10_000)]);
    lines.line("G92.1");
    assert_eq!(lines.line("G20X1").orders, [straight(45_400, 10_000)]);
    assert_eq!(lines.line("G53X2F10").orders, [straight(50_800, 4233)]);
    lines.line("G21G55");
    assert_eq!(lines.line("X1").orders, [straight(1000, 4233)]);
    lines.line("G10L2P2X7");
    assert_eq!(lines.line("X1").orders, [straight(8000, 4233)]);
    assert_eq!(lines.line("X1").orders, [], "it is there");
    lines.line("G43.1Z-2");
    assert_eq!(lines.line("Z-1").at()[2], -3.0);
    assert_eq!(lines.line("M30").sync, Some(Sync::End));
    assert_eq!((lines.modal.wcs, lines.modal.relative), (0, false));
}

impl Plan {
    fn at(&self) -> Point {
        self.to
    }
}

#[test]
fn a_bad_line_changes_nothing() {
    let mut lines = Lines::on("mill");
    for (text, number) in [
        ("G1X1", 22),
        ("G91G1X1", 22),
        ("G2X1F60", 35),
        ("G2F60I1", 26),
        ("G2Z1I1F60", 32),
        ("G2X10I4F60", 33),
        ("G2X10R4F60", 34),
        ("G0X1I1", 36),
        ("G0X1P1", 36),
        ("G4", 28),
        ("G10X1", 28),
        ("G10P1X1", 28),
        ("G10L2P7X1", 29),
        ("G10L2P1", 26),
        ("G10L3P1X1", 20),
        ("G92", 26),
        ("G53G2X1I1F1", 30),
        ("G80X1", 31),
        ("G43.1X1", 37),
        ("G38.2F60", 26),
        ("G38.2X1Y1F60", 20),
        ("G38.2X1", 22),
        ("G93G1X1", 22),
        ("G0X9999999", 33),
        ("M42P17S1", 20),
        ("M42P1", 28),
    ] {
        let (modal, offsets, at) = (lines.modal.clone(), lines.offsets.clone(), lines.at);
        assert_eq!(lines.error(text), number, "{text}");
        assert_eq!((&lines.modal, &lines.offsets, lines.at), (&modal, &offsets, at), "{text}");
    }
    assert_eq!(lines.try_line("G0X301"), Err(Refusal::Travel(0)));
    // The arc's ends lie inside, its way does not.
    assert_eq!(lines.try_line("G3X10Y0I5F60"), Err(Refusal::Travel(1)));
}

#[test]
fn arcs_keep_their_centre_and_what_is_too_short_is_none() {
    let mut lines = Lines::on("mill");
    lines.line("G0X50Y50");
    let plan = lines.line("G2X60Y50I5J0F600");
    let wanted = Order::Arc {
        plane: 17,
        clockwise: true,
        to: [Some(60_000), Some(50_000), None],
        center: [5000, 0],
        feed: 10_000,
        power: None,
    };
    assert_eq!(plan.orders, [wanted]);
    assert!((plan.seconds - std::f64::consts::FRAC_PI_2).abs() < 0.001);
    // A full circle, and one that ends where it begins but for less than a um.
    assert!(matches!(lines.line("G2X60Y50I-5").orders[..], [Order::Arc { .. }]));
    assert_eq!(lines.line("G2X60Y49.9997I-5").orders, []);
    // By a radius, and in another plane.
    assert!(matches!(lines.line("G3X50Y50R6").orders[..], [Order::Arc { clockwise: false, .. }]));
    let plan = lines.line("G18G2X60Z0I5K0");
    let [Order::Arc { plane: 18, center, to, .. }] = plan.orders[..] else { panic!("{plan:?}") };
    assert_eq!((center, to), ([0, 5000], [Some(60_000), None, Some(0)]));
}

#[test]
fn a_lasers_power_rides_in_its_lines() {
    let mut lines = Lines::on("laser");
    let power = |plan: &Plan| match plan.orders[..] {
        [Order::Line { power, .. }] => power,
        _ => panic!("{plan:?}"),
    };
    assert_eq!(power(&lines.line("G1X1F600S300")), None, "it is off");
    let plan = lines.line("M4S0");
    let spindle = crate::grbl::modal::Spindle::CounterClockwise;
    assert_eq!(plan.orders, [Order::Spindle(spindle, Some(0))]);
    assert_eq!(power(&lines.line("X2S500")), Some(500));
    assert_eq!(power(&lines.line("X3S5000")), Some(1000), "at most full");
    assert_eq!(lines.line("M8").orders, [], "no coolant, no order");
    assert_eq!(lines.line("S100").orders, [], "with the next line");
    assert_eq!(power(&lines.line("X4")), Some(100));
    // The laser has no Z: Z0 at 0 is nothing.
    assert_eq!(lines.line("G0Z0").orders, []);
    assert_eq!(lines.error("G0Z1"), 20);
    assert!(matches!(lines.line("M2").orders[..], [Order::Spindle(_, None)]));
}

#[test]
fn stored_places_dwells_and_openpnps_words() {
    let mut lines = Lines::on("mill");
    lines.line("G0X10Y20Z-5");
    assert_eq!(lines.line("G28.1").sync, Some(Sync::Rest));
    lines.line("G0X0Y0Z0");
    let plan = lines.line("G91G28Z-1");
    assert_eq!(
        plan.orders,
        [Order::Rapid([None, None, Some(-1000)]), Order::Rapid([None, None, Some(-5000)])]
    );
    assert_eq!(lines.line("G90G28").to, [10.0, 20.0, -5.0]);
    assert_eq!(lines.line("G4P0.25").orders, [Order::Dwell(250)]);
    assert_eq!(lines.line("G4P0").orders, []);
    assert_eq!(lines.line("M42P3S1").orders, [Order::Output(3, true)]);
    assert_eq!(lines.line("M63P3").orders, [Order::Output(3, false)]);
    assert_eq!(lines.line("M66P17L0").sync, Some(Sync::Input(17)));
    assert_eq!(lines.line("M114").sync, Some(Sync::Place));
    assert_eq!(lines.line("M204S500").modal.speed, 0.0);
    assert!(lines.line("M115").firmware);
    let plan = lines.line("G38.3Z-10F60");
    assert!(matches!(plan.orders[..], [Order::Probe { axis: 2, limit: -10_000, .. }]));
    assert_eq!(plan.sync, Some(Sync::Probe { quiet: true }));
}

#[test]
fn feeds_are_kept_within_what_a_board_takes() {
    let mut lines = Lines::on("mill");
    let feed = |plan: Plan| match plan.orders[..] {
        [Order::Line { feed, .. }] => feed,
        _ => panic!("{plan:?}"),
    };
    assert_eq!(feed(lines.line("G1X1F0.001")), 1);
    assert_eq!(feed(lines.line("G1X2F99999999")), 16_000_000);
    // In one fifth of a minute.
    assert_eq!(feed(lines.line("G93X12F5")), 833);
    assert_eq!(lines.error("X13"), 22);
}
