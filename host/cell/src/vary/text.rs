//! A deviation as text: what a proof prints and `--deviate` reads.

use super::Deviation;

/// A number with its unit, in us where it is a time.
fn number(word: &str) -> Option<f64> {
    let number = match (word.strip_suffix("ms"), word.strip_suffix("st")) {
        (Some(ms), _) => ms.parse::<f64>().ok().map(|ms| ms * 1000.0),
        (None, Some(steps)) => steps.parse().ok(),
        (None, None) => word.parse().ok(),
    };
    number.filter(|number| number.is_finite())
}

/// A name as one word: in quotes where it has blanks or looks like something else.
fn quoted(name: &str) -> String {
    if name.contains(char::is_whitespace) || name == "at" || number(name).is_some() {
        format!("'{name}'")
    } else {
        name.to_owned()
    }
}

/// The words of a text, each with whether it stood in quotes.
fn words(text: &str) -> Result<Vec<(String, bool)>, String> {
    let mut words = Vec::new();
    let mut rest = text.trim_start();
    while !rest.is_empty() {
        let (word, after) = match rest.strip_prefix('\'') {
            Some(inside) => {
                let (word, after) = inside
                    .split_once('\'')
                    .ok_or_else(|| format!("\"{text}\": the quote before `{inside}` has no end"))?;
                words.push((word.to_owned(), true));
                (None, after)
            }
            None => {
                let end = rest.find(char::is_whitespace).unwrap_or(rest.len());
                (Some(&rest[..end]), &rest[end..])
            }
        };
        words.extend(word.map(|word| (word.to_owned(), false)));
        rest = after.trim_start();
    }
    Ok(words)
}

impl Deviation {
    /// `stuck tray.11 813ms`, `tray.at tray.3 0.31 -0.2`, `pause at 12.5s`, `late 'tool change' 5000ms`.
    #[must_use]
    pub fn text(&self) -> String {
        let mut words = vec![quoted(&self.what)];
        if !self.of.is_empty() {
            words.push(quoted(&self.of));
        }
        let is_number = self.what.contains('.');
        for by in &self.by {
            words.push(match self.what.as_str() {
                _ if is_number => by.to_string(),
                "stall" => format!("{by}st"),
                _ => format!("{}ms", by / 1000.0),
            });
        }
        if let Some(us) = self.at_us {
            words.push(format!("at {}s", us as f64 / 1e6));
        }
        words.join(" ")
    }

    /// Reads what [`Deviation::text`] writes.
    ///
    /// # Errors
    /// The word that cannot be read.
    pub fn parse(text: &str) -> Result<Self, String> {
        let mut words = words(text)?.into_iter();
        let (what, _) =
            words.next().ok_or("an empty deviation: write for example \"stuck tray.11 813ms\"")?;
        if !what.contains('.') && !crate::keys::FAULTS.contains(&what.as_str()) {
            let meant = crate::problem::nearest(&what, crate::keys::FAULTS.iter().copied());
            let meant = meant.map_or_else(
                || format!("there is {}", crate::keys::FAULTS.join(", ")),
                |other| format!("`{other}` is meant?"),
            );
            return Err(format!("`{what}` is no fault; {meant}"));
        }
        let mut deviation = Self { what, of: String::new(), by: Vec::new(), at_us: None };
        while let Some((word, is_name)) = words.next() {
            if word == "at" && !is_name {
                let time =
                    words.next().and_then(|(time, _)| time.strip_suffix('s')?.parse::<f64>().ok());
                let seconds = time
                    .filter(|time| (0.0..1e9).contains(time))
                    .ok_or_else(|| format!("\"{text}\": after `at` stands a time as `12.5s`"))?;
                deviation.at_us = Some((seconds * 1e6).round() as u64);
                continue;
            }
            match number(&word).filter(|_| !is_name) {
                Some(number) => deviation.by.push(number),
                None if deviation.of.is_empty() && deviation.by.is_empty() => deviation.of = word,
                None if !deviation.of.is_empty() && deviation.by.is_empty() => {
                    let name = &deviation.of;
                    return Err(format!(
                        "\"{text}\": `{word}` is no number; a name with blanks stands in quotes: '{name} {word}'"
                    ));
                }
                None => return Err(format!("\"{text}\": `{word}` is no number")),
            }
        }
        Ok(deviation)
    }
}
