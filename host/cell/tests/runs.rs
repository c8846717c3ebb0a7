//! Whole runs of a cell by a machine that goes straight ways at constant speed.

mod machine;

use cell::log::What;
use cell::things::Where;
use machine::Machine;

const PICK: &str = r#"cell = 1
table = -60
tool = [{ name = "nozzle", kind = "vacuum", output = 3, input = 3, build_ms = 90, reach = 1.5, body = [{ at = [0, 0, 2], size = [12, 12, 40] }] }]
part = [{ name = "chip", size = [8, 8, 4] }]
feeder = [{ name = "tray", part = "chip", at = [20, 30, -26], pitch = [15, 15], count = [3, 4], empty = [5] }]
fixture = [{ name = "tray floor", at = [35, 52.5, -30], size = [60, 75, 4] }, { name = "wall", at = [100, 60, -60], size = [4, 120, 45] }]
place = [{ name = "belt", at = [150, 60, -16.5], size = [20, 20, 10], room = 0 }]
"#;

/// Picks a pocket of the tray and brings it to the belt, lifted to `lift`.
fn bring(machine: &mut Machine, pocket: [f64; 2], lift: f64, settle_ms: u64) {
    machine.go([pocket[0], pocket[1], 0.0], 60.0);
    machine.go([pocket[0], pocket[1], -22.0], 30.0);
    machine.output(3, true);
    machine.wait(settle_ms);
    machine.go([pocket[0], pocket[1], lift], 60.0);
    machine.go([150.0, 60.0, lift], 100.0);
    machine.go([150.0, 60.0, -12.0], 60.0);
    machine.output(3, false);
    machine.wait(100);
    machine.go([150.0, 60.0, 0.0], 60.0);
}

#[test]
fn a_part_is_taken_carried_and_put_down() {
    let mut machine = Machine::new(PICK);
    bring(&mut machine, [20.0, 30.0], 0.0, 300);
    let said = machine.said();
    assert_eq!(said.len(), 3, "{said:#?}");
    assert!(said[0].contains(r#""ev":"take","thing":"tray.1","by":"nozzle""#));
    assert!(said[1].contains(r#""ev":"drop","thing":"tray.1","mm":0.5"#), "{}", said[1]);
    assert!(said[2].contains(r#""ev":"rest","thing":"tray.1","in":"belt""#));
    // 90 ms * ln(60 / 30) after the pump went on, and off 15 ms * ln(60 / 25) after it went off.
    let on = machine.inputs.iter().find(|input| input.2).unwrap();
    let taken = machine.cell.log()[0].us;
    assert_eq!(
        on.0 - taken,
        62_384 - 36_492,
        "the switch closes at 30 kPa, the part hangs from 20"
    );
    assert_eq!(machine.inputs.len(), 2);
    assert_eq!(machine.cell.things()[0].place, Where::Stands([150.0, 60.0, -16.5]));
}

#[test]
fn an_empty_pocket_gives_no_vacuum() {
    let mut machine = Machine::new(PICK);
    bring(&mut machine, [35.0, 45.0], 0.0, 300);
    assert!(machine.said().is_empty(), "{:#?}", machine.said());
    assert!(machine.inputs.is_empty(), "an open nozzle stays below the switch");
}

#[test]
fn who_does_not_wait_for_the_vacuum_leaves_the_part() {
    let mut machine = Machine::new(PICK);
    bring(&mut machine, [20.0, 30.0], 0.0, 10);
    assert!(machine.said().is_empty(), "{:#?}", machine.said());
}

#[test]
fn a_part_carried_too_low_hits_the_wall_in_its_first_step() {
    let mut machine = Machine::new(PICK);
    machine.cell.line(12);
    bring(&mut machine, [20.0, 30.0], -14.0, 300);
    let hits: Vec<&What> = machine
        .cell
        .log()
        .iter()
        .map(|event| &event.what)
        .filter(|what| matches!(what, What::Hit { .. }))
        .collect();
    let What::Hit { thing, with, pos, line } = hits[0] else { panic!() };
    assert_eq!((thing.as_str(), with.as_str(), *line), ("tray.1", "wall", 12));
    // The wall begins at 98, the part is 8 wide: the first step beyond 94.
    assert_eq!(pos[0], 94.025);
    assert_eq!(hits.len(), 1, "each pair once: {hits:?}");
}

#[test]
fn a_thin_wall_is_met_at_full_speed() {
    let thin = PICK.replace(
        "at = [100, 60, -60], size = [4, 120, 45]",
        "at = [100, 60, -60], size = [0.05, 120, 80]",
    );
    let mut machine = Machine::new(&thin);
    machine.go([150.0, 60.0, 0.0], 2000.0);
    assert!(
        machine.said()[0].contains(r#""ev":"hit","thing":"nozzle","with":"wall""#),
        "{:#?}",
        machine.said()
    );
}

#[test]
fn pecks_are_one_hole_and_a_drill_that_stands_still_breaks() {
    let text = r#"cell = 1
tool = [{ name = "drill", kind = "drill", output = 1, diameter = 0.8, spin_ms = 500 }]
stock = { at = [55, 50, -21.6], size = [50, 40, 1.6] }
"#;
    let mut machine = Machine::new(text);
    machine.output(1, true);
    machine.wait(600);
    machine.go([40.0, 40.0, -18.0], 50.0);
    for depth in [-20.5, -21.0, -22.0] {
        machine.go([40.0, 40.0, depth], 5.0);
        machine.go([40.0, 40.0, -18.0], 50.0);
    }
    machine.go([42.54, 40.0, -18.0], 50.0);
    machine.go([42.54, 40.0, -22.0], 5.0);
    machine.go([43.54, 40.0, -22.0], 5.0);
    machine.go([43.54, 40.0, -18.0], 50.0);
    let said = machine.said();
    assert!(said[0].contains(r#""ev":"hole","at":[40,40],"depth":2"#), "{said:#?}");
    assert!(said[1].contains(r#""why":"moved sideways in its hole""#), "{said:#?}");
    let mut still = Machine::new(text);
    still.output(1, true);
    still.wait(100);
    still.go([40.0, 40.0, -22.0], 500.0);
    assert!(
        still.said()[0].contains(r#""why":"met the stock while it stood still""#),
        "{:#?}",
        still.said()
    );
}

#[test]
fn a_drill_that_stops_in_its_hole_breaks_and_drills_no_deeper() {
    let text = r#"cell = 1
tool = [{ name = "drill", kind = "drill", output = 1, diameter = 0.8 }]
stock = { at = [55, 50, -21.6], size = [50, 40, 1.6] }
"#;
    let mut machine = Machine::new(text);
    machine.output(1, true);
    machine.go([40.0, 40.0, -18.0], 50.0);
    machine.go([40.0, 40.0, -20.5], 5.0);
    machine.output(1, false);
    machine.go([40.0, 40.0, -21.5], 5.0);
    machine.go([40.0, 40.0, -18.0], 50.0);
    let said = machine.said();
    assert!(said[0].contains(r#""why":"stopped turning in its hole""#), "{said:#?}");
    assert!(said[1].contains(r#""ev":"hole","at":[40,40],"depth":0.5"#), "{said:#?}");
}

#[test]
fn a_bead_has_the_mass_of_its_time() {
    let text = r#"cell = 1
tool = [{ name = "needle", kind = "dispenser", output = 4, flow_mg_s = 10, open_ms = 15, close_ms = 10, reach = 1 }]
fixture = [{ name = "plate", at = [31, 40, -33], size = [60, 60, 2.9] }]
"#;
    let mut machine = Machine::new(text);
    machine.go([20.0, 20.0, -30.0], 100.0);
    machine.output(4, true);
    machine.wait(120);
    machine.output(4, false);
    assert!(
        machine.said()[0].contains(r#""mg":1.15"#),
        "120 ms - 15 + 10 at 10 mg/s: {:#?}",
        machine.said()
    );
    machine.go([20.0, 20.0, -20.0], 100.0);
    machine.output(4, true);
    assert!(
        machine.said()[1].contains(r#""ev":"drip","at":[20,20,-20],"mm":10.1"#),
        "{:#?}",
        machine.said()
    );
}

#[test]
fn a_light_barrier_sees_a_held_part_after_its_delay() {
    let eye = "sensor = [{ name = \"eye\", kind = \"beam\", from = [120, 0, -2], to = [120, 120, -2], input = 5, sees = [\"held\"], on_ms = 2 }]\n";
    let mut machine = Machine::new(&format!("{PICK}{eye}"));
    bring(&mut machine, [20.0, 30.0], 0.0, 300);
    let seen: Vec<_> =
        machine.inputs.iter().filter(|input| input.1 == 5 && input.0 > 10_000).collect();
    assert_eq!(
        seen.iter().map(|input| input.2).collect::<Vec<_>>(),
        [true, false],
        "{:?}",
        machine.inputs
    );
}

#[test]
fn expectations_say_what_was_wanted_and_what_was() {
    let expect = r#"expect = [{ what = "in_place", place = "belt", of = "tray", count = 1 }, { what = "no_collision" }, { what = "no_drop", within = 0.4 },
    { what = "nothing_held" }, { what = "nothing_on" }, { what = "time", below_s = 90 }, { what = "prints", text = "hole" }, { what = "ends", text = "done" }]
"#;
    let mut machine = Machine::new(&format!("{PICK}{expect}"));
    bring(&mut machine, [20.0, 30.0], -14.0, 300);
    let end = cell::judge::End {
        us: machine.now,
        how: "F13".to_owned(),
        on: vec![1],
        ..Default::default()
    };
    let rows = cell::judge::judge(&machine.cell, &end, &|_| Err("none".to_owned()));
    let table = cell::judge::table(&rows);
    let holds: Vec<bool> = rows.iter().map(|row| row.holds).collect();
    assert_eq!(holds, [true, false, false, true, false, true, false, false], "{table}");
    assert!(table.contains("tray.1 hit wall at 94.03 47.08 -14.00 in line 0  NO\n"), "{table}");
    assert!(table.contains("tray.1 fell 0.50 mm"), "{table}");
}

/// A nozzle's gauge follows the pressure, and is looked at each millisecond only while it changes.
#[test]
fn a_gauge_follows_the_vacuum() {
    let text = "cell = 1\ntable = -60\n\
        tool = [{ name = \"nozzle\", kind = \"vacuum\", output = 3, analog = 2, volts = [2.9, 0.8], kpa = [0, 60], build_ms = 40 }]\n\
        part = [{ name = \"chip\", size = [8, 8, 4], at = [20, 30, -26] }]\n";
    let mut machine = Machine::new(text);
    let volts = |machine: &Machine| machine.cell.voltages(&machine.at, machine.now);
    assert_eq!(volts(&machine), [(2, 2900)]);
    machine.go([20.0, 30.0, 0.0], 100.0);
    machine.go([20.0, 30.0, -22.2], 100.0);
    machine.output(3, true);
    machine.wait(40);
    // One time constant: 63.2 % of the way.
    let (_, mv) = volts(&machine)[0];
    assert!((1570..1576).contains(&mv), "{mv} mV");
    assert!(
        machine.cell.due(&machine.at, machine.now + 1).is_some_and(|due| due <= machine.now + 1000)
    );
    machine.wait(2000);
    assert_eq!(volts(&machine), [(2, 800)]);
    assert_eq!(machine.cell.due(&machine.at, machine.now + 1), None);
}

/// A distance is that of the first thing in the way.
#[test]
fn a_distance_is_a_voltage() {
    let text = "cell = 1\ntable = -60\n\
        tool = [{ name = \"plate\", kind = \"none\", body = [{ at = [0, 0, 0], size = [10, 10, 10] }] }]\n\
        part = [{ name = \"chip\", size = [8, 8, 4], at = [80, 30, -4] }]\n\
        sensor = [{ name = \"range\", kind = \"distance\", from = [0, 30, -2], to = [100, 30, -2], analog = 1, volts = [0.5, 2.5], sees = [\"part\", \"tool\"] }]\n";
    let mut machine = Machine::new(text);
    let volts = |machine: &Machine| machine.cell.voltages(&machine.at, machine.now);
    // The chip's side is at 76 of 100 mm.
    assert_eq!(volts(&machine), [(1, 2020)]);
    machine.go([45.0, 0.0, -5.0], 100.0);
    assert_eq!(volts(&machine), [(1, 2020)]);
    machine.go([45.0, 30.0, -5.0], 100.0);
    assert_eq!(volts(&machine), [(1, 1300)]);
    // While the plate is in sight it is looked at each millisecond.
    assert!(
        machine.cell.due(&machine.at, machine.now + 1).is_some_and(|due| due <= machine.now + 1000)
    );
    machine.go([45.0, 0.0, -5.0], 100.0);
    assert_eq!(volts(&machine), [(1, 2020)]);
    assert_eq!(machine.cell.due(&machine.at, machine.now + 1), None);
}

/// A drill may touch a stock that tells it; pressed in further while it stands still it breaks.
#[test]
fn a_drill_probes_a_stock_that_tells_its_touch() {
    let text = "cell = 1\ntool = [{ name = \"drill\", kind = \"drill\", output = 1, diameter = 0.8 }]\n\
        stock = { at = [20, 30, -21.6], size = [30, 30, 1.6], touch = 9 }\n";
    let mut machine = Machine::new(text);
    machine.go([20.0, 30.0, 0.0], 100.0);
    machine.go([20.0, 30.0, -20.2], 5.0);
    assert_eq!(machine.inputs.last().map(|input| (input.1, input.2)), Some((9, true)));
    machine.go([20.0, 30.0, 0.0], 100.0);
    assert!(machine.said().is_empty(), "{:?}", machine.said());
    machine.go([20.0, 30.0, -20.6], 5.0);
    assert!(
        machine.said()[0].contains("pressed into the stock while it stood still"),
        "{:?}",
        machine.said()
    );
}
