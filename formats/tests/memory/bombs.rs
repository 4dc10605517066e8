//! Files that decompress to far more than their size.

use std::io::{Cursor, Write as _};

use crate::support::gzip;
use crate::{Judge, seeds};

pub fn judge(judge: &mut Judge) {
    let mut huge = gzip(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let end = huge.len();
    // The length of the original content modulo 2^32.
    huge[end - 4..].fill(0xff);
    judge.judge_made("size.obj.gz", "gzip with a false size", huge);
    let stl = [&[0; 80][..], &[0xff; 4]].concat();
    let list = "property list int int vertex_indices\nend_header\n";
    let strip = format!("ply\nformat binary_little_endian 1.0\nelement tristrips 1\n{list}");
    let strip = [strip.as_bytes(), b"\xff\xff\xff\x7f"].concat();
    let rows = "element vertex 4000000000\nproperty float x\nproperty float y\nproperty float z\n";
    let rows = format!("ply\nformat binary_little_endian 1.0\n{rows}end_header\n");
    let gltf = br#"{"asset":{"version":"2.0"},"nodes":["#;
    let bombs: [(&str, &[u8], &[u8]); 11] = [
        ("zeros.gz", b"", b"\0"),
        ("line.obj.gz", b"", b" "),
        ("face.obj.gz", b"f", b" 1"),
        ("points.obj.gz", b"", b"v 1 1 1\n"),
        ("faces.obj.gz", b"v 1 1 1\n", b"f 1 1 1\n"),
        ("header.ply.gz", b"ply\nformat ascii 1.0\ncomment ", b" "),
        ("strip.ply.gz", &strip, b"\0"),
        ("points.ply.gz", rows.as_bytes(), b"\0"),
        ("records.stl.gz", &stl, b"\0"),
        ("spaces.gltf.gz", b"{", b" "),
        ("nodes.gltf.gz", gltf, b"{},"),
    ];
    for (name, head, piece) in bombs {
        let more = gzip(&piece.repeat((16 << 20) / piece.len()));
        let file = [gzip(head), more.repeat(8)].concat();
        judge.judge_made(name, &format!("bomb {name}"), file);
    }
    threemf(judge);
}

/// 3MF files whose model unpacks to 64 MB.
fn threemf(judge: &mut Judge) {
    let (start, end) = seeds::MODEL.split_once("<vertex ").expect("a vertex");
    for piece in ["<vertex x=\"0\" y=\"0\" z=\"0\"/>", " ", "<a/>", "<!---->"] {
        let text = format!("{start}{}<vertex {end}", piece.repeat((64 << 20) / piece.len()));
        let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
        for (name, content) in
            [("_rels/.rels", seeds::RELATIONSHIPS), ("3D/3dmodel.model", text.as_str())]
        {
            let options = zip::write::SimpleFileOptions::default();
            archive.start_file(name, options).expect("an entry");
            archive.write_all(content.as_bytes()).expect("an entry");
        }
        let file = archive.finish().expect("an archive").into_inner();
        judge.judge_made("bomb.3mf", &format!("bomb of {piece:?}"), file);
    }
}
