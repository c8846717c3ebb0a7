//! Words of mspdebug 0.22 and 0.25 and of TI's library, after the logs in mspdebug's issues 4, 27, 28,
//! 33, 43, 85 and 102, with the G2553's name and identity where a log had another chip.

use super::{Chip, quoted, remedy, told, version};
use lang::part::{F5529, G2553};

/// 0.22 with the driver rf2500.
const RF2500_022: &str = "\
MSPDebug version 0.22 - debugging tool for MSP430 MCUs
Copyright (C) 2009-2013 Daniel Beer <dlbeer@gmail.com>
This is free software; see the source for copying conditions.  There is NO
warranty; not even for MERCHANTABILITY or FITNESS FOR A PARTICULAR PURPOSE.

Trying to open interface 1 on 072
rf2500: warning: can't detach kernel driver: No data available
Initializing FET...
FET protocol version is 30001000
Set Vcc: 3000 mV
Configured for Spy-Bi-Wire
fet: FET returned error code 4 (Could not find device or device not supported)
fet: command C_IDENT1 failed
Using Olimex identification procedure
Device ID: 0x2553
Device: MSP430G2553/G2403
Number of breakpoints: 2
fet: FET returned NAK
warning: device does not support power profiling
Chip ID data: 25 53
";

/// 0.25 with TI's library.
const TILIB_025: &str = "\
MSPDebug version 0.25 - debugging tool for MSP430 MCUs
Chip info database from MSP430.dll v3.15.0.1 Copyright (C) 2013 TI, Inc.

Using new (SLAC460L+) API
MSP430_GetNumberOfUsbIfs
MSP430_GetNameOfUsbIf
Found FET: ttyACM1
MSP430_Initialize: ttyACM1
Firmware version is 31400000
MSP430_VCC: 3000 mV
MSP430_OpenDevice
MSP430_GetFoundDevice
Device: MSP430G2xx3 (id = 0x0040)
2 breakpoints available
MSP430_EEM_Init
";

#[test]
fn the_identity_counts_and_names_where_there_is_none() {
    let with = |bytes: &str| format!("{RF2500_022}    00ff0: {bytes} 00 00 |%S..|\n");
    assert_eq!(told(&with("25 53")), Chip::Known(G2553.chip));
    assert_eq!(told(&with("24 52")), Chip::Other("2452".to_owned()));
    assert_eq!(told("    0ff0: 25 53\n"), Chip::Known(G2553.chip));
    for said in [&with("ff ff"), RF2500_022, TILIB_025] {
        assert_eq!(told(said), Chip::Known(G2553.chip), "{said}");
    }
    let other = TILIB_025.replace("MSP430G2xx3", "MSP430F5529");
    assert_eq!(told(&other), Chip::Known(F5529.chip));
    let far = format!("{other}    00ff0: ff 3f ff 3f\n    01a04: 55 29 18 11\n");
    assert_eq!(told(&far), Chip::Known(F5529.chip));
    assert_eq!(told(&far.replace("55 29", "55 28")), Chip::Other("5528".to_owned()));
    let other = TILIB_025.replace("MSP430G2xx3", "MSP430F5438A");
    assert_eq!(told(&other), Chip::Other("MSP430F5438A".to_owned()));
    assert_eq!(told("nothing\n"), Chip::Unnamed);
}

#[test]
fn the_version_is_read() {
    assert_eq!(version(RF2500_022), Some((0, 22)));
    assert_eq!(version("MSPDebug version 0.25-git - debugging\n"), Some((0, 25)));
    assert_eq!(version("something else"), None);
}

#[test]
fn each_failure_has_its_own_remedy() {
    let cases = [
        (
            "tilib: can't find libmsp430.so: libmsp430.so: cannot open shared object file: No such \
             file or directory",
            "tilib",
            "MSPDebugStack",
        ),
        (
            "FET firmware update is required.\ntilib: device initialization failed",
            "tilib",
            "--allow-fw-update",
        ),
        (
            "rf2500: can't claim interface: Operation not permitted\nrf2500: failed to open",
            "rf2500",
            "may not open it",
        ),
        ("rf2500: can't claim interface: Device or resource busy", "rf2500", "close it"),
        (
            "tilib: MSP430_OpenDevice: Device database not loaded. (error = 98)",
            "tilib",
            "does not fit",
        ),
        (
            "fet: FET returned error code 4 (Could not find device or device not supported)\n\
             fet: missing info\nfet: identify failed",
            "rf2500",
            "jumpers of RST and TEST",
        ),
        ("usbutil: unable to find a device matching 0451:f432", "rf2500", "carries data"),
        ("rf2500: can't receive data: Connection timed out", "rf2500", "unplug"),
        ("something new", "rf2500", "reset button"),
    ];
    for (said, driver, word) in cases {
        let remedy = remedy::of(said, driver);
        assert!(remedy.contains(word), "{said}: {remedy}");
    }
}

#[test]
fn a_good_run_is_no_failure_and_one_that_hides_behind_a_good_code_is() {
    for good in [RF2500_022, TILIB_025] {
        assert!(!remedy::is_failure(good), "{good}");
    }
    assert!(remedy::is_failure("MSP430_GetNumberOfUsbIfs\nNo unused FET found.\n"));
    assert!(remedy::is_failure("tilib: MSP430_Memory: Could not write device memory (error = 7)"));
}

#[test]
fn the_greeting_is_not_repeated() {
    let text = quoted(RF2500_022);
    assert!(!text.contains("Copyright") && text.contains("  Chip ID data: 25 53"), "{text}");
}
