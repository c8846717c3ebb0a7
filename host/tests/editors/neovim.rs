//! The lines for Neovim on the page for editors, in the real program, and in its window.

use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

use crate::{block, there};

/// The page's lines, with the tool of these tests.
fn lines() -> String {
    let tool = env!("CARGO_BIN_EXE_pasapas");
    let lines = block("lua").replace("\"pasapas\", \"lsp\"", &format!("\"{tool}\", \"lsp\""));
    assert!(lines.contains(tool), "the lines start the tool");
    lines
}

#[test]
fn neovim_shows_problems_and_renames() {
    if !there("nvim") {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    std::fs::write(at("init.lua"), lines()).expect("a file");
    std::fs::write(at("a.bas"), "dim n\nn = 1\nMoveAx X, 5mm\nprint n\n").expect("a file");
    let script = r#"
        local function say(...) io.stdout:write(table.concat({...}, " ") .. "\n") end
        local function ask(method, extra)
          local params = vim.lsp.util.make_position_params()
          for k, v in pairs(extra or {}) do params[k] = v end
          local answers = vim.lsp.buf_request_sync(0, method, params, 10000)
          for _, answer in pairs(answers or {}) do return answer.result end
        end
        vim.wait(20000, function() return #vim.diagnostic.get(0) > 0 end)
        for _, d in ipairs(vim.diagnostic.get(0)) do say("problem", d.lnum + 1, d.message) end
        vim.api.nvim_win_set_cursor(0, {2, 0})
        say("references", #ask("textDocument/references", { context = { includeDeclaration = true } }))
        local edit = ask("textDocument/rename", { newName = "hole" })
        vim.lsp.util.apply_workspace_edit(edit, "utf-16")
        say("line", vim.api.nvim_buf_get_lines(0, 1, 2, false)[1])
        vim.cmd("qa!")
    "#;
    std::fs::write(at("try.lua"), script).expect("a file");
    let output = Command::new("nvim")
        .args(["--headless", "--clean", "-u", "init.lua", "a.bas", "-c", "luafile try.lua"])
        .current_dir(folder.path())
        .env("XDG_STATE_HOME", folder.path())
        .output()
        .expect("it runs");
    let said = String::from_utf8_lossy(&output.stdout);
    let wrong = String::from_utf8_lossy(&output.stderr);
    assert!(said.contains("problem 3 there is no statement or SUB `MoveAx`"), "{said}\n{wrong}");
    assert!(said.contains("references 3"), "{said}\n{wrong}");
    assert!(said.contains("line hole = 1"), "{said}\n{wrong}");
}

/// A terminal of its own for one program, without anybody's settings, ended with its test.
struct Terminal<'a>(&'a Path);

impl Terminal<'_> {
    fn tmux(&self, arguments: &[&str]) -> String {
        let output = Command::new("tmux")
            .args(["-f", "/dev/null", "-S"])
            .arg(self.0.join("tmux"))
            .args(arguments)
            .current_dir(self.0)
            .env("XDG_STATE_HOME", self.0)
            .env("TERM", "screen-256color")
            .env_remove("TMUX")
            .output()
            .expect("it runs");
        assert!(output.status.success(), "{arguments:?}: {output:?}");
        String::from_utf8_lossy(&output.stdout).into_owned()
    }

    /// The window as a person sees it, once these words are in it.
    fn shows(&self, words: &str) -> String {
        let begun = Instant::now();
        loop {
            let seen = self.tmux(&["capture-pane", "-p"]);
            if seen.contains(words) {
                return seen;
            }
            assert!(begun.elapsed() < Duration::from_secs(30), "no {words:?} in\n{seen}");
            std::thread::sleep(Duration::from_millis(50));
        }
    }
}

impl Drop for Terminal<'_> {
    fn drop(&mut self) {
        let _ = Command::new("tmux").arg("-S").arg(self.0.join("tmux")).arg("kill-server").output();
    }
}

#[test]
fn its_window_shows_the_problem_beside_the_line_and_help_where_it_is_asked_for() {
    if !there("nvim") || Command::new("tmux").arg("-V").output().is_err() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("init.lua"), lines()).expect("a file");
    std::fs::write(folder.path().join("a.bas"), "dim n\nn = 1\nMoveAx X, 5mm\nHome X\n")
        .expect("a file");
    let terminal = Terminal(folder.path());
    let start = "new-session -d -x 110 -y 24 nvim --clean -u init.lua a.bas";
    terminal.tmux(&start.split(' ').collect::<Vec<_>>());
    let seen = terminal.shows("there is no statement or SUB");
    let line = seen.lines().find(|line| line.contains("MoveAx X")).unwrap_or_default();
    assert!(line.contains("there is no statement or SUB `MoveAx`"), "{seen}");
    terminal.tmux(&["send-keys", "G0", ":lua vim.lsp.buf.hover()", "Enter"]);
    terminal.shows("Finds the reference switches");
}
