//! Clouds: dense files, false counts, bombs, and the collected ones.

use std::fs;
use std::path::Path;

use formats::read_points;

use crate::cloud_seeds::surveys::{with_checksums, without_checksums};
use crate::{Judge, cloud_seeds, support};

const SIZE: usize = 4 << 20;

pub fn judge(judge: &mut Judge) {
    seeds(judge);
    surveys(judge);
    dense(judge);
    lies(judge);
    bombs(judge);
    collected(judge);
}

fn judge_made(judge: &mut Judge, name: &str, title: &str, content: impl AsRef<[u8]>) {
    judge_path(judge, title, &support::case(name, content).path);
}

fn judge_path(judge: &mut Judge, title: &str, path: &Path) {
    judge.judge_by(title, path, |path| read_points(path).map(drop));
}

/// The seeds, and those with each of their digits made a great number.
fn seeds(judge: &mut Judge) {
    for (name, content) in cloud_seeds::all() {
        judge_made(judge, name, name, &content);
        for at in 0..content.len() {
            let mut file = content.clone();
            match content[at].is_ascii_digit() {
                true => drop(file.splice(at..=at, *b"4000000000")),
                false => file[at] = 0xff,
            }
            judge_made(judge, name, &format!("{name}, byte {at} changed"), file);
        }
    }
}

/// Great numbers at every place of the files with headers of bytes. E57 gets new checksums, because
/// otherwise none of its numbers would be believed.
fn surveys(judge: &mut Judge) {
    let is_survey = |name: &str| ["e57", "las", "laz"].iter().any(|end| name.ends_with(end));
    for (name, content) in cloud_seeds::all().into_iter().filter(|(name, _)| is_survey(name)) {
        let is_e57 = name.ends_with("e57");
        let content = if is_e57 { without_checksums(&content) } else { content };
        for at in 0..content.len() - 8 {
            for lie in [1u64 << 31, 1 << 40, u64::MAX] {
                let mut file = content.clone();
                file[at..at + 8].copy_from_slice(&lie.to_le_bytes());
                let file = if is_e57 { with_checksums(&file) } else { file };
                judge_made(judge, name, &format!("{name}, {lie} at byte {at}"), file);
            }
        }
    }
}

const PTX_HEAD: &str = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n";

/// Files with the most points for their size.
fn dense(judge: &mut Judge) {
    let rows = |row: &str| row.repeat(SIZE / row.len());
    for (name, row) in [
        ("points.xyz", "1 1 1\n"),
        ("normals.xyz", "1 1 1 1 0 0\n"),
        ("zeros.xyz", "0 0 0\n"),
        ("nothing.xyz", "nan nan nan\n"),
        ("counts.pts", "1\n"),
    ] {
        judge_made(judge, name, &format!("dense {name}"), format!("1 1 1\n{}", rows(row)));
    }
    for (row, name) in [("1 1 1\n", "full"), ("0 0 0\n", "empty")] {
        let count = SIZE / row.len() / 2;
        let text = format!("2\n{count}\n{PTX_HEAD}{}", rows(row));
        judge_made(judge, "dense.ptx", &format!("dense PTX, {name}"), text);
    }
    let count = SIZE / 3;
    for value in [0u8, 1] {
        let body = vec![value; SIZE];
        let head = pcd("U", 1, "binary", count / 2, 2);
        let file = [head.as_bytes(), &body].concat();
        judge_made(
            judge,
            "dense.pcd",
            &format!("dense PCD of {value}"),
            &file[..head.len() + count / 2 * 6],
        );
    }
    let head = "ply\nformat binary_little_endian 1.0\nobj_info num_cols 2\n\
                obj_info num_rows 2000000\nelement range_grid 4000000\n\
                property list uchar uchar vertex_indices\nend_header\n";
    judge_made(
        judge,
        "grid.ply",
        "dense range grid",
        [head.as_bytes(), &vec![0; 4_000_000]].concat(),
    );
}

fn pcd(letter: &str, size: usize, encoding: &str, width: usize, height: usize) -> String {
    format!(
        "VERSION 0.7\nFIELDS x y z\nSIZE {size} {size} {size}\nTYPE {letter} {letter} {letter}\n\
         COUNT 1 1 1\nWIDTH {width}\nHEIGHT {height}\nDATA {encoding}\n"
    )
}

/// Small files that claim to be great.
fn lies(judge: &mut Judge) {
    for encoding in ["ascii", "binary", "binary_compressed"] {
        for height in [1, 40_000] {
            let head = pcd("F", 4, encoding, 100_000, height);
            let body = b"\x10\0\0\0\xff\xff\xff\xff\0 1 2 3\n";
            judge_made(judge, "lie.pcd", encoding, [head.as_bytes(), body].concat());
        }
    }
    // Packed points that say truly how large they would be.
    let head = pcd("F", 4, "binary_compressed", 300_000_000, 1);
    let sizes = [2_000_000_000u32, 3_600_000_000].map(u32::to_le_bytes).concat();
    judge_made(judge, "lie.pcd", "packed PCD", [head.as_bytes(), &sizes, &[0; 100]].concat());
    let text = format!("60000\n60000\n{PTX_HEAD}1 1 1 0\n");
    judge_made(judge, "lie.ptx", "PTX", text);
    judge_made(judge, "lie.pts", "PTS", "18446744073709551615\n1 2 3\n18446744073709551615\n");
}

/// Files that unpack to far more than they are.
fn bombs(judge: &mut Judge) {
    for (name, head, row) in [
        ("points.xyz.gz", "", "1 1 1\n"),
        ("zeros.xyz.gz", "1 1 1\n", "0 0 0\n"),
        ("line.xyz.gz", "1 1 1\n", "1 "),
        ("cells.ptx.gz", "4000\n4000\n", "0 0 0\n"),
    ] {
        let head = if name.contains("ptx") { format!("{head}{PTX_HEAD}") } else { head.into() };
        let more = cloud_seeds::gzip(row.repeat((16 << 20) / row.len()).as_bytes());
        let file = [cloud_seeds::gzip(head.as_bytes()), more.repeat(8)].concat();
        judge_made(judge, name, &format!("bomb {name}"), file);
    }
    // LZF: a zero, and then 264 more in each three bytes.
    let unpacked = 12 * 330_000u32;
    let count = (unpacked - 1) / 264;
    let rest = (unpacked - 1) % 264;
    let mut lzf = [vec![0, 0], [0xe0, 255, 0].repeat(count as usize)].concat();
    lzf.extend([0xe0, (rest - 9) as u8, 0]);
    let sizes = [lzf.len() as u32, unpacked].map(u32::to_le_bytes).concat();
    let head = pcd("F", 4, "binary_compressed", 1000, 330);
    judge_made(judge, "bomb.pcd", "bomb of LZF", [head.as_bytes(), &sizes, &lzf].concat());
}

fn collected(judge: &mut Judge) {
    let Some(folder) = support::scans() else {
        eprintln!("SKIPPED: the collected scans (../../shared/scans) are not there");
        return;
    };
    let kinds = ["bad", "e57", "las", "laz", "pcd", "ply", "pts", "ptx", "xyz"];
    let lists = kinds.map(|kind| format!("clouds/{kind}"));
    for list in lists.iter().map(String::as_str).chain(["C"]) {
        for entry in fs::read_dir(folder.join(list)).expect("a folder of clouds") {
            let path = entry.expect("an entry").path();
            judge_path(judge, &path.display().to_string(), &path);
        }
    }
}
