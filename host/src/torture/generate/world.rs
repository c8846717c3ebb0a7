//! The worlds around generated programs.

use super::Writer;

impl Writer<'_> {
    /// Switches, sensors and people, at any time or only as the program goes on.
    pub(super) fn world(&mut self) -> String {
        let mut text = String::new();
        if self.still {
            return self.still_world();
        }
        let parts = [
            "at(30, || set_in(3, true)); at(140, || set_in(3, false));",
            "at(300, || set_in(4, true)); at(777, || set_in(4, false));",
            "probe_at(\"Z\", -250);",
            "after_out(1, true, 40, || set_in(3, true)); after_out(1, false, 40, || set_in(3, false));",
            "switch_at(\"X\", -300); switch_at(\"Y\", -150); switch_at(\"Z\", 120);",
            "at(25, || send_char(66)); at(400, || send_char(70));",
            "at(411, || press_stop()); at(1000, || press_start());",
            "at(2311, || press_estop());",
            "at(600, || press_start()); at(1600, || press_start()); at(2600, || press_start());",
            "fault_at(100, \"stall\", \"Z\", 7);",
            "hold_stop(3300, 2500);",
        ];
        let rare = [16, 16, 12, 12, 14, 12, 9, 3, 16, 5, 3];
        for (part, chance) in parts.iter().zip(rare) {
            if self.tape.chance(chance / 2) {
                text.push_str(part);
            }
        }
        text
    }

    /// Inputs stand from the beginning or follow an output, and Start comes again and again.
    fn still_world(&mut self) -> String {
        let parts = [
            "at(0, || set_in(3, true));",
            "at(0, || set_in(4, true));",
            "probe_at(\"Z\", -250);",
            "after_out(1, true, 40, || set_in(3, true)); after_out(1, false, 40, || set_in(3, false));",
            "switch_at(\"X\", -300); switch_at(\"Y\", -150); switch_at(\"Z\", 120);",
            "for n in 1..30 { at(n * 700, || press_start()); }",
        ];
        let chances = [6, 6, 9, 8, 10, 12];
        let taken = parts.iter().zip(chances).filter(|(_, chance)| self.tape.chance(*chance));
        // A press behind the end would begin another run before the host has heard of the end.
        let waits = self.out.contains("WaitStart");
        let useful = |part: &&str| waits || !part.contains("press_start");
        let parts: Vec<&str> = taken.map(|(part, _)| *part).collect();
        parts.into_iter().filter(useful).collect()
    }
}
