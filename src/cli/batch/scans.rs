//! The scans of a batch, in order, and the names of their outputs.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use formats::{Format, PointFormat};
use serde::Serialize;
use walkdir::WalkDir;

use crate::cli::Failure;
use crate::cli::args::{cad_file, report_file};
use crate::cli::cad::part_name;

/// A scan of a batch.
#[derive(Debug, Clone)]
pub(crate) struct FoundScan {
    /// The path as the user would write it.
    pub path: PathBuf,
    /// The name of its outputs in the output folder, without extensions. No other scan of the
    /// batch has the same.
    pub name: PathBuf,
}

/// The paths of scans by their places on the disk, in the order of the places.
type Found = BTreeMap<PathBuf, PathBuf>;

/// What a search finds in folders and among the matches of patterns.
#[derive(Default)]
struct ScanSearch {
    found: Found,
    left_out: Vec<UnusedFile>,
}

/// A file that is not converted, and why.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct UnusedFile {
    pub file: String,
    pub reason: &'static str,
}

impl ScanSearch {
    /// Notes a file that is left out. CAD files, reports and summaries are not noted, because they are
    /// often beside their scans.
    fn leave_out(&mut self, path: &Path) {
        let reason = match has_scan_name(path) {
            true if path.is_file() => "has no line with three numbers",
            true => "is not an ordinary file",
            false if is_output(path) => return,
            false => "has not the extension of a scan",
        };
        self.left_out.push(UnusedFile { file: path.display().to_string(), reason });
    }
}

/// All scans that the arguments name, sorted, and the files that are left out. The names of scans
/// include the folders below the one that all arguments share.
pub(crate) fn find(
    arguments: &[PathBuf],
    out: &Path,
) -> Result<(Vec<FoundScan>, Vec<UnusedFile>), Failure> {
    let mut search = ScanSearch::default();
    let mut roots = Vec::new();
    for argument in arguments {
        let (root, paths) = expanded(argument, &mut search)?;
        roots.push(place(&root)?);
        for path in paths {
            if path.is_dir() {
                walk(&path, out, &mut search)?;
            } else {
                search.found.entry(place_of_file(&path)?).or_insert(path);
            }
        }
    }
    let ScanSearch { found, mut left_out } = search;
    left_out.sort_by(|a, b| a.file.cmp(&b.file));
    left_out.dedup_by(|a, b| a.file == b.file);
    if found.is_empty() {
        let all: Vec<_> = arguments.iter().map(|a| a.display().to_string()).collect();
        let what = match left_out.as_slice() {
            [] => "no scan found".to_owned(),
            [first, ..] => format!("no scan found; {} {}", first.file, first.reason),
        };
        return Err(failure(&all.join(", "), &what));
    }
    let base = roots.into_iter().reduce(|a, b| common(&a, &b)).unwrap_or_default();
    Ok((named(found, &base), left_out))
}

fn failure(of: &str, what: &str) -> Failure {
    let help = "name folders, patterns or files of meshes or clouds of points, as .ply or .xyz.gz";
    Failure { error: format!("{of}: {what}"), help: help.into() }
}

/// The folder from which an argument's names are counted, and the paths that it stands for.
fn expanded(argument: &Path, search: &mut ScanSearch) -> Result<(PathBuf, Vec<PathBuf>), Failure> {
    let fail = |what: &str| failure(&argument.display().to_string(), what);
    let text = argument.to_string_lossy();
    let is_pattern = |text: &str| text.contains(['*', '?', '[']);
    if argument.is_dir() {
        return Ok((argument.to_owned(), vec![argument.to_owned()]));
    }
    if !argument.exists() && is_pattern(&text) {
        let matches = glob::glob(&text).map_err(|e| fail(&format!("is no pattern: {e}")))?;
        let matches: Result<Vec<_>, _> = matches.collect();
        let mut matches = matches.map_err(|e| fail(&e.to_string()))?;
        matches.retain(|path| {
            let is_taken = path.is_dir() || is_scan(path);
            if !is_taken {
                search.leave_out(path);
            }
            is_taken
        });
        let plain =
            argument.components().take_while(|c| !is_pattern(&c.as_os_str().to_string_lossy()));
        return Ok((plain.collect(), matches));
    }
    // A scan that does not exist fails later, by itself.
    if !argument.exists() && !has_scan_name(argument) {
        return Err(fail("no such file or folder"));
    }
    let folder = argument.parent().unwrap_or(Path::new(""));
    Ok((folder.to_owned(), vec![argument.to_owned()]))
}

/// Whether a file is the summary of a batch in its output folder, and no cloud of points.
fn is_summary(path: &Path, out: Option<&Path>) -> bool {
    let folder = path.parent().and_then(|folder| folder.canonicalize().ok());
    path.file_name() == Some("summary.csv".as_ref()) && out.is_some() && folder.as_deref() == out
}

/// Whether a file has the extension of an output: a CAD file, a report or a summary.
fn is_output(path: &Path) -> bool {
    let name = path.to_string_lossy();
    cad_file(&name).is_ok() || report_file(&name).is_ok()
}

/// Whether a file has the extension of a mesh or of a cloud of points.
fn has_scan_name(path: &Path) -> bool {
    Format::by_extension(path).is_some() || PointFormat::by_extension(path).is_some()
}

/// Whether a match of a pattern is a file with the extension of a scan, and not a text or a table without
/// points. A broken link counts, and fails later by itself. A pipe does not count, because reading it could
/// wait for ever.
fn is_scan(path: &Path) -> bool {
    let is_file = path.metadata().map_or(true, |meta| meta.is_file());
    has_scan_name(path) && is_file && !PointFormat::is_other_text(path)
}

/// Finds the scans in a folder and its subfolders. Hidden folders and the output folder are left
/// out.
fn walk(folder: &Path, out: &Path, search: &mut ScanSearch) -> Result<(), Failure> {
    let out = out.canonicalize().ok();
    let entries = WalkDir::new(folder).follow_links(true).into_iter().filter_entry(|entry| {
        let hidden = entry.depth() > 0 && entry.file_name().to_string_lossy().starts_with('.');
        // The output may go to the folder of the scans themselves.
        let output = entry.depth() > 0
            && entry.file_type().is_dir()
            && out.is_some()
            && entry.path().canonicalize().ok() == out;
        !hidden && !output
    });
    for entry in entries {
        let path = match entry {
            Ok(entry) if entry.file_type().is_file() => entry.into_path(),
            Ok(entry) if entry.file_type().is_dir() => continue,
            Ok(entry) => {
                search.leave_out(entry.path());
                continue;
            }
            // A broken link with the extension of a scan fails later, by itself.
            Err(e) => match e.path().filter(|path| path.is_symlink()) {
                Some(path) => path.to_owned(),
                None => return Err(failure(&folder.display().to_string(), &e.to_string())),
            },
        };
        if is_summary(&path, out.as_deref()) {
            continue;
        }
        if !has_scan_name(&path) || PointFormat::is_other_text(&path) {
            search.leave_out(&path);
        } else {
            search.found.entry(place_of_file(&path)?).or_insert(path);
        }
    }
    Ok(())
}

/// The real path of a folder, links followed.
fn place(folder: &Path) -> Result<PathBuf, Failure> {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    folder.canonicalize().map_err(|e| failure(&folder.display().to_string(), &e.to_string()))
}

/// The real path of a file's folder, with the file's name. A link to a file is not followed.
fn place_of_file(path: &Path) -> Result<PathBuf, Failure> {
    Ok(place(path.parent().unwrap_or(Path::new("")))?.join(path.file_name().unwrap_or_default()))
}

/// The deepest folder that contains both folders.
fn common(a: &Path, b: &Path) -> PathBuf {
    a.components().zip(b.components()).take_while(|(a, b)| a == b).map(|(a, _)| a).collect()
}

/// Names scans by their files without extensions. Scans that would have the same name keep the
/// extension, and so does a scan whose name is taken by one of these.
fn named(found: Found, base: &Path) -> Vec<FoundScan> {
    let full = |place: &Path| place.strip_prefix(base).unwrap_or(place).to_owned();
    let mut names: BTreeMap<PathBuf, PathBuf> = found
        .keys()
        .map(|place| (place.clone(), full(place).with_file_name(part_name(place))))
        .collect();
    loop {
        let mut seen = BTreeSet::new();
        let twice: BTreeSet<PathBuf> =
            names.values().filter(|name| !seen.insert(*name)).cloned().collect();
        let mut changed = false;
        for (place, name) in names.iter_mut().filter(|(_, name)| twice.contains(*name)) {
            changed |= *name != full(place);
            *name = full(place);
        }
        if !changed {
            break;
        }
    }
    found
        .into_iter()
        .map(|(place, path)| FoundScan { path, name: names.remove(&place).unwrap_or(place) })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(places: &[&str]) -> Vec<String> {
        let found = places.iter().map(|p| (PathBuf::from(p), PathBuf::from(p))).collect();
        let scans = named(found, Path::new("/s"));
        scans.into_iter().map(|scan| scan.name.display().to_string()).collect()
    }

    #[test]
    fn names_keep_folders_and_tell_formats_apart() {
        assert_eq!(names(&["/s/a.ply", "/s/b.obj.gz", "/s/c/a.ply"]), ["a", "b", "c/a"]);
        assert_eq!(names(&["/s/a.ply", "/s/a.stl"]), ["a.ply", "a.stl"]);
        assert_eq!(
            names(&["/s/a.ply", "/s/a.ply.ply", "/s/a.stl"]),
            ["a.ply", "a.ply.ply", "a.stl"]
        );
    }
}
