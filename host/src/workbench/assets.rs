//! The page's files, which are part of the tool.

/// Path, kind and bytes of a file.
type Asset = (&'static str, &'static str, &'static [u8]);

const HTML: &str = "text/html; charset=utf-8";
const CSS: &str = "text/css; charset=utf-8";
const JS: &str = "text/javascript; charset=utf-8";

macro_rules! assets {
    ($($path:literal $kind:ident $file:literal)*) => {
        /// Every file.
        pub const ALL: &[Asset] = &[$(($path, $kind, include_bytes!(concat!("page/", $file)))),*];
    };
}

assets! {
    "/" HTML "index.html"
    "/operator" HTML "operator.html"
    "/setup" HTML "setup.html"
    "/app.js" JS "app.js"
    "/assist.js" JS "assist.js"
    "/blocks.js" JS "blocks.js"
    "/chart.js" JS "chart.js"
    "/document.js" JS "document.js"
    "/chips.js" JS "chips.js"
    "/dom.js" JS "dom.js"
    "/fields.js" JS "fields.js"
    "/drag.js" JS "drag.js"
    "/frame.js" JS "frame.js"
    "/editor.js" JS "editor.js"
    "/insert.js" JS "insert.js"
    "/jog.js" JS "jog.js"
    "/language.js" JS "language.js"
    "/lexer.js" JS "lexer.js"
    "/link.js" JS "link.js"
    "/machine.js" JS "machine.js"
    "/operator.css" CSS "operator.css"
    "/operator.js" JS "operator.js"
    "/path.js" JS "path.js"
    "/pulses.js" JS "pulses.js"
    "/pattern.js" JS "pattern.js"
    "/rate.js" JS "rate.js"
    "/run.js" JS "run.js"
    "/setup.css" CSS "setup.css"
    "/setup.js" JS "setup.js"
    "/sha1.js" JS "sha1.js"
    "/steps.js" JS "steps.js"
    "/strokes.js" JS "strokes.js"
    "/style.css" CSS "style.css"
    "/tabs.js" JS "tabs.js"
    "/teach.js" JS "teach.js"
    "/library.js" JS "library.js"
    "/timeline.js" JS "timeline.js"
    "/trial.js" JS "trial.js"
    "/values.js" JS "values.js"
    "/words.js" JS "words.js"
}

/// Kind and bytes of the file at a path.
pub fn find(path: &str) -> Option<(&'static str, &'static [u8])> {
    ALL.iter().find(|asset| asset.0 == path).map(|asset| (asset.1, asset.2))
}

#[cfg(test)]
mod tests {
    use super::ALL;

    #[test]
    fn the_page_is_small_and_its_files_are_one_thing_each() {
        let total: usize = ALL.iter().map(|asset| asset.2.len()).sum();
        assert!(total < 250_000, "{total} bytes");
        for (path, _, bytes) in ALL {
            let text = std::str::from_utf8(bytes).expect("text");
            assert!(text.lines().count() < 400, "{path} has {} lines", text.lines().count());
            assert!(!text.contains("http://") && !text.contains("https://"), "{path} leads away");
        }
    }

    #[test]
    fn every_module_that_is_named_is_there() {
        for (path, _, bytes) in ALL {
            let text = std::str::from_utf8(bytes).expect("text");
            for (at, _) in text.match_indices("import './").chain(text.match_indices("from './")) {
                let name = text[at..]
                    .split_once('\'')
                    .expect("a quote")
                    .1
                    .split('\'')
                    .next()
                    .expect("a quote");
                assert!(ALL.iter().any(|asset| asset.0[1..] == name[2..]), "{path} wants {name}");
            }
        }
    }
}
