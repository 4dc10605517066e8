//! The chunks of a binary file.

use formats::Location;

use super::{SQUARE, data_uri, glb, json, square_bytes, square_glb};
use crate::support::{polygons, read, refusal, refused, soup};

/// A file of `chunks` whose header declares `length` additional bytes.
fn file(length: usize, chunks: &[(&[u8; 4], &[u8])]) -> Vec<u8> {
    let mut body = Vec::new();
    for (kind, data) in chunks {
        body.extend((data.len() as u32).to_le_bytes());
        body.extend(*kind);
        body.extend(*data);
    }
    let total = (12 + body.len() + length) as u32;
    [b"glTF\x02\0\0\0", &total.to_le_bytes()[..], &body].concat()
}

/// The JSON of the square for a binary file, padded with blanks.
fn inner() -> Vec<u8> {
    let text = json(&[(r#", "uri": "a%20b/square.bin""#, "")]);
    format!("{text:<width$}", width = text.len().next_multiple_of(4)).into()
}

#[track_caller]
fn check(file: Vec<u8>) {
    let soup = soup("square.glb", file);
    assert_eq!(soup.points, SQUARE);
    assert_eq!(polygons(&soup), [[0, 1, 2], [0, 2, 3]]);
}

#[test]
fn binary_chunk_may_be_absent() {
    let uri = data_uri(&square_bytes());
    let embedded = json(&[("a%20b/square.bin", &uri)]);
    check(file(0, &[(b"JSON", embedded.as_bytes())]));
    // An empty chunk is not a binary chunk, either.
    check(file(0, &[(b"JSON", embedded.as_bytes()), (b"BIN\0", b"")]));
    let error = refusal("none.glb", file(0, &[(b"JSON", &inner())]), "buffer that has no data");
    assert_eq!(error.place, Some(Location::Element("buffer", 0)));
    let error = refusal("none.glb", glb(&String::from_utf8_lossy(&inner()), b""), "holds 0 of 60");
    assert_eq!(error.place, Some(Location::Element("buffer", 0)));
}

#[test]
fn padding_is_left_alone() {
    let padded = [&square_bytes()[..], &[0; 3]].concat();
    check(file(0, &[(b"JSON", &inner()), (b"BIN\0", &padded)]));
    // Some writers do not pad at all.
    let bare = inner().trim_ascii().to_vec();
    for pad in [0, 1, 2] {
        let bare = [&bare[..], &[b'\n'].repeat(pad)].concat();
        check(file(0, &[(b"JSON", &bare), (b"BIN\0", &square_bytes())]));
    }
}

#[test]
fn chunks_of_other_kinds_are_passed_over() {
    let chunks: [(&[u8; 4], &[u8]); 4] =
        [(b"JSON", &inner()), (b"BIN\0", &square_bytes()), (b"more", b"1234"), (b"BIN\0", b"5678")];
    check(file(0, &chunks));
}

/// "Client implementations MUST ignore chunks with unknown types."
#[test]
fn unknown_chunk_without_a_binary_one_is_passed_over() {
    let embedded = json(&[("a%20b/square.bin", &data_uri(&square_bytes()))]);
    check(file(0, &[(b"JSON", embedded.as_bytes()), (b"more", b"1234")]));
}

#[test]
fn chunks_in_the_wrong_order_are_refused() {
    let (json, bytes) = (inner(), square_bytes());
    for chunks in [
        &[(b"BIN\0", &bytes[..]), (b"JSON", &json)][..],
        &[(b"BIN\0", &bytes)],
        &[(b"JSON", &json), (b"JSON", &json)],
        &[(b"more", &bytes), (b"JSON", &json)],
    ] {
        refusal("order.glb", file(0, chunks), "not a valid glTF 2.0 file");
    }
}

#[test]
fn wrong_chunk_lengths_are_refused() {
    let good = square_glb(&[]);
    let json_length = u32::from_le_bytes([good[12], good[13], good[14], good[15]]);
    let binary_length = 20 + json_length as usize;
    for (at, length, word) in [
        (12, 0, "not a valid glTF 2.0 file"),
        (12, 4, "not a valid glTF 2.0 file"),
        (12, json_length - 4, "not a valid glTF 2.0 file"),
        (12, json_length + 4, "not a valid glTF 2.0 file"),
        (12, 1 << 31, "length exceeds"),
        (binary_length, 0, "holds 0 of 60"),
        (binary_length, 56, "holds 56 of 60"),
        (binary_length, 64, "length exceeds"),
        (binary_length, u32::MAX, "length exceeds"),
    ] {
        let mut file = good.clone();
        file[at..at + 4].copy_from_slice(&length.to_le_bytes());
        refusal("chunk.glb", file, word);
    }
}

#[test]
fn headers_alone_are_refused() {
    for length in [12u32, 13, 19] {
        let file = [b"glTF\x02\0\0\0", &length.to_le_bytes()[..], &[b' '; 8]].concat();
        for end in 12..length.min(20) as usize {
            refusal("head.glb", &file[..end], "");
        }
        refusal("head.glb", file, "not a complete GLB file");
    }
    let empty = file(0, &[(b"JSON", b"")]);
    refusal("empty.glb", empty, "not a valid glTF 2.0 file");
    refusal("broken.glb", file(0, &[(b"JSON", b"{]  ")]), "not a valid glTF 2.0 file");
    // Without "glTF" only the name tells the format.
    refusal("zeros.glb", [0; 12], "not a valid glTF 2.0 file");
    refusal("zeros", [0; 12], "not in a known mesh format");
}

#[test]
fn total_lengths_of_less_than_a_header_are_told() {
    for length in 0..20u8 {
        let mut file = square_glb(&[]);
        file[8..12].copy_from_slice(&[length, 0, 0, 0]);
        refusal("short.glb", file, "not a complete GLB file");
    }
}

/// Its header had five words, and its JSON was not in a chunk.
#[test]
fn version_1_is_refused_by_name() {
    let head = b"glTF\x01\0\0\0\x28\0\0\0\x14\0\0\0\0\0\0\0";
    let error = refusal("old.glb", [&head[..], b"{\"accessors\": {}}   "].concat(), "version");
    assert!(error.help.contains("glTF 2.0"), "{}", error.help);
}

#[test]
fn binaries_damaged_as_text_are_refused() {
    let good = square_glb(&[]);
    let mut light = good.clone();
    light.retain(|&b| b != b'\r');
    let lines = light.iter().flat_map(|&b| if b == b'\n' { vec![13, b] } else { vec![b] });
    refusal("lines.glb", lines.collect::<Vec<u8>>(), "");
    let mangled = String::from_utf8_lossy(&good).into_owned();
    refused(read("mangled.glb", mangled), "");
}

#[test]
fn unknown_chunks_before_the_binary_one_are_passed_over() {
    check(file(0, &[(b"JSON", &inner()), (b"more", b"1234"), (b"BIN\0", &square_bytes())]));
    let error = refusal("cut.glb", file(0, &[(b"JSON", &inner()), (b"more", b"")]), "no data");
    assert_eq!(error.place, Some(Location::Element("buffer", 0)));
}

#[test]
fn other_beginnings_are_told() {
    refusal("zeros.glb", [0; 12], "begins neither with \u{201c}glTF\u{201d}");
    refusal("words.gltf", "asset", "begins neither with");
    let mut file = square_glb(&[]);
    file[4] = 3;
    let error = refusal("new.glb", file, "of glTF version 3");
    assert!(error.help.contains("glTF 2.0"));
}
