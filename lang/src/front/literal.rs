//! Numbers with their units: the one place where a literal's kind and value are settled.

use super::codes::Code;
use super::words::{self, Reserved};
use crate::kind::Kind;

/// An exact decimal fraction: `mantissa / 10^scale`.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct Decimal {
    mantissa: i128,
    scale: u32,
}

/// Digits before the point that matter: no stored unit leaves more than ten within 32 bits.
const WHOLE_DIGITS: usize = 12;
/// Decimals kept exactly; what follows only says on which side of a tie the number lies.
const DECIMALS: usize = 18;

impl Decimal {
    /// Zero.
    pub const ZERO: Self = Self { mantissa: 0, scale: 0 };

    /// Reads `[+-]digits[.digits]` or `[+-].digits`. None where that is not its form, or where it
    /// has more than 12 digits before the point.
    pub fn parse(text: &str) -> Option<Self> {
        let (negative, digits) = match text.as_bytes().first()? {
            b'-' => (true, &text[1..]),
            b'+' => (false, &text[1..]),
            _ => (false, text),
        };
        let (whole, fraction) = digits.split_once('.').unwrap_or((digits, ""));
        let all_digits = |s: &str| s.bytes().all(|b| b.is_ascii_digit());
        if whole.len() + fraction.len() == 0 || !all_digits(whole) || !all_digits(fraction) {
            return None;
        }
        let whole = whole.trim_start_matches('0');
        if whole.len() > WHOLE_DIGITS {
            return None;
        }
        let fraction = fraction.trim_end_matches('0');
        let (kept, rest) = fraction.split_at(fraction.len().min(DECIMALS));
        let sticky = if rest.is_empty() { "" } else { "1" };
        let digits = [whole, kept, sticky].concat();
        let magnitude = if digits.is_empty() { 0 } else { digits.parse::<i128>().ok()? };
        let scale = (kept.len() + sticky.len()) as u32;
        Some(Self { mantissa: if negative { -magnitude } else { magnitude }, scale })
    }

    /// The value times `num / den` rounded half away from zero, and whether that was exact.
    /// None beyond 64 bits. `num` and `den` are positive.
    pub fn scaled(self, num: u32, den: u32) -> Option<(i64, bool)> {
        let divisor = 10i128.checked_pow(self.scale)?.checked_mul(i128::from(den))?;
        let product = self.mantissa.checked_mul(i128::from(num))?;
        let (quotient, remainder) = (product / divisor, product % divisor);
        let away = i128::from(remainder.abs() >= divisor - remainder.abs());
        let rounded = if remainder == 0 { quotient } else { quotient + away * product.signum() };
        Some((i64::try_from(rounded).ok()?, remainder == 0))
    }

    /// The value times `num / den`, for a positive value the whole number below it.
    fn floor(self, num: u32, den: u32) -> Option<i64> {
        let divisor = 10i128.checked_pow(self.scale)?.checked_mul(i128::from(den))?;
        i64::try_from(self.mantissa.checked_mul(i128::from(num))? / divisor).ok()
    }

    /// The value in units of `1/n` where that is exact: `tenths(38.2) = 382` with `n` = 10.
    pub fn exact(self, n: u32) -> Option<i64> {
        self.scaled(n, 1).and_then(|(value, exact)| exact.then_some(value))
    }

    /// -1, 0 or 1.
    pub fn sign(self) -> i32 {
        self.mantissa.signum() as i32
    }
}

impl core::fmt::Debug for Decimal {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{}e-{}", self.mantissa, self.scale)
    }
}

/// A unit of the language.
struct Unit {
    text: &'static str,
    kind: Kind,
    num: u32,
    den: u32,
    exact: bool,
}

const fn unit(text: &'static str, kind: Kind, num: u32, den: u32, exact: bool) -> Unit {
    Unit { text, kind, num, den, exact }
}

/// Units with the ratio to the stored unit, and whether a value must be exact. Longer ones stand
/// before those that they begin with. 1 in = 25 400 um.
const UNITS: [Unit; 17] = [
    unit("mm/min", Kind::Speed, 1000, 60, false),
    unit("mm/s2", Kind::Accel, 1000, 1, false),
    unit("mm/s", Kind::Speed, 1000, 1, false),
    unit("mm", Kind::Length, 1000, 1, true),
    unit("um", Kind::Length, 1, 1, true),
    unit("in/min", Kind::Speed, 25_400, 60, false),
    unit("in", Kind::Length, 25_400, 1, false),
    unit("st/s2", Kind::StepAccel, 1, 1, false),
    unit("st/s", Kind::StepRate, 1, 1, false),
    unit("st", Kind::Steps, 1, 1, true),
    unit("ms", Kind::Time, 1, 1, true),
    unit("min", Kind::Time, 60_000, 1, true),
    unit("s", Kind::Time, 1000, 1, true),
    unit("deg", Kind::Angle, 1000, 1, true),
    unit("mdeg", Kind::Angle, 1, 1, true),
    unit("mV", Kind::Voltage, 1, 1, true),
    unit("V", Kind::Voltage, 1000, 1, true),
];

/// A unit of ours, and the ratio by which a number in another becomes one in it.
type Ratio = (&'static str, u32, u32);

/// Spellings of units that are not ours, what they are, and the unit to write with its ratio.
const FOREIGN_UNITS: [(&str, &str, Option<Ratio>); 23] = [
    ("sec", "seconds are written `s`", Some(("s", 1, 1))),
    ("secs", "seconds are written `s`", Some(("s", 1, 1))),
    ("second", "seconds are written `s`", Some(("s", 1, 1))),
    ("seconds", "seconds are written `s`", Some(("s", 1, 1))),
    ("msec", "milliseconds are written `ms`", Some(("ms", 1, 1))),
    ("us", "Times are whole milliseconds: `1ms` is the least", None),
    ("mins", "minutes are written `min`", Some(("min", 1, 1))),
    ("minutes", "minutes are written `min`", Some(("min", 1, 1))),
    ("h", "hours are written in minutes", Some(("min", 60, 1))),
    ("hour", "hours are written in minutes", Some(("min", 60, 1))),
    ("hours", "hours are written in minutes", Some(("min", 60, 1))),
    ("cm", "centimetres are written in mm", Some(("mm", 10, 1))),
    ("dm", "decimetres are written in mm", Some(("mm", 100, 1))),
    ("m", "metres are written in mm", Some(("mm", 1000, 1))),
    ("km", "kilometres are written in mm", Some(("mm", 1_000_000, 1))),
    ("inch", "inches are written `in`", Some(("in", 1, 1))),
    ("inches", "inches are written `in`", Some(("in", 1, 1))),
    ("mil", "thousandths of an inch are written `in`", Some(("in", 1, 1000))),
    ("step", "steps are written `st`", Some(("st", 1, 1))),
    ("steps", "steps are written `st`", Some(("st", 1, 1))),
    ("hz", "step rates are written `st/s`", Some(("st/s", 1, 1))),
    ("khz", "step rates are written `st/s`", Some(("st/s", 1000, 1))),
    ("e", "there are no exponents: write all digits", None),
];

/// A number times `num / den` with another unit, where that is exact to three decimals.
fn converted(digits: &str, (unit, num, den): Ratio) -> Option<String> {
    let thousandths = match Decimal::parse(&digits.replace('_', ""))?.scaled(num * 1000, den)? {
        (value, true) => value,
        (_, false) => return None,
    };
    let decimals = format!("{:03}", thousandths % 1000);
    let whole = thousandths / 1000;
    Some(match decimals.trim_end_matches('0') {
        "" => format!("{whole}{unit}"),
        decimals => format!("{whole}.{decimals}{unit}"),
    })
}

/// Length of the longest unit that `rest` begins with and that no name character follows.
pub fn unit_length(rest: &str) -> Option<usize> {
    let fits = |u: &&Unit| {
        let n = u.text.len();
        rest.as_bytes().get(..n).is_some_and(|s| s.eq_ignore_ascii_case(u.text.as_bytes()))
            && !rest.as_bytes().get(n).is_some_and(|&b| is_name_byte(b))
    };
    UNITS.iter().find(fits).map(|u| u.text.len())
}

/// A number as the lexer cut it out, in the formatter's style: its unit as the table has it, all else in small letters.
pub fn spelled(text: &str) -> String {
    let plain = |b: u8| b.is_ascii_digit() || b == b'_' || b == b'.';
    let end = text.bytes().position(|b| !plain(b)).unwrap_or(text.len());
    let (digits, suffix) = text.split_at(end);
    match UNITS.iter().find(|unit| unit.text.eq_ignore_ascii_case(suffix)) {
        Some(unit) => format!("{digits}{}", unit.text),
        None => text.to_ascii_lowercase(),
    }
}

/// Length of the unit of a PRINT that `rest` begins with and that no name character follows.
pub fn shown_length(rest: &str) -> Option<usize> {
    let fits = |unit: &str| {
        rest.get(..unit.len()).is_some_and(|text| text.eq_ignore_ascii_case(unit))
            && !rest.as_bytes().get(unit.len()).is_some_and(|&b| is_name_byte(b) || b == b'/')
    };
    let units = crate::effect::Unit::ALL.map(crate::effect::Unit::suffix);
    units.into_iter().find(|unit| fits(unit)).map(str::len)
}

/// Whether a byte may stand inside a name.
pub fn is_name_byte(b: u8) -> bool {
    b.is_ascii_alphanumeric() || b == b'_'
}

/// Whether the word is one of the units.
pub fn is_unit(word: &str) -> bool {
    UNITS.iter().any(|u| u.text.eq_ignore_ascii_case(word))
}

/// A literal of a kind, for hints: "write `5ms`".
pub const fn example(kind: Kind) -> &'static str {
    match kind {
        Kind::Number => "5",
        Kind::Truth => "ON",
        Kind::Length => "5mm",
        Kind::Steps => "500st",
        Kind::Time => "500ms",
        Kind::Speed => "25mm/s",
        Kind::StepRate => "2000st/s",
        Kind::Accel => "250mm/s2",
        Kind::StepAccel => "25000st/s2",
        Kind::Angle => "90deg",
        Kind::Voltage => "1.2V",
    }
}

/// A literal's kind and value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Literal {
    /// From its unit; Number without.
    pub kind: Kind,
    /// In the stored unit: at most 2^31, which only a minus makes fit. Of a bit pattern the signed
    /// value of its 32 bits.
    pub value: i64,
}

/// Why a literal is wrong.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LiteralError {
    /// Which diagnostic.
    pub code: Code,
    /// In words.
    pub message: String,
    /// What to write.
    pub hint: Option<String>,
    /// The literal that was meant, where that is clear.
    pub instead: Option<String>,
}

fn wrong(code: Code, message: String, hint: impl Into<Option<String>>) -> LiteralError {
    LiteralError { code, message, hint: hint.into(), instead: None }
}

/// The greatest magnitude of a literal, 2^31.
const MAX_MAGNITUDE: i64 = 1 << 31;

/// Settles kind and value of a literal without sign, as the lexer cut it out: `42`, `&H1F`,
/// `1_000`, `.5mm`, or digits with letters that are no unit.
pub fn settle(text: &str) -> Result<Literal, LiteralError> {
    if let Some(digits) = text.strip_prefix('&') {
        return pattern(text, digits);
    }
    let end = text
        .bytes()
        .position(|b| !(b.is_ascii_digit() || b == b'_' || b == b'.'))
        .unwrap_or(text.len());
    let (digits, suffix) = text.split_at(end);
    let unit = if suffix.is_empty() {
        None
    } else {
        let known = UNITS.iter().find(|u| u.text.eq_ignore_ascii_case(suffix));
        Some(known.ok_or_else(|| bad_suffix(text, digits, suffix))?)
    };
    let misplaced = digits.starts_with('_')
        || digits.ends_with('_')
        || digits.contains("__")
        || digits.contains("_.")
        || digits.contains("._");
    let plain = digits.replace('_', "");
    if misplaced || plain.bytes().filter(|&b| b == b'.').count() > 1 {
        let message = format!("`{digits}` is not a number");
        return Err(wrong(
            Code::BadNumber,
            message,
            "`_` stands between digits: `1_000`".to_owned(),
        ));
    }
    let range = || {
        let message = format!("`{text}` does not fit in 32 bits");
        let least_unit = unit.map_or("", |u| u.kind.unit().suffix());
        wrong(Code::NumberRange, message, format!("the greatest value is 2147483647{least_unit}"))
    };
    let Some(unit) = unit else {
        if plain.contains('.') {
            let hint =
                format!("write a unit, as in `{digits}mm` or `{digits}s`, or a whole number");
            let message = format!("`{digits}` has decimals but no unit");
            return Err(wrong(Code::DecimalWithoutUnit, message, hint));
        }
        let value = plain.trim_start_matches('0');
        let value = if value.is_empty() { 0 } else { value.parse().map_err(|_| range())? };
        if value > MAX_MAGNITUDE {
            return Err(range());
        }
        return Ok(Literal { kind: Kind::Number, value });
    };
    let decimal = Decimal::parse(&plain).ok_or_else(range)?;
    let (mut value, exact) = decimal.scaled(unit.num, unit.den).ok_or_else(range)?;
    if unit.exact && !exact {
        let name = match unit.kind {
            Kind::Time => "milliseconds",
            Kind::Steps => "steps",
            _ => "micrometres",
        };
        let message = format!("`{text}` is not a whole number of {name}");
        let least = decimal.floor(unit.num, unit.den).unwrap_or(value);
        let next = least + 1;
        let stored = unit.kind.unit().suffix();
        let hint = format!("the nearest are `{least}{stored}` and `{next}{stored}`");
        let hint = if least == 0 { format!("the least is `1{stored}`") } else { hint };
        return Err(wrong(Code::InexactNumber, message, hint));
    }
    if value == 0 && decimal.sign() != 0 {
        value = 1;
    }
    if value > MAX_MAGNITUDE {
        return Err(range());
    }
    Ok(Literal { kind: unit.kind, value })
}

/// `&H1F`, `&B1010`.
fn pattern(text: &str, digits: &str) -> Result<Literal, LiteralError> {
    let radix = if digits.starts_with(['h', 'H']) { 16 } else { 2 };
    let plain = digits.get(1..).unwrap_or("").replace('_', "");
    let plain = plain.trim_start_matches('0');
    let bits = if plain.is_empty() { Ok(0) } else { u32::from_str_radix(plain, radix) };
    match bits {
        Ok(bits) if digits.len() > 1 && !digits.ends_with('_') => {
            Ok(Literal { kind: Kind::Number, value: i64::from(bits as i32) })
        }
        _ if plain.len() > 8 && plain.bytes().all(|b| char::from(b).is_digit(radix)) => {
            let hint = "the greatest patterns are `&HFFFFFFFF` and 32 binary digits".to_owned();
            Err(wrong(Code::NumberRange, format!("`{text}` has more than 32 bits"), hint))
        }
        _ => {
            let hint = "bit patterns are `&H1F` and `&B1010`, without unit".to_owned();
            Err(wrong(Code::BadNumber, format!("`{text}` is not a number"), hint))
        }
    }
}

/// Digits followed by letters that are no unit.
fn bad_suffix(text: &str, digits: &str, suffix: &str) -> LiteralError {
    let lower = suffix.to_ascii_lowercase();
    let radix = |prefix: char, to: &str, radix: u32| {
        let rest = lower.strip_prefix(prefix).filter(|_| digits == "0")?;
        let fits = !rest.is_empty() && rest.chars().all(|c| c.is_digit(radix));
        fits.then(|| format!("write `{to}{}`", rest.to_ascii_uppercase()))
    };
    if let Some(hint) = radix('x', "&H", 16).or_else(|| radix('b', "&B", 2)) {
        return wrong(Code::BadNumber, format!("`{text}` is not a number here"), hint);
    }
    let exponent = lower.strip_prefix('e').is_some_and(|r| r.bytes().all(|b| b.is_ascii_digit()));
    let spelling = if exponent { "e" } else { lower.as_str() };
    let (hint, instead) = match FOREIGN_UNITS.iter().find(|(known, ..)| *known == spelling) {
        Some((_, about, ours)) => {
            let instead = ours.and_then(|ours| converted(digits, ours));
            let hint = match &instead {
                Some(instead) => format!("{about}: `{instead}`"),
                None => (*about).to_owned(),
            };
            (hint, instead)
        }
        None => match words::lookup(suffix) {
            Some(Reserved::Kw(k)) => (format!("write a blank: `{digits} {}`", k.text()), None),
            _ => match words::nearest(suffix, UNITS.iter().map(|u| u.text)) {
                Some(near) => {
                    (format!("did you mean `{digits}{near}`?"), Some(format!("{digits}{near}")))
                }
                None => {
                    let units: Vec<_> = UNITS.iter().map(|u| u.text).collect();
                    (format!("units are {}", units.join(" ")), None)
                }
            },
        },
    };
    LiteralError { instead, ..wrong(Code::BadUnit, format!("`{suffix}` is not a unit"), hint) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn literals_settle() {
        for (text, kind, value) in [
            ("42", Kind::Number, 42),
            ("1_000", Kind::Number, 1000),
            ("2147483648", Kind::Number, 1 << 31),
            ("0000000000000000000007", Kind::Number, 7),
            ("&H1F", Kind::Number, 31),
            ("&hffff_ffff", Kind::Number, -1),
            ("&B1010", Kind::Number, 10),
            (".5mm", Kind::Length, 500),
            ("2.54MM", Kind::Length, 2540),
            ("0.1in", Kind::Length, 2540),
            ("0.00001in", Kind::Length, 1),
            ("350um", Kind::Length, 350),
            ("6600st", Kind::Steps, 6600),
            ("1.5s", Kind::Time, 1500),
            ("2min", Kind::Time, 120_000),
            ("0.0005min", Kind::Time, 30),
            ("1200mm/min", Kind::Speed, 20_000),
            ("1mm/min", Kind::Speed, 17),
            ("0.001mm/min", Kind::Speed, 1),
            ("25mm/s", Kind::Speed, 25_000),
            ("40in/min", Kind::Speed, 16_933),
            ("2000.5st/s", Kind::StepRate, 2001),
            ("250mm/s2", Kind::Accel, 250_000),
            ("25000st/s2", Kind::StepAccel, 25_000),
            ("1.2V", Kind::Voltage, 1_200),
            ("800mV", Kind::Voltage, 800),
            ("5.mm", Kind::Length, 5000),
        ] {
            assert_eq!(settle(text), Ok(Literal { kind, value }), "{text}");
        }
    }

    #[test]
    fn wrong_literals_say_why() {
        for (text, code) in [
            ("0.0001mm", Code::InexactNumber),
            ("1.5um", Code::InexactNumber),
            ("0.5st", Code::InexactNumber),
            ("0.1ms", Code::InexactNumber),
            ("1.5", Code::DecimalWithoutUnit),
            ("2147483649", Code::NumberRange),
            ("99999999999999999999999999999999999999999999", Code::NumberRange),
            ("3000000mm", Code::NumberRange),
            ("999999999999999999999999mm", Code::NumberRange),
            ("&H1FFFFFFFF", Code::NumberRange),
            ("&H", Code::BadNumber),
            ("0xFF", Code::BadNumber),
            ("1_", Code::BadNumber),
            ("1__0", Code::BadNumber),
            ("5foo", Code::BadUnit),
            ("1e5", Code::BadUnit),
        ] {
            assert_eq!(settle(text).map_err(|e| e.code), Err(code), "{text}");
        }
        assert_eq!(settle("0xff").unwrap_err().hint.as_deref(), Some("write `&HFF`"));
    }

    #[test]
    fn units_need_a_boundary() {
        assert_eq!(unit_length("mm/min"), Some(6));
        assert_eq!(unit_length("mm/minimum"), Some(2));
        assert_eq!(unit_length("mm/s2x"), Some(2));
        assert_eq!(unit_length("in(3)"), Some(2));
        assert_eq!(unit_length("stuff"), None);
    }

    proptest! {
        #[test]
        fn scaling_rounds_half_away(micro in -1_000_000_000i64..1_000_000_000, places in 0usize..7) {
            let scale = 10i64.pow(places as u32);
            let sign = if micro < 0 { "-" } else { "" };
            let (whole, part) = (micro.abs() / scale, micro.abs() % scale);
            let text = format!("{sign}{whole}.{part:0places$}");
            let text = if places == 0 { format!("{micro}") } else { text };
            let (rounded, exact) = Decimal::parse(&text).unwrap().scaled(1, 1).unwrap();
            let half = i64::from(2 * part >= scale && part != 0);
            prop_assert_eq!(rounded, micro.signum() * (whole + half));
            prop_assert_eq!(exact, part == 0);
        }

        #[test]
        fn any_text_settles_or_not(text in "\\PC*") {
            let _ = settle(&text);
            let _ = Decimal::parse(&text);
        }
    }
}
