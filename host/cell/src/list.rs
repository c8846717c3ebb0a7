//! Files that a cell names: lists of placements, maps of heights.

/// A row of a placement file.
#[derive(Clone, Debug, PartialEq)]
pub struct Placement {
    /// Reference.
    pub name: String,
    /// mm.
    pub x: f64,
    /// mm.
    pub y: f64,
    /// Counter-clockwise, degrees.
    pub turn_deg: f64,
}

/// Reads `Ref Val Package PosX PosY Rot Side`, blanks between the columns; lines that begin with `#` are comments.
///
/// # Errors
/// The line that cannot be read, with what is wrong.
pub fn placements(file: &str, text: &str) -> Result<Vec<Placement>, String> {
    let mut rows = Vec::new();
    for (index, line) in text.lines().enumerate() {
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let columns: Vec<&str> = line.split_whitespace().collect();
        if columns.len() < 7 {
            return Err(format!(
                "file \"{file}\": line {} has {} columns, 7 are needed",
                index + 1,
                columns.len()
            ));
        }
        let number = |column: usize| {
            let text = columns[column];
            let number = text.parse::<f64>().ok().filter(|number| number.is_finite());
            number.ok_or_else(|| {
                format!(
                    "file \"{file}\": line {} has \"{text}\" in column {}, a number is needed",
                    index + 1,
                    column + 1
                )
            })
        };
        rows.push(Placement {
            name: columns[0].to_owned(),
            x: number(3)?,
            y: number(4)?,
            turn_deg: number(5)?,
        });
    }
    Ok(rows)
}

/// Reads lines of `x y z` in mm.
///
/// # Errors
/// The line that cannot be read, with what is wrong.
pub fn heights(file: &str, text: &str) -> Result<Vec<[f64; 3]>, String> {
    let mut rows = Vec::new();
    for (index, line) in text.lines().enumerate() {
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let numbers: Vec<f64> = line
            .split([' ', ',', ';', '\t'])
            .filter(|word| !word.is_empty())
            .filter_map(|word| word.parse().ok())
            .collect();
        match numbers.try_into() {
            Ok(row) => rows.push(row),
            Err(numbers) => {
                let numbers: Vec<f64> = numbers;
                return Err(format!(
                    "file \"{file}\": line {} has {} numbers, 3 are needed",
                    index + 1,
                    numbers.len()
                ));
            }
        }
    }
    Ok(rows)
}

/// Points of an Excellon drill file, or lines of `x y`, in mm: what is expected of a drilling job.
///
/// # Errors
/// The line that cannot be read, with what is wrong.
pub fn points(file: &str, text: &str) -> Result<Vec<[f64; 2]>, String> {
    if text.trim_start().starts_with("M48") {
        return excellon(file, text);
    }
    let mut rows = Vec::new();
    for (index, line) in text.lines().enumerate() {
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let numbers: Vec<f64> = line
            .split([' ', ',', ';', '\t'])
            .filter(|word| !word.is_empty())
            .filter_map(|word| word.parse().ok())
            .collect();
        match numbers[..] {
            [x, y, ..] => rows.push([x, y]),
            _ => {
                return Err(format!(
                    "file \"{file}\": line {} has {} numbers, 2 are needed",
                    index + 1,
                    numbers.len()
                ));
            }
        }
    }
    Ok(rows)
}

/// The holes of an Excellon file with decimal points; `INCH` in its head is converted.
fn excellon(file: &str, text: &str) -> Result<Vec<[f64; 2]>, String> {
    let scale =
        if text.lines().any(|line| line.starts_with("INCH") || line == "M72") { 25.4 } else { 1.0 };
    let mut at = [0.0; 2];
    let mut rows = Vec::new();
    let mut body = false;
    for (index, line) in text.lines().enumerate() {
        let line = line.trim();
        body |= line == "%" || line == "M95";
        if !body || !line.starts_with(['X', 'Y']) {
            continue;
        }
        let mut rest = line;
        while let Some(letter) = rest.chars().next() {
            let Some(axis) = "XY".find(letter) else { break };
            let end = rest[1..]
                .find(|next: char| !(next.is_ascii_digit() || "+-.".contains(next)))
                .map_or(rest.len(), |end| end + 1);
            let word = &rest[1..end];
            if !word.contains('.') {
                return Err(format!(
                    "file \"{file}\": line {} has \"{word}\" without a decimal point",
                    index + 1
                ));
            }
            let number: f64 = word.parse().map_err(|_| {
                format!("file \"{file}\": line {} has \"{word}\", a number is needed", index + 1)
            })?;
            at[axis] = number * scale;
            rest = &rest[end..];
        }
        rows.push(at);
    }
    Ok(rows)
}
