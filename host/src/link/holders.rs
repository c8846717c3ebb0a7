//! Processes that have a device open, for the error message.

use std::fs;
use std::path::Path;

/// `` `minicom` (process 1234)``
pub fn describe(pid: i32) -> String {
    match fs::read_to_string(format!("/proc/{pid}/comm")) {
        Ok(name) => format!("`{}` (process {pid})", name.trim()),
        Err(_) => format!("process {pid}"),
    }
}

/// The other processes that have the device open, as far as the system shows them: Linux shows a
/// user's own, and all to root.
pub fn of(device: &str) -> Vec<String> {
    let Ok(device) = fs::canonicalize(device) else { return Vec::new() };
    let Ok(processes) = fs::read_dir("/proc") else { return Vec::new() };
    let own = std::process::id();
    let pids = processes.flatten().filter_map(|entry| entry.file_name().to_str()?.parse().ok());
    pids.filter(|pid: &i32| pid.unsigned_abs() != own && has_open(*pid, &device))
        .map(describe)
        .collect()
}

fn has_open(pid: i32, device: &Path) -> bool {
    let Ok(files) = fs::read_dir(format!("/proc/{pid}/fd")) else { return false };
    files.flatten().any(|file| fs::read_link(file.path()).is_ok_and(|target| target == device))
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use std::process::{Command, Stdio};

    #[test]
    fn a_process_that_has_a_file_open_is_named_with_its_number() {
        let file = tempfile::NamedTempFile::new().expect("a file");
        let path = file.path().to_str().expect("UTF-8").to_owned();
        assert_eq!(super::of(&path), [""; 0], "our own process is not told");
        let input = file.reopen().expect("the file");
        let mut other = Command::new("sleep")
            .arg("60")
            .stdin(Stdio::from(input))
            .spawn()
            .expect("sleep starts");
        let told = super::of(&path);
        let _ = other.kill();
        let _ = other.wait();
        assert_eq!(told, [format!("`sleep` (process {})", other.id())]);
    }
}
