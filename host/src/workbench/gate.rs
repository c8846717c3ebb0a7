//! Access control of a server that moves machines.
//!
//! A port on this machine's loopback alone protects nothing: any page in any browser can reach it, by
//! its own name for that address too. So every request must name one of our hosts, a socket must come
//! from one of our own pages, and its first message must prove that it knows the secret of this start.

use std::net::{IpAddr, SocketAddr};

/// Bytes of a start's secret and of a challenge.
const RANDOM: usize = 16;
/// Block of SHA-1 (RFC 2104, 2).
const BLOCK: usize = 64;

/// The rules of one start.
#[derive(Clone, Debug)]
pub struct Gate {
    port: u16,
    /// Addresses of the network count too.
    network: bool,
    /// Names that a proxy may ask by.
    names: Vec<String>,
    secret: String,
}

/// Random bytes as hexadecimal digits.
///
/// # Errors
/// The system gives none.
pub fn random() -> Result<String, String> {
    let mut bytes = [0; RANDOM];
    getrandom::fill(&mut bytes).map_err(|error| format!("no random numbers: {error}"))?;
    Ok(hex(&bytes))
}

/// A password that a person can type: 50 bits in two groups, without signs that look alike.
///
/// # Errors
/// The system gives no random numbers.
pub fn password() -> Result<String, String> {
    const SIGNS: &[u8; 32] = b"abcdefghijkmnpqrstuvwxyz23456789";
    let mut bytes = [0; 10];
    getrandom::fill(&mut bytes).map_err(|error| format!("no random numbers: {error}"))?;
    let sign = |byte: &u8| char::from(SIGNS[usize::from(byte % 32)]);
    let signs: String = bytes.iter().map(sign).collect();
    Ok(format!("{}-{}", &signs[..5], &signs[5..]))
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

fn sha1(parts: &[&[u8]]) -> [u8; 20] {
    let mut sha = sha1_smol::Sha1::new();
    parts.iter().for_each(|part| sha.update(part));
    sha.digest().bytes()
}

/// HMAC-SHA1 (RFC 2104) as hexadecimal digits: what a page answers to a challenge, so that the secret
/// itself never goes over the line.
pub fn proof(secret: &str, challenge: &str) -> String {
    let mut key = [0; BLOCK];
    if secret.len() > BLOCK {
        key[..20].copy_from_slice(&sha1(&[secret.as_bytes()]));
    } else {
        key[..secret.len()].copy_from_slice(secret.as_bytes());
    }
    let inner = sha1(&[&key.map(|byte| byte ^ 0x36), challenge.as_bytes()]);
    hex(&sha1(&[&key.map(|byte| byte ^ 0x5C), &inner]))
}

impl Gate {
    /// The rules for a server at `address`, with the names that `--allowed-host` adds.
    pub fn new(address: SocketAddr, names: Vec<String>, secret: String) -> Gate {
        let network = !address.ip().is_loopback();
        Gate { port: address.port(), network, names, secret }
    }

    /// Whether a request may go on: its Host is ours, and its Origin, which a socket must have, is
    /// that host's page.
    pub fn may(&self, host: Option<&str>, origin: Option<&str>, socket: bool) -> bool {
        let Some(host) = host else { return false };
        if !self.is_ours(host) {
            return false;
        }
        match origin {
            None => !socket,
            Some(origin) => {
                let page = origin.strip_prefix("http://");
                // Behind a proxy with TLS the page has another scheme.
                let proxied = origin.strip_prefix("https://").filter(|own| self.is_named(own));
                page.or(proxied).is_some_and(|own| own.eq_ignore_ascii_case(host))
            }
        }
    }

    fn is_named(&self, host: &str) -> bool {
        self.names.iter().any(|name| name.eq_ignore_ascii_case(host))
    }

    /// A name that the attacker owns can lead to our address; a number cannot.
    fn is_ours(&self, host: &str) -> bool {
        if self.is_named(host) {
            return true;
        }
        let Some((name, port)) = host.rsplit_once(':') else { return false };
        if port != self.port.to_string() {
            return false;
        }
        let number = name.strip_prefix('[').and_then(|name| name.strip_suffix(']')).unwrap_or(name);
        match number.parse::<IpAddr>() {
            Ok(address) => self.network || address.is_loopback(),
            Err(_) => name.eq_ignore_ascii_case("localhost"),
        }
    }

    /// Whether an answer to a challenge proves that the secret is known; takes as long for every
    /// wrong one.
    pub fn knows(&self, challenge: &str, answer: &str) -> bool {
        let wanted = proof(&self.secret, challenge);
        let differ = wanted.bytes().zip(answer.bytes()).fold(0, |all, (a, b)| all | (a ^ b));
        wanted.len() == answer.len() && differ == 0
    }
}

#[cfg(test)]
mod tests {
    use super::{Gate, password, proof, random};

    fn gate(address: &str) -> Gate {
        let names = vec!["mill.shop".to_owned()];
        Gate::new(address.parse().expect("an address"), names, "key".to_owned())
    }

    #[test]
    fn the_proof_is_hmac_sha1() {
        // RFC 2202, test cases 2 and 6.
        let data = "what do ya want for nothing?";
        assert_eq!(proof("Jefe", data), "effcdf6ae5eb2fa2d27416d5f184df9c259a7c79");
        // The key of case 6 is 80 bytes of AA; as text the same path is taken by 80 bytes of `k`.
        assert_ne!(proof(&"k".repeat(80), data), proof(&"k".repeat(81), data));
    }

    #[test]
    fn only_our_own_pages_open_sockets() {
        let gate = gate("127.0.0.1:8000");
        for (host, origin, socket, may) in [
            (Some("127.0.0.1:8000"), None, false, true),
            (Some("localhost:8000"), Some("http://localhost:8000"), true, true),
            (Some("[::1]:8000"), Some("http://[::1]:8000"), true, true),
            (Some("mill.shop"), Some("https://mill.shop"), true, true),
            (None, None, false, false),
            (Some("127.0.0.1"), None, false, false),
            (Some("127.0.0.1:8001"), None, false, false),
            (Some("192.168.1.7:8000"), None, false, false),
            (Some("evil.example:8000"), Some("http://evil.example:8000"), true, false),
            (Some("127.0.0.1:8000"), None, true, false),
            (Some("127.0.0.1:8000"), Some("http://evil.example"), true, false),
            (Some("127.0.0.1:8000"), Some("http://localhost:8000"), true, false),
            (Some("127.0.0.1:8000"), Some("https://127.0.0.1:8000"), true, false),
            (Some("127.0.0.1:8000"), Some("null"), true, false),
            (Some("127.0.0.1:8000"), Some("http://evil.example"), false, false),
        ] {
            assert_eq!(gate.may(host, origin, socket), may, "{host:?} {origin:?} {socket}");
        }
    }

    #[test]
    fn a_server_for_the_network_goes_by_numbers() {
        let gate = gate("0.0.0.0:80");
        assert!(gate.may(Some("192.168.1.7:80"), Some("http://192.168.1.7:80"), true));
        assert!(!gate.may(Some("evil.example:80"), Some("http://evil.example:80"), true));
    }

    #[test]
    fn an_answer_fits_its_challenge_alone() {
        let gate = gate("127.0.0.1:1");
        assert!(gate.knows("c", &proof("key", "c")));
        for wrong in [proof("key", "d"), proof("kex", "c"), String::new(), "0".repeat(41)] {
            assert!(!gate.knows("c", &wrong));
        }
        assert_ne!(random(), random());
        assert_eq!(password().expect("random").len(), 11);
    }
}
