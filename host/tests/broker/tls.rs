//! Certificates and passwords, good ones and bad ones.

use std::path::Path;
use std::process::Command;
use std::time::Duration;

use super::common::{Board, Gateway, pasapas, text};
use super::{Ear, broker, free_port, gateway, gateway_file, mosquitto};

/// Runs a program of the system that must succeed.
fn run(folder: &Path, program: &str, args: &str) {
    let output = Command::new(program).args(args.split(' ')).current_dir(folder).output();
    let output = output.expect("it starts");
    assert!(
        output.status.success(),
        "{program} {args}: {}",
        String::from_utf8_lossy(&output.stderr)
    );
}

#[test]
fn tls_and_passwords_are_kept_to() {
    let Some(program) = mosquitto() else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let place = folder.path();
    for name in ["ca", "other"] {
        run(
            place,
            "openssl",
            &format!(
                "req -x509 -newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes -days 2 -subj /CN={name} \
                 -keyout {name}.key -out {name}.pem"
            ),
        );
    }
    // A good one, one of another host, one that is over, and one for the gateway.
    for (name, host, days) in [
        ("server", "DNS:localhost,IP:127.0.0.1", 2),
        ("far", "DNS:elsewhere", 2),
        ("old", "DNS:localhost", 0),
        ("own", "DNS:hall", 2),
    ] {
        std::fs::write(place.join("ext"), format!("subjectAltName={host}\n")).expect("a file");
        let request = format!(
            "req -newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes -subj /CN=localhost -keyout {name}.key \
             -out {name}.csr"
        );
        run(place, "openssl", &request);
        let sign = format!(
            "x509 -req -in {name}.csr -CA ca.pem -CAkey ca.key -CAcreateserial -days {days} -extfile ext \
             -out {name}.pem"
        );
        run(place, "openssl", &sign);
    }
    run(place, "mosquitto_passwd", "-c -b users hall secret");
    std::fs::write(place.join("password"), "secret\n").expect("a file");
    std::fs::write(place.join("wrong"), "sekret\n").expect("a file");
    let [plain, port, far, old, strict] = [0; 5].map(|_| free_port());
    let path = |name: &str| place.join(name).display().to_string();
    let mut more = format!("per_listener_settings false\npassword_file {}\n", path("users"));
    for (port, name) in [(port, "server"), (far, "far"), (old, "old"), (strict, "server")] {
        more += &format!(
            "listener {port} 127.0.0.1\nrequire_certificate {}\ncafile {}\ncertfile {}\nkeyfile {}\n",
            port == strict,
            path("ca.pem"),
            path(&format!("{name}.pem")),
            path(&format!("{name}.key"))
        );
    }
    let more = more + "allow_anonymous false\n";
    let _broker = broker(&program, place, plain, &more);
    let board = Board::start(&[]);
    let user = ["--cafile", &path("ca.pem"), "-u", "hall", "-P", "secret"];
    let ear = Ear::new(port, "pasapas/#", &user);
    let setting = |name: &str, port: u16, ca: &str, password: &str| {
        format!(
            "broker = \"localhost:{port}\"\nname = \"{name}\"\nuser = \"hall\"\nca_file = {:?}\n\
             password_file = {:?}",
            place.join(ca),
            place.join(password)
        )
    };
    // Those that must not come in, whose Modbus goes on all the same; then one that must.
    for setting in [
        setting("foreign", port, "other.pem", "password"),
        setting("thief", port, "ca.pem", "wrong"),
        setting("astray", far, "ca.pem", "password"),
        setting("late", old, "ca.pem", "password"),
        setting("nobody", strict, "ca.pem", "password"),
    ] {
        let gateway = Gateway::start(&[text(&gateway_file(&board, &folder, &setting))]);
        let before = gateway.memory();
        std::thread::sleep(Duration::from_secs(1));
        let (code, said) = pasapas(&["status", "--port", &format!("tcp:{}", gateway.port)]);
        assert_eq!(code, 0, "{said}");
        let grown = gateway.memory().saturating_sub(before);
        assert!(grown < 8 << 10, "{grown} KB more");
    }
    let good = gateway(&board, &folder, &setting("good", port, "ca.pem", "password"));
    let (topic, _) =
        ear.wait("online", |topic, text| topic.ends_with("/status") && text == "online");
    assert_eq!(topic, "pasapas/good/status");
    drop(good);
    // A broker that wants to see ours.
    let known = format!(
        "{}\ncertificate = {:?}\nkey = {:?}",
        setting("known", strict, "ca.pem", "password"),
        place.join("own.pem"),
        place.join("own.key")
    );
    let _known = gateway(&board, &folder, &known);
    ear.wait("known", |topic, text| topic == "pasapas/known/status" && text == "online");
}
