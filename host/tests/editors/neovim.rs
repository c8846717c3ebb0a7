//! The lines for Neovim on the page for editors, in the real program.

use std::process::Command;

use crate::{text, there};

/// The first block of that language on the page.
fn block(language: &str) -> String {
    let page = text("editors.md");
    let behind = page.split_once(&format!("```{language}\n")).expect("a block").1;
    behind.split_once("```").expect("its end").0.to_owned()
}

#[test]
fn neovim_shows_problems_and_renames() {
    if !there("nvim") {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    let tool = env!("CARGO_BIN_EXE_pasapas");
    let lines = block("lua").replace("\"pasapas\", \"lsp\"", &format!("\"{tool}\", \"lsp\""));
    assert!(lines.contains(tool), "the lines start the tool");
    std::fs::write(at("init.lua"), lines).expect("a file");
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
