//! Output files of commands: never over an input, and complete or not at all.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use crate::failure::Failure;

/// Refuses a command line on which an output is an input, or two outputs are one file: under
/// another name, through a link, or as a second name of the same file. An `output` is an option and
/// the path behind it; standard input and output (`-`) are no files.
///
/// # Errors
/// [`Failure::Usage`] with the option, and the input that it would destroy.
pub fn keep_inputs<P: AsRef<Path>>(
    outputs: &[(&str, Option<P>)],
    inputs: &[Option<&Path>],
) -> Result<(), Failure> {
    let outputs: Vec<(&str, &Path)> = outputs
        .iter()
        .filter_map(|(option, path)| Some((*option, path.as_ref()?.as_ref())))
        .filter(|(_, path)| *path != Path::new("-"))
        .collect();
    for (i, (option, output)) in outputs.iter().enumerate() {
        let name = output.display();
        if let Some(input) = inputs.iter().flatten().find(|input| is_same(output, input)) {
            return Err(Failure::Usage(format!(
                "{option} {name} would overwrite the input {}: give it another name",
                input.display()
            )));
        }
        if let Some((other, _)) = outputs[..i].iter().find(|(_, other)| is_same(output, other)) {
            return Err(Failure::Usage(format!(
                "{option} {name} is the file of {other} too: give each a name of its own"
            )));
        }
    }
    Ok(())
}

/// Whether two paths lead to one regular file, or would once it is written.
fn is_same(a: &Path, b: &Path) -> bool {
    match (fs::metadata(a), fs::metadata(b)) {
        // Devices and pipes may be read and written at a time.
        (Ok(a), Ok(b)) if !a.is_file() || !b.is_file() => false,
        (Ok(own), Ok(other)) => is_one_file(&own, &other) || canonical(a) == canonical(b),
        (Err(_), Err(_)) => canonical(a) == canonical(b),
        _ => false,
    }
}

#[cfg(unix)]
fn is_one_file(a: &fs::Metadata, b: &fs::Metadata) -> bool {
    use std::os::unix::fs::MetadataExt as _;
    (a.dev(), a.ino()) == (b.dev(), b.ino())
}

#[cfg(not(unix))]
fn is_one_file(_a: &fs::Metadata, _b: &fs::Metadata) -> bool {
    false
}

/// The path without links; of a file that is not there, by its folder.
fn canonical(path: &Path) -> Option<PathBuf> {
    if let Ok(path) = fs::canonicalize(path) {
        return Some(path);
    }
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    let folder = fs::canonicalize(folder.unwrap_or(Path::new("."))).ok()?;
    Some(folder.join(path.file_name()?))
}

/// A file under way. It is written beside its place, and [`OutputFile::finish`] puts it there:
/// a full disk or the end of the process leaves what stood there before. A device or a pipe is
/// written to as it is.
#[derive(Debug)]
pub struct OutputFile {
    to: To,
}

#[derive(Debug)]
enum To {
    /// The file beside its place, and the place.
    Beside(BufWriter<NamedTempFile>, PathBuf),
    Device(BufWriter<File>),
}

impl OutputFile {
    /// Begins a file that is to stand at `path`, with the permissions of what stands there.
    ///
    /// # Errors
    /// The folder is not there or takes no file, or what stands there may not be written.
    pub fn create(path: &Path) -> io::Result<OutputFile> {
        // A link stays a link: what it leads to is replaced.
        let place = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
        let old = match fs::metadata(&place) {
            Ok(old) if old.is_dir() => return Err(io::ErrorKind::IsADirectory.into()),
            Ok(old) if !old.is_file() => {
                let device = OpenOptions::new().write(true).open(&place)?;
                return Ok(OutputFile { to: To::Device(BufWriter::new(device)) });
            }
            // What may not be written is not replaced either.
            Ok(old) => OpenOptions::new().append(true).open(&place).map(|_| Some(old))?,
            Err(_) => None,
        };
        let folder = place.parent().filter(|folder| !folder.as_os_str().is_empty());
        let name = place.file_name().unwrap_or_default();
        let mut builder = tempfile::Builder::new();
        builder.prefix(name).suffix(".new");
        let new = new_file(&mut builder).tempfile_in(folder.unwrap_or(Path::new(".")))?;
        if let Some(old) = old {
            keep_owner(new.path(), &old);
            new.as_file().set_permissions(old.permissions())?;
        }
        Ok(OutputFile { to: To::Beside(BufWriter::new(new), place) })
    }

    /// Puts the file in its place.
    ///
    /// # Errors
    /// What was written last does not fit, or the place does not take it.
    pub fn finish(self) -> io::Result<()> {
        match self.to {
            To::Device(mut device) => device.flush(),
            To::Beside(file, place) => {
                let file = file.into_inner().map_err(io::IntoInnerError::into_error)?;
                file.persist(place).map(drop).map_err(|error| error.error)
            }
        }
    }
}

impl Write for OutputFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match &mut self.to {
            To::Beside(file, _) => file.write(bytes),
            To::Device(device) => device.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match &mut self.to {
            To::Beside(file, _) => file.flush(),
            To::Device(device) => device.flush(),
        }
    }
}

/// A new file has the permissions that the user's mask leaves, as any that a program creates.
#[cfg(unix)]
fn new_file<'b, 'p, 's>(
    builder: &'b mut tempfile::Builder<'p, 's>,
) -> &'b mut tempfile::Builder<'p, 's> {
    use std::os::unix::fs::PermissionsExt as _;
    builder.permissions(fs::Permissions::from_mode(0o666))
}

#[cfg(not(unix))]
fn new_file<'b, 'p, 's>(
    builder: &'b mut tempfile::Builder<'p, 's>,
) -> &'b mut tempfile::Builder<'p, 's> {
    builder
}

/// The owner and the group stay, as far as this user may say so.
#[cfg(unix)]
fn keep_owner(new: &Path, old: &fs::Metadata) {
    use std::os::unix::fs::MetadataExt as _;
    let _ = std::os::unix::fs::chown(new, Some(old.uid()), Some(old.gid()));
}

#[cfg(not(unix))]
fn keep_owner(_new: &Path, _old: &fs::Metadata) {}

/// Writes a file in one step.
///
/// # Errors
/// It cannot be written; what stood there is still there.
pub fn replace(path: &Path, content: &[u8]) -> io::Result<()> {
    let mut file = OutputFile::create(path)?;
    file.write_all(content)?;
    file.finish()
}

/// The same for a command's result.
///
/// # Errors
/// [`Failure::Output`] with the path.
pub fn write(path: impl AsRef<Path>, content: impl AsRef<[u8]>) -> Result<(), Failure> {
    let path = path.as_ref();
    replace(path, content.as_ref())
        .map_err(|error| Failure::writing(&path.display().to_string(), &error))
}

#[cfg(test)]
mod tests {
    use super::{OutputFile, keep_inputs, replace};
    use std::fs;
    use std::io::Write as _;
    use std::path::Path;

    #[test]
    fn a_file_that_is_not_finished_leaves_what_was_there() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.txt");
        fs::write(&path, "old").expect("written");
        let mut file = OutputFile::create(&path).expect("begun");
        file.write_all(b"new and longer").and_then(|()| file.flush()).expect("written beside");
        assert_eq!(fs::read_to_string(&path).expect("there"), "old");
        drop(file);
        assert_eq!(fs::read_to_string(&path).expect("there"), "old");
        assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 1, "something is left");
        replace(&path, b"new").expect("replaced");
        assert_eq!(fs::read_to_string(&path).expect("there"), "new");
        assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 1, "something is left");
    }

    #[cfg(unix)]
    #[test]
    fn permissions_links_and_devices_stay_what_they_are() {
        use std::os::unix::fs::PermissionsExt as _;
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.txt");
        fs::write(&path, "old").expect("written");
        fs::set_permissions(&path, fs::Permissions::from_mode(0o640)).expect("set");
        let link = folder.path().join("link");
        std::os::unix::fs::symlink(&path, &link).expect("a link");
        replace(&link, b"new").expect("replaced");
        assert!(fs::symlink_metadata(&link).expect("there").is_symlink());
        assert_eq!(fs::read_to_string(&path).expect("there"), "new");
        let mode = fs::metadata(&path).expect("there").permissions().mode();
        assert_eq!(mode & 0o777, 0o640);
        // As a file that the system itself creates, whatever the user's mask is.
        let plain = folder.path().join("plain");
        fs::write(&plain, "").expect("written");
        replace(&folder.path().join("fresh"), b"x").expect("made");
        let mode =
            |name: &str| fs::metadata(folder.path().join(name)).expect("there").permissions();
        assert_eq!(mode("fresh").mode(), mode("plain").mode());
        replace(Path::new("/dev/null"), b"x").expect("taken");
        assert!(!fs::metadata("/dev/null").expect("there").is_file());
    }

    #[cfg(unix)]
    #[test]
    fn an_input_is_known_under_every_name() {
        let folder = tempfile::tempdir().expect("a folder");
        let at = |name: &str| folder.path().join(name);
        fs::write(at("a.bas"), "END\n").expect("written");
        fs::create_dir(at("sub")).expect("a folder");
        std::os::unix::fs::symlink(at("a.bas"), at("link")).expect("a link");
        fs::hard_link(at("a.bas"), at("hard")).expect("a second name");
        let input = at("a.bas");
        for name in ["a.bas", "sub/../a.bas", "link", "hard"] {
            let outputs = [("--trace", Some(at(name)))];
            assert!(keep_inputs(&outputs, &[Some(&input)]).is_err(), "{name}");
        }
        let twice = [("--trace", Some(at("new"))), ("--plot", Some(at("sub/../new")))];
        assert!(keep_inputs(&twice, &[]).is_err());
        let good = [("--trace", Some(at("new"))), ("--plot", None), ("-o", Some("-".into()))];
        assert!(keep_inputs(&good, &[Some(&input), None]).is_ok());
        let null = Path::new("/dev/null");
        assert!(keep_inputs(&[("-o", Some(null))], &[Some(null)]).is_ok());
    }
}
