//! The G-code modes at each line of a script.

/// G-code modes as far as words of the text set them.
#[derive(Default, Hash)]
pub(super) struct Modes<'a> {
    /// The last word of each group, and the last label, behind which nothing is known.
    words: [&'a str; 7],
}

impl<'a> Modes<'a> {
    /// Follows a line; behind a label nothing is known.
    pub(super) fn follow(&mut self, text: &'a str, label: bool) {
        const GROUPS: [&[&str]; 6] = [
            &["G0", "G1", "G2", "G3", "G80", "G81", "G82", "G83"],
            &["G17", "G18", "G19"],
            &["G20", "G21"],
            &["G90", "G91"],
            &["G98", "G99"],
            &["G61", "G64"],
        ];
        if label {
            self.words = Default::default();
            self.words[6] = text;
            return;
        }
        let code = text.split(" '").next().unwrap_or(text);
        if !code.contains('G') {
            return;
        }
        for word in code.split(' ') {
            if let Some(group) = GROUPS.iter().position(|group| group.contains(&word)) {
                self.words[group] = word;
            }
        }
    }
}
