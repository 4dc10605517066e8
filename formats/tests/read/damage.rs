//! Binary files that a program for text has damaged, and STL files whose length does not agree with
//! their number of triangles.

use formats::Location;

use crate::seeds;
use crate::support::{gzip, polygons, refusal, soup};

/// Triangles with negative numbers. Each of them has a line feed.
fn stl(count: u32, triangles: u16) -> Vec<u8> {
    let mut file = [&[b' '; 80][..], &count.to_le_bytes()].concat();
    for i in 0..triangles {
        file.extend([0; 12]);
        for v in [0., 0., 0., -1.5, 0., 0., 0., 1., f32::from(i)] {
            file.extend(v.to_le_bytes());
        }
        file.extend(b"\n\0");
    }
    file
}

fn with_returns(file: &[u8]) -> Vec<u8> {
    file.iter().flat_map(|&b| if b == b'\n' { vec![13, b] } else { vec![b] }).collect()
}

fn as_latin_1(file: &[u8]) -> Vec<u8> {
    file.iter().map(|&b| char::from(b)).collect::<String>().into()
}

fn as_utf_8(file: &[u8]) -> Vec<u8> {
    String::from_utf8_lossy(file).into_owned().into()
}

#[test]
fn stl_that_was_converted_is_refused_by_cause() {
    // The additional bytes for 50 line feeds are exactly one record.
    for triangles in [1, 2, 3, 50, 200] {
        let good = stl(triangles.into(), triangles);
        assert_eq!(polygons(&soup("good.stl", &good)).len(), usize::from(triangles));
        for (damaged, word) in [
            (with_returns(&good), "carriage returns"),
            (as_latin_1(&good), "converted to UTF-8"),
            (as_utf_8(&good), "converted to UTF-8"),
        ] {
            for file in [gzip(&damaged), damaged] {
                let error = refusal("sent.stl", file, word);
                assert!(error.help.contains("as a binary file"), "{}", error.help);
            }
        }
    }
}

#[test]
fn ply_that_was_converted_is_refused_by_cause() {
    let head = "ply\r\nformat binary_little_endian 1.0\r\nelement vertex 9\r\nproperty float x\r\n\
                property float y\r\nproperty float z\r\nelement face 1\r\n\
                property list uchar int vertex_indices\r\nend_header\r\n";
    let mut ply = head.as_bytes().to_vec();
    (0..27).for_each(|i| ply.extend(if i < 9 { -1.5 } else { 8.625f32 }.to_le_bytes()));
    ply.extend([3, 10, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0]);
    refusal("sent.ply", as_utf_8(&ply), "its bytes were converted to UTF-8 text");
    refusal("sent.ply", &ply, "vertex 10, but only 9");
}

#[test]
fn glb_that_was_converted_is_refused_by_cause() {
    let (_, mut file) =
        seeds::all().into_iter().find(|(name, _)| *name == "nodes.glb").expect("one");
    // The positions are 48 of the last 64 bytes.
    let at = file.len() - 64;
    file[at..at + 48].copy_from_slice(&b"\0\0\x80\xbf".repeat(12));
    soup("good.glb", &file);
    refusal("sent.glb", as_utf_8(&file), "because its bytes were converted to UTF-8 text");
    file[at..at + 48].copy_from_slice(&b"\0\0\n\x40".repeat(12));
    // Line feeds of the JSON do not count.
    file[..at].iter_mut().filter(|b| **b == b'\n').for_each(|b| *b = b' ');
    soup("good.glb", &file);
    refusal("sent.glb", with_returns(&file), "additional carriage returns");
}

#[test]
fn gzip_that_was_converted_is_refused_by_cause() {
    let zip = gzip(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let error = refusal("sent.obj.gz", as_utf_8(&zip), "converted to text");
    assert!(error.help.contains("as a binary file"));
}

#[test]
fn stl_with_too_small_a_count_loses_nothing() {
    for (count, triangles) in [(0, 1), (0, 3), (1, 2), (5, 6), (2, 200)] {
        let declared = formats::words::plural(count, "triangle");
        let word = format!("declares {declared}, but its length is that of {triangles}");
        for file in [stl(count, triangles), gzip(&stl(count, triangles))] {
            let error = refusal("count.stl", file, &word);
            assert_eq!(error.place, Some(Location::Byte(80)));
        }
    }
    // Two files in one.
    let two = [stl(2, 2), stl(3, 3)].concat();
    let error = refusal("two.stl", two, "has 234 bytes after the 2 triangles");
    assert!(error.help.contains("several files"));
}

#[test]
fn what_may_follow_an_stl() {
    let text = "made by hand\r\n".repeat(25);
    for more in [&b"\0"[..], &[0; 50], &[0; 9999], b"\xff\x7f\0\0", text.as_bytes(), &[7; 49]] {
        let file = [&stl(2, 2)[..], more].concat();
        assert_eq!(polygons(&soup("more.stl", file)).len(), 2, "{more:?}");
    }
    refusal("more.stl", [&stl(2, 2)[..], &[7; 51]].concat(), "has 51 bytes after");
}
