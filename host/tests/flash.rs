//! `pasapas flash` with a stand-in for mspdebug that says what 0.22, 0.25 and TI's library say (after
//! the logs in mspdebug's issues), and the image's files as the real mspdebug reads them.
#![cfg(target_os = "linux")]

mod common;

use std::fs;
use std::os::unix::fs::PermissionsExt as _;
use std::process::{Command, Stdio};

use common::sysfs;
use tempfile::TempDir;

/// A folder with a tool that is called mspdebug.
struct Desk {
    folder: TempDir,
    usb: TempDir,
}

const RF2500: (&str, &str) = ("0451", "f432");
const EZ_FET: (&str, &str) = ("2047", "0013");
const BOOT_LOADER: (&str, &str) = ("2047", "0200");

/// mspdebug 0.22 and 0.25 with the driver rf2500: the name differs.
fn rf2500(name: &str, id: &str) -> String {
    format!(
        "Trying to open interface 1 on 072\nInitializing FET...\nFET protocol version is 30001000\n\
         Set Vcc: 3000 mV\nConfigured for Spy-Bi-Wire\nDevice ID: 0x{}\nDevice: {name}\nNumber of \
         breakpoints: 2\nfet: FET returned NAK\nwarning: device does not support power profiling\n\
         Chip ID data: {id}\n    00ff0: {id} 00 00 00 00 00 00 00 00 00 00 00 00 00 00 |%S..|\n",
        id.replace(' ', "")
    )
}

/// mspdebug 0.25 with TI's library.
const TILIB: &str = "Using new (SLAC460L+) API\nMSP430_GetNumberOfUsbIfs\nMSP430_GetNameOfUsbIf\n\
    Found FET: ttyACM1\nMSP430_Initialize: ttyACM1\nFirmware version is 31400000\nMSP430_VCC: 3000 \
    mV\nMSP430_OpenDevice\nMSP430_GetFoundDevice\nDevice: MSP430G2xx3 (id = 0x0040)\n2 breakpoints \
    available\nMSP430_EEM_Init\n    00ff0: 25 53 00 00 00 00 00 00 00 00 00 00 00 00 00 00 |%S..|\n\
    MSP430_Run\nMSP430_Close\n";

impl Desk {
    fn new(devices: &[(&str, &str)]) -> Desk {
        let devices: Vec<_> =
            devices.iter().map(|id| (id.0, id.1, "00", "ttyACM0".to_owned())).collect();
        Desk { folder: tempfile::tempdir().expect("a folder"), usb: sysfs(&devices) }
    }

    /// Puts the stand-in there: its release, what it says when asked for the chip, what when writing.
    fn says(&self, release: &str, asked: (&str, i32), writing: (&str, i32)) -> &Desk {
        let path = |name: &str| self.folder.path().join(name);
        let greeting = format!(
            "MSPDebug version {release} - debugging tool for MSP430 MCUs\nCopyright (C) 2009-2013 \
             Daniel Beer <dlbeer@gmail.com>\n"
        );
        for (name, text) in
            [("version.txt", &*greeting), ("asked.txt", asked.0), ("writing.txt", writing.0)]
        {
            fs::write(path(name), text).expect("a file");
        }
        let tool = format!(
            "#!/bin/sh\ncd '{}'\necho \"$@\" >> commands.txt\ncat version.txt\ncase \"$*\" in\n\
             --version) ;;\n*prog*|*load*) cat writing.txt; exit {} ;;\n*) cat asked.txt >&2; exit {} ;;\n\
             esac\n",
            self.folder.path().display(),
            writing.1,
            asked.1
        );
        fs::write(path("mspdebug"), tool).expect("a file");
        fs::set_permissions(path("mspdebug"), fs::Permissions::from_mode(0o755)).expect("mode");
        self
    }

    fn flash(&self, args: &[&str]) -> (Option<i32>, String) {
        let output = Command::new(env!("CARGO_BIN_EXE_pasapas"))
            .arg("flash")
            .args(args)
            .current_dir(self.folder.path())
            .env("PATH", format!("{}:/usr/bin:/bin", self.folder.path().display()))
            .env("PASAPAS_SYSFS", self.usb.path())
            .stdin(Stdio::null())
            .output()
            .expect("the tool starts");
        let text = [output.stdout, output.stderr].concat();
        (output.status.code(), String::from_utf8(text).expect("UTF-8"))
    }

    fn commands(&self) -> String {
        fs::read_to_string(self.folder.path().join("commands.txt")).unwrap_or_default()
    }
}

const WRITTEN: (&str, i32) = ("Erasing...\nProgramming...\nDone, 13286 bytes total\n", 0);

#[test]
fn the_driver_is_that_of_the_programmer_that_is_plugged_in() {
    let cases = [
        (RF2500, "0.22", rf2500("MSP430G2553/G2403", "25 53"), "rf2500"),
        (RF2500, "0.25", rf2500("MSP430G2xx3", "25 53"), "rf2500"),
        (EZ_FET, "0.25", TILIB.to_owned(), "tilib"),
    ];
    for (device, release, said, driver) in cases {
        let desk = Desk::new(&[device]);
        let (code, text) = desk.says(release, (&said, 0), WRITTEN).flash(&[]);
        assert_eq!(code, Some(0), "{driver} {release}: {text}");
        assert!(text.contains(" for the MSP430G2553 is on the board"), "{text}");
        assert!(text.contains("the stored program and the KEEP values go"), "{text}");
        let commands = desk.commands();
        assert_eq!(commands.matches("prog ").count(), 1, "{commands}");
        assert_eq!(commands.matches("verify ").count(), 1, "{commands}");
        assert!(commands.lines().skip(1).all(|line| line.starts_with(driver)), "{commands}");
    }
}

#[test]
fn another_chip_is_never_written_whatever_its_name() {
    let desk = Desk::new(&[RF2500]);
    // The names of whole families stand in mspdebug's lists: the identity counts.
    let said = rf2500("MSP430G2xx3", "24 52");
    for args in [&[][..], &["--part", "g2553-handlers"], &["--part", "f5529"]] {
        let (code, text) = desk.says("0.25", (&said, 0), WRITTEN).flash(args);
        assert!(code == Some(4) && text.contains("it is 2452"), "{text}");
    }
    assert!(!desk.commands().contains("prog"), "{}", desk.commands());
}

/// mspdebug 0.25 with TI's library and an MSP430F5529, whose identity lies elsewhere.
fn f5529() -> String {
    TILIB.replace("MSP430G2xx3 (id = 0x0040)", "MSP430F5529 (id = 0x0030)").replace(
        "    00ff0: 25 53 00 00 00 00 00 00 00 00 00 00 00 00 00 00 |%S..|",
        "    00ff0: ff 3f ff 3f ff 3f ff 3f ff 3f ff 3f ff 3f ff 3f |.?.?|\n    01a04: 55 29 18 11 06 0a \
         00 00 00 00 00 00 00 00 00 00 |U)..|",
    )
}

#[test]
fn of_an_f5529_only_the_firmwares_own_segments_are_erased() {
    let desk = Desk::new(&[EZ_FET]);
    desk.says("0.25", (&f5529(), 0), WRITTEN);
    let (code, text) = desk.flash(&[]);
    assert_eq!(code, Some(0), "{text}");
    assert!(text.contains("the stored program, the KEEP values, the machine's profile"), "{text}");
    assert!(text.contains("the firmware f5529 for the MSP430F5529 is on the board"), "{text}");
    let commands = desk.commands();
    assert!(!commands.contains("prog ") && commands.contains("load "), "{commands}");
    // Flash below 64 KB up to the program area, what is above, and the vectors.
    let ranges: Vec<&str> = commands.split("erase segrange ").skip(1).collect();
    assert!(ranges.len() >= 2 && ranges[0].starts_with("0x4400 "), "{commands}");
    for range in ranges {
        let numbers: Vec<u32> = range
            .split_whitespace()
            .take(3)
            .filter_map(|word| u32::from_str_radix(word.trim_start_matches("0x"), 16).ok())
            .collect();
        let [first, bytes, segment] = numbers[..] else { panic!("{range}") };
        assert_eq!((segment, first % 512, bytes % 512), (512, 0, 0), "{range}");
        let end = 0xFE00;
        let store = end - 512 * u32::from(lang::part::F5529.segments);
        assert!(first + bytes <= store || first >= end, "{range} is in the program area");
    }
    // The other chip's image is not for it.
    let (code, text) = desk.flash(&["--part", "g2553"]);
    assert!(code == Some(4) && text.contains("it is MSP430F5529"), "{text}");
    let desk = Desk::new(&[RF2500]);
    desk.says("0.25", (&rf2500("MSP430G2xx3", "25 53"), 0), WRITTEN);
    let (code, text) = desk.flash(&["--part", "f5529"]);
    assert!(code == Some(4) && text.contains("it is MSP430G2553"), "{text}");
    assert!(!desk.commands().contains("load"), "{}", desk.commands());
}

#[test]
fn a_chip_without_a_name_is_written_only_when_the_part_is_named() {
    let desk = Desk::new(&[RF2500]);
    desk.says("0.22", ("Initializing FET...\n", 0), WRITTEN);
    let (code, text) = desk.flash(&[]);
    assert!(code == Some(4) && text.contains("--part g2553"), "{text}");
    assert!(!desk.commands().contains("prog"), "{}", desk.commands());
    assert_eq!(desk.flash(&["--part", "g2553"]).0, Some(0));
}

#[test]
fn what_the_programmer_said_is_shown_with_the_remedy() {
    let library = "tilib: can't find libmsp430.so: libmsp430.so: cannot open shared object file: No \
                   such file or directory\n";
    let rights = "rf2500: can't claim interface: Operation not permitted\nrf2500: failed to open \
                  RF2500 device\n";
    let update = "MSP430_Initialize: HID_FET\nFET firmware update is required.\ntilib: device \
                  initialization failed\n";
    let none = "Using new (SLAC460L+) API\nMSP430_GetNumberOfUsbIfs\nNo unused FET found.\n";
    let cases = [
        (EZ_FET, library, 255, "sudo ldconfig"),
        (RF2500, rights, 255, "ATTRS{idProduct}==\"f432\", TAG+=\"uaccess\""),
        (EZ_FET, update, 255, "--allow-fw-update"),
        (EZ_FET, none, 0, "ATTRS{idVendor}==\"2047\", TAG+=\"uaccess\""),
    ];
    for (device, said, code, word) in cases {
        let desk = Desk::new(&[device]);
        let (code, text) = desk.says("0.25", (said, code), WRITTEN).flash(&[]);
        assert_eq!(code, Some(4), "{text}");
        assert!(text.contains(word), "{word}: {text}");
        let last = said.trim_end().lines().last().expect("a line");
        assert!(text.contains(last) && !text.contains("Copyright"), "{text}");
        assert!(!desk.commands().contains("prog"), "{}", desk.commands());
    }
    // The same while it writes.
    let desk = Desk::new(&[RF2500]);
    let failed =
        ("Erasing...\nfet: FET returned error code 7 (Could not write device memory)\n", 255);
    desk.says("0.25", (&rf2500("MSP430G2xx3", "25 53"), 0), failed);
    let (code, text) = desk.flash(&[]);
    assert!(code == Some(4) && text.contains("error code 7") && text.contains("reset"), "{text}");
}

#[test]
fn an_old_mspdebug_is_refused_where_it_would_write_nothing() {
    let desk = Desk::new(&[EZ_FET]);
    let (code, text) = desk.says("0.22", (TILIB, 0), WRITTEN).flash(&[]);
    assert!(code == Some(4) && text.contains("mspdebug 0.22 is too old"), "{text}");
    assert_eq!(desk.commands().lines().count(), 1, "{}", desk.commands());
}

#[test]
fn what_is_plugged_in_is_told_when_it_cannot_be_written() {
    let cases: [(&[(&str, &str)], &str); 3] = [
        (&[], "no LaunchPad is plugged in"),
        // It is told in the sysfs of this test only.
        (&[EZ_FET, BOOT_LOADER], "hold its BSL button"),
        (&[RF2500, EZ_FET], "LaunchPad LP0, LaunchPad with eZ-FET LP1"),
    ];
    for (devices, word) in cases {
        let desk = Desk::new(devices);
        let (code, text) = desk.says("0.25", (TILIB, 0), WRITTEN).flash(&[]);
        assert!(code == Some(4) && text.contains(word), "{word}: {text}");
        assert_eq!(desk.commands(), "");
    }
}

#[test]
fn saved_files_hold_the_image_as_mspdebug_reads_it() {
    let desk = Desk::new(&[]);
    let path = |name: &str| desk.folder.path().join(name).display().to_string();
    for part in ["g2553", "g2553-handlers"] {
        let shipped = format!("../firmware/image/pasapas-{part}.elf");
        for name in ["a.hex", "a.txt", "a.elf"] {
            assert_eq!(desk.flash(&["--part", part, "--save", name]).0, Some(0), "{name}");
            // The simulator of mspdebug, with nothing but this file in its memory.
            let verified = Command::new("mspdebug")
                .args(["-q", "sim", &format!("prog {}", path(name))])
                .arg(format!("verify {shipped}"))
                .output();
            let Ok(verified) = verified else {
                eprintln!("mspdebug does not run here: its part of the test is left out");
                continue;
            };
            let said = String::from_utf8_lossy(&[&verified.stdout[..], &verified.stderr].concat())
                .into_owned();
            assert!(verified.status.success(), "{part} {name}: {said}");
            let totals = said.matches("bytes total").count();
            assert_eq!(totals, 2, "{part} {name}: {said}");
        }
    }
    let (code, text) = desk.flash(&["--save", "a.bin"]);
    assert!(code == Some(2) && text.contains(".hex (Intel HEX)"), "{text}");
}

/// A tool that loads segments must not write the linker's headers over the peripherals.
#[test]
fn a_saved_elf_has_no_segment_at_address_0() {
    use object::read::elf::{ElfFile32, ProgramHeader as _};
    let desk = Desk::new(&[]);
    assert_eq!(desk.flash(&["--save", "a.elf"]).0, Some(0));
    let bytes = fs::read(desk.folder.path().join("a.elf")).expect("the file");
    let file = ElfFile32::<object::Endianness>::parse(&*bytes).expect("ELF");
    let endian = file.endian();
    let loads: Vec<u32> = file
        .elf_program_headers()
        .iter()
        .filter(|segment| segment.p_type(endian) == object::elf::PT_LOAD)
        .map(|segment| segment.p_paddr(endian))
        .collect();
    assert!(loads.len() >= 4 && loads.iter().all(|start| *start >= 0xC000), "{loads:x?}");
}
