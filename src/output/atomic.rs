//! Files that are there whole or not at all.
//!
//! The bytes go to a temporary file in the same folder (`.NAME.PID.N.tmp`: the same file system,
//! so that renaming is one step), reach the disk, and only then take the name. Whatever was there
//! before stays untouched until that moment. An error or a panic removes the temporary file; a
//! killed process may leave one behind, never half a result.

use std::ffi::OsStr;
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};

use super::OutputError;

/// Tells apart the temporary files of one process.
static NEXT: AtomicU32 = AtomicU32::new(0);

/// How often a name that is taken (left by a killed process with our id) is stepped over.
const ATTEMPTS: u32 = 64;

/// Writes `path` with `fill`, replacing what was there only once all of it is on the disk.
///
/// A symbolic link is followed: the file it points to is replaced, the link stays. The permissions
/// of a replaced file are kept.
///
/// # Errors
///
/// When the folder is missing, when `path` is a folder, a device or a read-only file, when `fill`
/// fails, or when the operating system refuses a step. The old file is then still there.
pub fn write<F>(path: &Path, fill: F) -> Result<(), OutputError>
where
    F: FnOnce(&mut BufWriter<File>) -> io::Result<()>,
{
    let failed = |action| {
        move |source| OutputError::Io {
            path: path.to_owned(),
            action,
            source,
        }
    };
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    let replaced = check_target(path, &target)?;
    let (temporary, file) = Temporary::create(path, &target)?;
    if let Some(permissions) = replaced {
        file.set_permissions(permissions)
            .map_err(failed("keep its permissions"))?;
    }
    let mut writer = BufWriter::new(file);
    fill(&mut writer).map_err(failed("write"))?;
    writer.flush().map_err(failed("write"))?;
    writer
        .get_ref()
        .sync_all()
        .map_err(failed("flush to disk"))?;
    // Some systems do not rename an open file.
    drop(writer);
    temporary
        .rename(&target)
        .map_err(failed("rename the finished temporary file to it"))
}

/// Whether [`write()`] could begin, told before long work: the folder exists and nothing that may not be
/// replaced stands there.
///
/// # Errors
///
/// As [`write()`].
pub fn check(path: &Path) -> Result<(), OutputError> {
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    check_target(path, &target)?;
    folder_of(path, &target).map(|_| ())
}

/// The folder that the file goes to.
fn folder_of<'a>(path: &Path, target: &'a Path) -> Result<&'a Path, OutputError> {
    let folder = match target.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    if folder.is_dir() {
        Ok(folder)
    } else {
        Err(OutputError::MissingFolder {
            path: path.to_owned(),
            folder: folder.to_owned(),
        })
    }
}

/// The permissions of the file to be replaced, if there is one that may be.
fn check_target(path: &Path, target: &Path) -> Result<Option<fs::Permissions>, OutputError> {
    let Ok(metadata) = fs::metadata(target) else {
        return Ok(None);
    };
    let found = if metadata.is_dir() {
        "a folder"
    } else if !metadata.is_file() {
        // Renaming would put a plain file where `/dev/null` was.
        "a device, pipe or socket"
    } else if metadata.permissions().readonly() {
        // Renaming asks for the folder's permission only, so the file's own is honoured here.
        "a read-only file"
    } else {
        return Ok(Some(metadata.permissions()));
    };
    Err(OutputError::NotReplaceable {
        path: path.to_owned(),
        found,
    })
}

/// A file that is removed unless it is renamed.
struct Temporary {
    path: PathBuf,
    renamed: bool,
}

impl Temporary {
    fn create(path: &Path, target: &Path) -> Result<(Self, File), OutputError> {
        let folder = folder_of(path, target)?;
        let name = target.file_name().unwrap_or(OsStr::new("output"));
        let mut attempt = 1;
        loop {
            let temporary = folder.join(temporary_name(name));
            match File::create_new(&temporary) {
                Ok(file) => {
                    let guard = Self {
                        path: temporary,
                        renamed: false,
                    };
                    return Ok((guard, file));
                }
                Err(e) if e.kind() == io::ErrorKind::AlreadyExists && attempt < ATTEMPTS => {
                    attempt += 1;
                }
                Err(source) => {
                    return Err(OutputError::Io {
                        path: path.to_owned(),
                        action: "create a temporary file beside it",
                        source,
                    });
                }
            }
        }
    }

    fn rename(mut self, target: &Path) -> io::Result<()> {
        fs::rename(&self.path, target)?;
        self.renamed = true;
        Ok(())
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        if !self.renamed {
            // Already failing: the first error is the one to report.
            let _ = fs::remove_file(&self.path);
        }
    }
}

fn temporary_name(name: &OsStr) -> PathBuf {
    let number = NEXT.fetch_add(1, Ordering::Relaxed);
    let mut temporary = std::ffi::OsString::from(".");
    temporary.push(name);
    temporary.push(format!(".{}.{number}.tmp", std::process::id()));
    temporary.into()
}
