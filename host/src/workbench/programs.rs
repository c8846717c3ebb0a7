//! The programs that this tool knows: the one that the text compiles to, and the one that the board
//! holds. A board tells length and CRC of its program; what these belong to is found here.

use std::sync::Arc;

use serde::Serialize;

use crate::client::identity::Identity;
use crate::trial::Loaded;

/// A program with the file that it was made from.
#[derive(Clone)]
struct Known {
    loaded: Arc<Loaded>,
    /// Name of the file; none for a text that has no file yet.
    name: Option<String>,
    /// Number of the text.
    number: u64,
}

/// See the module.
#[derive(Default)]
pub struct Programs {
    /// The text's, while it compiles.
    text: Option<Known>,
    /// The one that was brought to the board, or that was found to be there.
    board: Option<Known>,
    /// The name in the board's own library of the program with this length and CRC.
    library: Option<(u16, u16, String)>,
}

/// The board's program.
#[derive(Clone)]
pub struct OnBoard {
    /// It.
    pub loaded: Arc<Loaded>,
    /// It is what the present text compiles to.
    pub current: bool,
}

/// What pages say of the board's program.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Holds {
    /// The script's file, or its name in the board's library; none where neither is known.
    pub name: Option<String>,
    /// The script is known here: its variables and lines can be shown.
    pub known: bool,
}

impl Programs {
    /// What text number `number` of a file compiles to; `None`: it does not compile. The program of
    /// the text before it stays known while the board holds it.
    pub fn compiled(
        &mut self,
        number: u64,
        loaded: Option<Arc<Loaded>>,
        name: Option<String>,
        board: Option<&Identity>,
    ) {
        if let Some(old) = self.text.take_if(|old| board.is_some_and(|board| fits(old, board))) {
            self.board = Some(old);
        }
        self.text = loaded.map(|loaded| Known { loaded, name, number });
    }

    /// This one was brought to the board, or found there.
    pub fn brought(&mut self, loaded: Arc<Loaded>, name: Option<String>) {
        self.board = Some(Known { loaded, name, number: 0 });
    }

    /// The board's own name of the program that it holds.
    pub fn named(&mut self, board: &Identity, name: String) {
        self.library = Some((board.program_bytes, board.program_crc, name));
    }

    /// The text's program, if it compiles.
    pub fn of_text(&self) -> Option<&Arc<Loaded>> {
        self.text.as_ref().map(|own| &own.loaded)
    }

    /// The board's program, where it is known; `number` is that of the present text.
    pub fn on_board(&self, board: &Identity, number: u64) -> Option<OnBoard> {
        let own = self.find(board)?;
        let text =
            self.text.as_ref().is_some_and(|text| text.number == number && fits(text, board));
        Some(OnBoard { loaded: own.loaded.clone(), current: text })
    }

    /// What pages say of the board's program; `None`: it holds none.
    pub fn holds(&self, board: &Identity) -> Option<Holds> {
        if board.program_bytes == 0 {
            return None;
        }
        let own = self.find(board);
        let library = self.library.as_ref().filter(|(bytes, crc, name)| {
            (*bytes, *crc) == (board.program_bytes, board.program_crc) && !name.is_empty()
        });
        let name = own.and_then(|own| own.name.clone());
        let name = name.or_else(|| library.map(|(.., name)| name.clone()));
        Some(Holds { name, known: own.is_some() })
    }

    /// What was brought says its name for certain; another text may compile to the same program.
    fn find(&self, board: &Identity) -> Option<&Known> {
        [&self.board, &self.text].into_iter().flatten().find(|own| fits(own, board))
    }
}

fn fits(own: &Known, board: &Identity) -> bool {
    own.loaded.is(board.program_bytes, board.program_crc)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use lang::front::ProfileChoice;

    use super::{Holds, Programs};
    use crate::client::identity::Identity;
    use crate::trial::{Loaded, load};

    fn loaded(text: &str) -> Arc<Loaded> {
        Arc::new(load(text, ProfileChoice::built_in()).expect("it compiles"))
    }

    fn board(loaded: &Loaded) -> Identity {
        Identity {
            program_bytes: loaded.compiled.image.len() as u16,
            program_crc: loaded.crc,
            ..Identity::default()
        }
    }

    #[test]
    fn only_the_present_text_is_current() {
        let mut programs = Programs::default();
        let (old, new) = (loaded("Wait 1s\n"), loaded("Wait 2s\n"));
        programs.compiled(1, Some(old.clone()), Some("a.bas".to_owned()), None);
        let held = board(&old);
        assert!(programs.on_board(&held, 1).expect("known").current);
        // A text that was not compiled yet, one that does not compile, and another one.
        assert!(!programs.on_board(&held, 2).expect("known").current);
        programs.compiled(2, None, Some("a.bas".to_owned()), Some(&held));
        let known = programs.on_board(&held, 2).expect("it is still on the board");
        assert!(!known.current && known.loaded.crc == old.crc);
        programs.compiled(3, Some(new.clone()), Some("a.bas".to_owned()), Some(&held));
        assert!(!programs.on_board(&held, 3).expect("known").current);
        assert!(programs.on_board(&board(&new), 3).expect("known").current);
        // Undone: the same program again.
        programs.compiled(4, Some(loaded("Wait 1s ' as before\n")), None, Some(&held));
        assert!(programs.on_board(&held, 4).expect("known").current);
    }

    #[test]
    fn the_board_says_which_program_it_holds() {
        let mut programs = Programs::default();
        let (one, two) = (loaded("Wait 1s\n"), loaded("Wait 2s\n"));
        let told = |name: Option<&str>, known| Some(Holds { name: name.map(str::to_owned), known });
        assert_eq!(programs.holds(&Identity::default()), None);
        assert_eq!(programs.holds(&board(&one)), told(None, false));
        programs.named(&board(&one), "washers".to_owned());
        assert_eq!(programs.holds(&board(&one)), told(Some("washers"), false));
        assert_eq!(programs.holds(&board(&two)), told(None, false));
        programs.compiled(1, Some(two), Some("brackets.bas".to_owned()), None);
        assert_eq!(programs.holds(&board(&one)), told(Some("washers"), false));
        programs.brought(one.clone(), Some("rings.bas".to_owned()));
        assert_eq!(programs.holds(&board(&one)), told(Some("rings.bas"), true));
    }
}
