//! Numbered files that are the steps of one time-dependent volume.
//!
//! `fingers_t{}.vti` stands for all files of its folder with digits in place of the braces. Their
//! order is that of the numbers; steps are counted from 0 whatever the numbers are, gaps or not.

use std::path::{Path, PathBuf};

use super::{Header, VolumeError};

/// Stands for the number in a file's name.
pub const PLACE: &str = "{}";

/// The files of a series, in order: at least one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Series {
    pattern: PathBuf,
    files: Vec<PathBuf>,
}

impl Series {
    /// Finds the files of a pattern; `None` if `path` is none: it has no `{}`, or a file of just that
    /// name exists.
    ///
    /// # Errors
    /// The folder cannot be read, no file has such a name, two have the same number, or the pattern
    /// has more than one place for a number or one that is not in the file's name.
    pub fn find(path: &Path) -> Result<Option<Self>, VolumeError> {
        let text = path.to_string_lossy();
        if !text.contains(PLACE) || path.exists() {
            return Ok(None);
        }
        let fail = |found: String, expected: &str| {
            Err(VolumeError::field(path, "series", found, expected))
        };
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let places = text.matches(PLACE).count();
        let Some((before, after)) = name.split_once(PLACE).filter(|_| places == 1) else {
            let found = format!("{places} places for a number");
            return fail(found, "one {}, in the file's name");
        };
        let folder = path
            .parent()
            .filter(|p| !p.as_os_str().is_empty())
            .unwrap_or(Path::new("."));
        let mut numbered = numbered(folder, before, after)?;
        numbered.sort();
        if let Some(pair) = numbered.windows(2).find(|w| w[0].0 == w[1].0) {
            let (a, b) = (pair[0].1.display(), pair[1].1.display());
            return fail(
                format!("{a} and {b}, which have the same number"),
                "one file for a number",
            );
        }
        if numbered.is_empty() {
            let expected = "files with digits (and nothing else) in place of {}";
            return fail(near(folder, before, after)?, expected);
        }
        Ok(Some(Self {
            pattern: path.to_owned(),
            files: numbered.into_iter().map(|n| n.1).collect(),
        }))
    }

    /// The files in order of their numbers.
    #[must_use]
    pub fn files(&self) -> &[PathBuf] {
        &self.files
    }

    /// How many steps there are.
    #[must_use]
    pub fn steps(&self) -> u32 {
        u32::try_from(self.files.len()).unwrap_or(u32::MAX)
    }

    /// The file of a step.
    ///
    /// # Errors
    /// There is no such step.
    pub fn file(&self, step: u32) -> Result<&Path, VolumeError> {
        let file = self.files.get(step as usize).map(PathBuf::as_path);
        file.ok_or_else(|| {
            let last = self.files.len().saturating_sub(1);
            let names = [self.files.first(), self.files.last()];
            let [first, end] = names.map(|f| {
                let name = f.and_then(|f| f.file_name()).unwrap_or_default();
                name.to_string_lossy().into_owned()
            });
            let found = format!("a request for time step {step}");
            let expected = format!("a time step from 0 ({first}) to {last} ({end})");
            VolumeError::field(&self.pattern, "series", found, expected)
        })
    }

    /// Checks that a step's file holds what the first one's does: as many voxels of the same type,
    /// and no further steps.
    ///
    /// # Errors
    /// It does not; names both files.
    pub(super) fn check(
        &self,
        step: u32,
        header: &Header,
        first: &Header,
    ) -> Result<(), VolumeError> {
        let path = self.file(step)?;
        if header.time_steps != 1 {
            let found = format!("{} time steps in a file of a series", header.time_steps);
            let expected = "files of one time step each";
            return Err(VolumeError::field(path, "series", found, expected));
        }
        let shown = |h: &Header| {
            let d = h.grid.dims;
            format!("{} × {} × {} voxels of {}", d.x, d.y, d.z, h.scalar_type)
        };
        let (found, expected) = (shown(header), shown(first));
        if found == expected {
            return Ok(());
        }
        let expected = format!("{expected} as in {}", self.file(0)?.display());
        Err(VolumeError::field(path, "series", found, expected))
    }
}

/// The names in a folder, those that are text.
fn names(folder: &Path) -> Result<Vec<String>, VolumeError> {
    let io = |e| VolumeError::io(folder, "list", e);
    let mut names = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(io)? {
        names.extend(entry.map_err(io)?.file_name().into_string());
    }
    Ok(names)
}

/// The files of a folder whose names are digits between `before` and `after`, with their numbers.
fn numbered(folder: &Path, before: &str, after: &str) -> Result<Vec<(u64, PathBuf)>, VolumeError> {
    let mut list = Vec::new();
    for name in names(folder)? {
        let digits = name
            .strip_prefix(before)
            .and_then(|rest| rest.strip_suffix(after));
        let is_number = |d: &&str| !d.is_empty() && d.bytes().all(|b| b.is_ascii_digit());
        let Some(digits) = digits.filter(is_number) else {
            continue;
        };
        let path = folder.join(&name);
        let number = digits.parse().map_err(|_| {
            let expected = "a number below 2^64 in place of {}";
            VolumeError::field(&path, "file name", digits.to_owned(), expected)
        })?;
        list.push((number, path));
    }
    Ok(list)
}

/// What is in a folder where no file fits: how many, and one that nearly does.
fn near(folder: &Path, before: &str, after: &str) -> Result<String, VolumeError> {
    let mut names = names(folder)?;
    names.sort();
    let fits = |n: &&String| n.starts_with(before) && n.ends_with(after);
    let nearly = names.iter().find(fits);
    let nearly = nearly.or_else(|| names.iter().find(|n| n.ends_with(after)));
    let such = nearly.map_or(String::new(), |n| format!(", such as {n}"));
    let count = names.len();
    Ok(format!(
        "none among {count} names in {}{such}",
        folder.display()
    ))
}
