//! The memory grows with the actual content of a file, never with what it declares.

mod bombs;
#[path = "../points/seeds.rs"]
#[allow(dead_code)]
mod cloud_seeds;
mod clouds;
mod dense;
mod lies;
mod peak;
#[path = "../read/seeds.rs"]
#[allow(dead_code)]
mod seeds;
#[path = "../read/support.rs"]
#[allow(dead_code)]
mod support;

use std::fs;
use std::path::Path;

use formats::{Result, read_scan};

/// The number of bytes that reading may take: a factor for each byte of the file, and a constant.
const PER_BYTE: usize = 16;
const FREE: usize = 64 << 20;

/// Files that take less memory are not printed.
const WORTH_TELLING: usize = 8 << 20;

/// Reads files and collects those that exceed the bound.
#[derive(Default)]
struct Judge {
    guilty: Vec<String>,
    worst: (usize, String),
}

impl Judge {
    fn judge(&mut self, title: &str, path: &Path) {
        self.judge_by(title, path, |path| read_scan(path).map(drop));
    }

    fn judge_by(&mut self, title: &str, path: &Path, read: fn(&Path) -> Result<()>) {
        let size = fs::metadata(path).expect("a file").len() as usize;
        let (peak, read) = peak::of(|| read(path));
        let outcome = read.err().map_or("read".to_owned(), |e| e.what);
        let line = format!("{peak:>10} bytes for {size:>8}: {title} ({outcome})");
        if peak > WORTH_TELLING {
            eprintln!("{line}");
        }
        if peak > PER_BYTE * size + FREE {
            self.guilty.push(line.clone());
        }
        if peak > self.worst.0 {
            self.worst = (peak, line);
        }
    }

    fn judge_made(&mut self, name: &str, title: &str, content: impl AsRef<[u8]>) {
        self.judge(title, &support::case(name, content).path);
    }
}

/// A group of files and the function that checks it.
type Group = (&'static str, fn(&mut Judge));

/// There is only one test, because the allocator counts the memory of all threads.
#[test]
fn memory_grows_with_the_bytes_read() {
    let groups: [Group; 7] = [
        ("lies", lies::judge),
        ("bombs", bombs::judge),
        ("dense files", dense::judge),
        ("clouds", clouds::judge),
        ("seeds", judge_seeds),
        ("old crashes", judge_crashes),
        ("collected scans", judge_scans),
    ];
    let mut guilty = Vec::new();
    for (group, judge_all) in groups {
        let mut judge = Judge::default();
        judge_all(&mut judge);
        eprintln!("worst of {group}: {}", judge.worst.1);
        guilty.append(&mut judge.guilty);
    }
    assert!(guilty.is_empty(), "\n{}", guilty.join("\n"));
}

/// The seeds, and the seeds with large numbers instead of their digits.
fn judge_seeds(judge: &mut Judge) {
    for (name, content) in seeds::all() {
        judge.judge_made(name, name, &content);
        for at in 0..content.len() {
            let mut file = content.clone();
            match content[at].is_ascii_digit() {
                true => drop(file.splice(at..=at, *b"4000000000")),
                false => file[at] = 0xff,
            }
            judge.judge_made(name, &format!("{name}, byte {at} changed"), file);
        }
    }
}

fn judge_crashes(judge: &mut Judge) {
    judge_folder(judge, &Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/read/crashes"));
}

/// The broken and unusual files among the collected scans.
fn judge_scans(judge: &mut Judge) {
    let Some(folder) = support::scans() else {
        eprintln!("SKIPPED: the collected scans (../../shared/scans) are not there");
        return;
    };
    judge_folder(judge, &folder.join("D"));
    judge_folder(judge, &folder.join("E"));
}

/// The files in `folder` and its subfolders.
fn judge_folder(judge: &mut Judge, folder: &Path) {
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            judge_folder(judge, &path);
        } else {
            judge.judge(&path.file_name().expect("a name").to_string_lossy(), &path);
        }
    }
}
