//! Small sound files of every format of clouds, to be damaged: by the tests here,
//! and by the fuzzers (`formats/fuzz`), which begin from them.

use std::io::{Cursor, Write};
use std::path::Path;

use formats::points::ScanGrid;
use formats::{Points, Result, read_points_from};

#[path = "survey_seeds.rs"]
pub mod surveys;

/// Reads `content` and checks what a cloud promises.
///
/// # Panics
/// The promise is broken, or the reader panics.
pub fn read_soundly(name: &str, content: &[u8]) -> Result<Points> {
    let points = read_points_from(Path::new(name), Cursor::new(content.to_vec()))?;
    assert!(!points.is_empty());
    assert!(points.positions.iter().flatten().all(|x| x.is_finite()));
    assert!(points.origin.iter().all(|x| x.is_finite()));
    if let Some(normals) = &points.normals {
        assert_eq!(normals.len(), points.len());
    }
    let mut next = 0;
    for scan in &points.scans {
        assert_eq!(scan.points.start, next);
        next = scan.points.end;
        let Some(grid) = &scan.grid else { continue };
        assert!(grid.rows > 1 && grid.columns > 1);
        assert_eq!(grid.cells.len(), grid.rows * grid.columns);
        let mut cells = grid.cells.iter().filter(|&&cell| cell != ScanGrid::EMPTY);
        assert!(cells.all(|&cell| scan.points.contains(&(cell as usize))));
    }
    assert_eq!(next, points.len());
    Ok(points)
}

/// A file: its name, and what it holds.
pub type Seed = (&'static str, Vec<u8>);

/// Every seed. Each can be read.
pub fn all() -> Vec<Seed> {
    let mut seeds = vec![
        ("spaces.xyz", SPACES.into()),
        ("commas.csv", COMMAS.replace('\n', "\r\n").into()),
        ("decimal.txt", DECIMAL.into()),
        ("old.asc", SPACES.replace('\n', "\r").into()),
        ("blocks.pts", BLOCKS.into()),
        ("two.ptx", PTX.into()),
        ("range.ply", RANGE.into()),
        ("little.ply", binary_ply(false)),
        ("big.ply", binary_ply(true)),
        ("ascii.pcd", pcd("ascii", ASCII_PCD.as_bytes())),
        ("binary.pcd", pcd("binary", &records())),
        ("packed.pcd", pcd("binary_compressed", &packed(&columns()))),
        ("two.e57", surveys::e57()),
        ("one.las", surveys::las(1, false)),
        ("six.las", surveys::las(6, false)),
        ("five.laz", surveys::las(5, true)),
        ("eight.laz", surveys::las(8, true)),
    ];
    let zipped = [
        ("spaces.xyz.gz", SPACES.into()),
        ("two.ptx.gz", PTX.into()),
        ("packed.pcd.gz", pcd("binary_compressed", &packed(&columns()))),
    ];
    seeds.extend(zipped.map(|(name, content): (_, Vec<u8>)| (name, gzip(&content))));
    seeds
}

pub fn gzip(content: &[u8]) -> Vec<u8> {
    let mut zip = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    zip.write_all(content).expect("zipped");
    zip.finish().expect("zipped")
}

const SPACES: &str = "# made by hand\n0.5 0.25 1\n.5 1. 2e0\n\n1 2 3\nnan 1 1\n4 5 6\n";

const COMMAS: &str = "\u{feff}id,X,Y,Z [m],nx,ny,nz\n1,0.5,0.25,1,0,0,1\n2,1,2,3,0,1,0\n";

const DECIMAL: &str = "x;y;z\n0,5;0,25;1,0\n1,5;2,25;3,0\n-1;2;1,25e1\n";

const BLOCKS: &str = "2\n0.5 0.25 1 -1613 52 70 64\n1 2 3 -1998 58 76 67\n1\n4 5 6 0 1 2 3\n";

const PTX: &str = "2\n3\n600000 800000 400\n0 1 0\n-1 0 0\n0 0 1\n0 1 0 0\n-1 0 0 0\n0 0 1 0\n\
    600000 800000 400 1\n1 0 0 0.5\n1 1 0 0.25\n0 0 0 0.5\n2 0 0 0.5\n2 1 0 0.5\n2 2 .5 0.5\n\
    1\n2\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n\
    600001 800000 400 0.5 1 2 3\n600000 800001 400 0.5 1 2 3\n";

const RANGE: &str = "ply\nformat ascii 1.0\nobj_info num_cols 3\nobj_info num_rows 2\n\
    element vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
    element range_grid 6\nproperty list uchar int vertex_indices\nend_header\n\
    0.5 0.25 1\n1 2 3\nnan 0 0\n4 5 6\n1 0\n0\n1 1\n1 2\n1 3\n0\n";

fn binary_ply(big: bool) -> Vec<u8> {
    let name = if big { "big" } else { "little" };
    let head = format!(
        "ply\nformat binary_{name}_endian 1.0\nelement vertex 3\nproperty double x\n\
         property float y\nproperty short z\nproperty uchar red\nproperty uchar green\n\
         property uchar blue\nproperty float nx\nproperty float ny\nproperty float nz\n\
         element face 0\nproperty list uchar int vertex_indices\nend_header\n"
    );
    let mut file = head.into_bytes();
    let mut push = |mut bytes: Vec<u8>| {
        if big {
            bytes.reverse();
        }
        file.extend(bytes);
    };
    for (x, y, z) in [(0.5f64, 0.25f32, 1i16), (1.0, 2.0, 3), (4.0, 5.0, 6)] {
        push(x.to_le_bytes().to_vec());
        push(y.to_le_bytes().to_vec());
        push(z.to_le_bytes().to_vec());
        (0..3).for_each(|channel| push(vec![channel]));
        [0f32, 0.0, 1.0].iter().for_each(|n| push(n.to_le_bytes().to_vec()));
    }
    file
}

/// Six points in two rows, one of them not a number, with padding and normals.
pub fn pcd(encoding: &str, body: &[u8]) -> Vec<u8> {
    let head = format!(
        "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\n\
         FIELDS x y z _ rgb normal_x normal_y normal_z\nSIZE 4 8 2 1 4 4 4 4\n\
         TYPE F F I U F F F F\nCOUNT 1 1 1 2 1 1 1 1\nWIDTH 3\nHEIGHT 2\n\
         VIEWPOINT 0 0 -1 1 0 0 0\nPOINTS 6\nDATA {encoding}\n"
    );
    [head.as_bytes(), body].concat()
}

pub const ASCII_PCD: &str = "0.5 0.25 1 0 0 4.2e+06 0 0 1\n1 2 3 0 0 0 0 0 1\n\
    nan nan 0 0 0 0 nan nan nan\n4 5 6 0 0 0 0 1 0\n7 8 9 0 0 0 0 1 0\n1.5 1e1 -1 0 0 0 1 0 0\n";

/// The values of [`ASCII_PCD`] as bytes, field by field.
fn values() -> Vec<Vec<Vec<u8>>> {
    let xs = [0.5f32, 1.0, f32::NAN, 4.0, 7.0, 1.5];
    let ys = [0.25f64, 2.0, f64::NAN, 5.0, 8.0, 10.0];
    let zs = [1i16, 3, 0, 6, 9, -1];
    let normals = [
        [0f32, 0.0, 1.0],
        [0.0, 0.0, 1.0],
        [f32::NAN; 3],
        [0.0, 1.0, 0.0],
        [0.0, 1.0, 0.0],
        [1.0, 0.0, 0.0],
    ];
    let mut fields = vec![
        xs.map(|x| x.to_le_bytes().to_vec()).to_vec(),
        ys.map(|y| y.to_le_bytes().to_vec()).to_vec(),
        zs.map(|z| z.to_le_bytes().to_vec()).to_vec(),
        vec![vec![0; 2]; 6],
        vec![vec![7; 4]; 6],
    ];
    for axis in 0..3 {
        fields.push(normals.map(|n| n[axis].to_le_bytes().to_vec()).to_vec());
    }
    fields
}

pub fn records() -> Vec<u8> {
    let fields = values();
    (0..6).flat_map(|i| fields.iter().flat_map(move |field| field[i].clone())).collect()
}

pub fn columns() -> Vec<u8> {
    values().concat().concat()
}

/// The columns as PCL writes them: without the padding.
pub fn columns_without_padding() -> Vec<u8> {
    let mut fields = values();
    fields.remove(3);
    fields.concat().concat()
}

/// The sizes of a packed body and the body, packed by a simple search.
pub fn packed(bytes: &[u8]) -> Vec<u8> {
    let lzf = pack(bytes);
    let sizes = [lzf.len() as u32, bytes.len() as u32].map(u32::to_le_bytes);
    [&sizes.concat()[..], &lzf].concat()
}

fn pack(bytes: &[u8]) -> Vec<u8> {
    let mut out = Vec::new();
    let mut literal: Vec<u8> = Vec::new();
    let flush = |literal: &mut Vec<u8>, out: &mut Vec<u8>| {
        for piece in literal.chunks(32) {
            out.push(piece.len() as u8 - 1);
            out.extend(piece);
        }
        literal.clear();
    };
    let mut at = 0;
    while at < bytes.len() {
        let length = |back: usize| {
            let same = |i: &usize| bytes.get(at + i) == bytes.get(at + i - back);
            (0..264.min(bytes.len() - at)).take_while(same).count()
        };
        let best = (1..=at.min(8192)).max_by_key(|&back| length(back));
        match best.map(|back| (back - 1, length(back))) {
            Some((back, length)) if length >= 3 => {
                flush(&mut literal, &mut out);
                let count = length - 2;
                out.push((count.min(7) << 5 | back >> 8) as u8);
                if count >= 7 {
                    out.push((count - 7) as u8);
                }
                out.push(back as u8);
                at += length;
            }
            _ => {
                literal.push(bytes[at]);
                at += 1;
            }
        }
    }
    flush(&mut literal, &mut out);
    out
}
