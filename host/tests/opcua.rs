//! The gateway's OPC UA server before asyncua, a client that is not ours.

#![cfg(unix)]

mod common;

use std::path::Path;
use std::process::Command;

use common::{Board, Gateway, has, pasapas, text};

/// Browses, reads by name, subscribes, calls methods.
const CLIENT: &str = r#"
import asyncio, random, sys
from pathlib import Path
from asyncua import Client, ua
from asyncua.crypto.cert_gen import setup_self_signed_certificate
from asyncua.crypto.security_policies import SecurityPolicyBasic256Sha256
from cryptography.x509.oid import ExtendedKeyUsageOID

class Changes:
    def __init__(self):
        self.seen = []
    def datachange_notification(self, node, value, data):
        self.seen.append(value)

async def until(what, text):
    for _ in range(200):
        if await what():
            return
        await asyncio.sleep(0.1)
    raise AssertionError(text)

async def main():
    async with Client(sys.argv[1]) as client:
        n = await client.get_namespace_index("urn:pasapas:gateway")
        objects = client.nodes.objects
        names = [(await child.read_browse_name()).Name for child in await objects.get_children()]
        assert {"drill", "gone"} <= set(names), names
        drill = await objects.get_child(f"{n}:drill")
        async def value(path, board=drill):
            node = await board.get_child([f"{n}:{part}" for part in path.split("/")])
            data = await node.read_data_value(raise_on_bad_status=False)
            return data.Value.Value if data.StatusCode.is_good() else None
        async def is_ready():
            return await value("State") == "ready"
        await until(is_ready, "no state")
        assert await value("Online") is True and await value("Firmware") == "0.1"
        gone = await objects.get_child(f"{n}:gone")
        async def is_gone():
            return await value("Online", gone) is False
        await until(is_gone, "it does not answer")
        assert await value("State", gone) is None
        folder = await drill.get_child(f"{n}:Variables")
        async def has_variables():
            return len(await folder.get_children()) == 5
        await until(has_variables, "the program's variables")
        made = await folder.get_child(f"{n}:made")
        assert (await made.read_data_type_as_variant_type()) == ua.VariantType.Int32
        depth = await folder.get_child(f"{n}:depth")
        assert (await depth.read_data_type_as_variant_type()) == ua.VariantType.Double
        assert (await depth.read_description()).Text == "AT variable mm"
        changes = Changes()
        subscription = await client.create_subscription(100, changes)
        await subscription.subscribe_data_change(await drill.get_child(f"{n}:Runs"))
        await drill.call_method(f"{n}:Start")
        async def is_made():
            return await value("Variables/made") == 1 and await value("Runs") == 1
        await until(is_made, "it does not run")
        async def is_deep():
            return await value("Variables/depth") == 1.5 and await value("Variables/list[2]") == 7
        await until(is_deep, "variables of the script by name")
        assert await value("State") == "running" and await value("Outputs") == 2
        await drill.call_method(f"{n}:Stop")
        await until(is_ready, "it does not stop")
        assert await value("LastEnd") == "stopped" and 1 in changes.seen, changes.seen
        for call in (made.write_value(ua.Variant(5, ua.VariantType.Int32)), gone.call_method(f"{n}:Start")):
            try:
                await call
            except ua.UaStatusCodeError:
                continue
            raise AssertionError("it was allowed")

async def denied():
    async with Client(sys.argv[1]) as client:
        n = await client.get_namespace_index("urn:pasapas:gateway")
        drill = await client.nodes.objects.get_child(f"{n}:drill")
        try:
            await drill.call_method(f"{n}:Start")
        except ua.uaerrors.BadUserAccessDenied:
            return
        raise AssertionError("it was allowed")

async def secret():
    async def enter(password, policy):
        client = Client(sys.argv[1])
        if policy:
            folder = sys.argv[3]
            await setup_self_signed_certificate(
                Path(folder, "key.pem"), Path(folder, "cert.der"), "urn:test", "localhost",
                [ExtendedKeyUsageOID.CLIENT_AUTH], {"commonName": "test"})
            client.application_uri = "urn:test"
            await client.set_security(
                SecurityPolicyBasic256Sha256, str(Path(folder, "cert.der")), str(Path(folder, "key.pem")),
                mode=ua.MessageSecurityMode.SignAndEncrypt)
        if password:
            client.set_user("hall")
            client.set_password(password)
        async with client:
            n = await client.get_namespace_index("urn:pasapas:gateway")
            drill = await client.nodes.objects.get_child(f"{n}:drill")
            return await (await drill.get_child(f"{n}:Online")).read_value()
    # What speaks something else, or nothing, harms nobody.
    host, port = sys.argv[1].removeprefix("opc.tcp://").rstrip("/").split(":")
    others = []
    for i in range(300):
        reader, writer = await asyncio.open_connection(host, int(port))
        writer.write([b"", b"HELF\xff\xff\xff\x7f", b"GET / HTTP/1.1\r\n\r\n", random.randbytes(400)][i % 4])
        others.append(writer)
    for password, policy in ((None, False), ("secret", False), ("wrong", True), (None, True)):
        try:
            await enter(password, policy)
        except Exception as error:
            print(password, policy, repr(error)[:100])
            continue
        raise AssertionError(f"{password} {policy} was allowed")
    for _ in range(100):
        if await enter("secret", True):
            return
        await asyncio.sleep(0.1)
    raise AssertionError("the board is not shown")

asyncio.run({"all": main, "denied": denied, "secret": secret}[sys.argv[2]]())
"#;

fn run(gateway: &mut Gateway, what: &str, folder: &Path) {
    let place = gateway.next_line();
    let place = if place["opcua"].is_null() { gateway.next_line() } else { place };
    let url = place["opcua"].as_str().expect("its address").to_owned();
    let output = Command::new("python3")
        .args(["-c", CLIENT, &url, what, text(folder)])
        .output()
        .expect("python");
    let said = [output.stdout, output.stderr].concat();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&said));
}

#[test]
fn asyncua_browses_reads_by_name_subscribes_and_calls() {
    if !has("python3", &["-c", "import asyncua"]) {
        return;
    }
    let board = Board::start(&["--part", "f5529"]);
    let (folder, port) = (board.folder.path(), board.port());
    let file = folder.join("opcua.toml");
    let content = |more: &str| {
        format!(
            "[modbus]\nlisten = \"127.0.0.1:0\"\n[[board]]\nname = \"drill\"\nport = {port:?}\n\
             [[board]]\nname = \"gone\"\nport = {port:?}\naddress = 9\n\
             [[client]]\nfrom = \"any\"\nwrite = [\"all\"]\n\
             [opcua]\nlisten = \"127.0.0.1:0\"\npki = {pki:?}\n{more}\n",
            port = text(&port),
            pki = text(&folder.join("pki")),
        )
    };
    std::fs::write(&file, content("write = [\"RUN_CONTROL\"]")).expect("a file");
    let mut gateway = Gateway::start(&[text(&file)]);
    let script = folder.join("made.bas");
    let program = "DIM depth AS LENGTH AT 3000\nDIM list(3) AT 3010\nKEEP made\nmade = made + 1\n\
                   depth = 1.5mm\nlist(2) = 7\nSetOut 2, ON\nWait 60s\n";
    std::fs::write(&script, program).expect("a script");
    let over = format!("tcp:127.0.0.1:{}", gateway.port);
    let (code, said) = pasapas(&["upload", text(&script), "--port", &over]);
    assert_eq!(code, 0, "{said}");
    run(&mut gateway, "all", folder);
    drop(gateway);
    // Whoever may read may not command; the key is for nobody else.
    std::fs::write(&file, content("")).expect("a file");
    run(&mut Gateway::start(&[text(&file)]), "denied", folder);
    let private = std::fs::metadata(folder.join("pki/private")).expect("its folder");
    assert_eq!(std::os::unix::fs::PermissionsExt::mode(&private.permissions()) & 0o77, 0);
    // With a password everything is signed and encrypted.
    let password = folder.join("password");
    std::fs::write(&password, "secret\n").expect("a file");
    let user = format!("user = \"hall\"\npassword_file = {:?}", text(&password));
    std::fs::write(&file, content(&user)).expect("a file");
    run(&mut Gateway::start(&[text(&file)]), "secret", folder);
}
