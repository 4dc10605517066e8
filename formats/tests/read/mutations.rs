//! Random damage: no reader may panic, whatever it makes of it.

use std::fs;
use std::panic::catch_unwind;

use formats::read_scan;

use crate::support::{case, gzip};

/// How often each file is damaged.
const ROUNDS: usize = 1500;

/// Marsaglia's xorshift64.
struct Random(u64);

impl Random {
    fn below(&mut self, end: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % end.max(1) as u64) as usize
    }
}

/// Bytes that mean something to some format.
const TELLING: &[u8] = b"\0\x01\x7f\x80\xff\n\r \t-+.0159eEvf/#\\\"{}[],:";

fn damage(file: &mut Vec<u8>, random: &mut Random) {
    for _ in 0..=random.below(4) {
        let at = random.below(file.len());
        let byte = TELLING[random.below(TELLING.len())];
        match (random.below(6), file.get_mut(at)) {
            (0, Some(old)) => *old ^= 1 << random.below(8),
            (1 | 2, Some(old)) => *old = byte,
            (3, Some(_)) => drop(file.remove(at)),
            (4, _) => file.insert(at, byte),
            (_, Some(_)) if random.below(4) == 0 => file.truncate(at),
            // A piece of the file once more, elsewhere.
            _ => {
                let end = file.len().min(at + random.below(24));
                let piece = file[at..end].to_vec();
                let to = random.below(file.len());
                file.splice(to..to, piece);
            }
        }
    }
}

#[track_caller]
fn survives(name: &str, good: &[u8]) {
    let case = case(name, good);
    read_scan(&case.path).unwrap_or_else(|e| panic!("{e}"));
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    for round in 0..ROUNDS {
        let mut file = good.to_vec();
        damage(&mut file, &mut random);
        fs::write(&case.path, &file).expect("written");
        let read = catch_unwind(|| read_scan(&case.path));
        let Ok(read) = read else { panic!("round {round} panics: {file:?}") };
        if let Ok(soup) = read {
            let count = soup.points.len();
            let in_range = |p: &[u32]| p.len() >= 3 && p.iter().all(|&c| (c as usize) < count);
            assert!(soup.polygons.iter().all(in_range), "round {round}: {file:?}");
        }
    }
}

const PLY: &str = "element camera 1\nproperty float f\nproperty list uchar short l\n\
    element vertex 4\nproperty float x\nproperty short y\nproperty double z\n\
    element face 2\nproperty uchar c\nproperty list uchar int vertex_indices\n\
    element tristrips 1\nproperty list int int vertex_indices\nend_header\n";

#[test]
fn ascii_ply() {
    let body =
        "0.5 2 7 8\n0 0 0\n1 0 .5\n1. 1 nan\n0 1 1e3\n9 3 0 1 2\n9 4 0 1 2 3\n5 0 1 2 -1 3\n";
    survives("a.ply", format!("ply\nformat ascii 1.0\n{PLY}{body}").as_bytes());
}

#[test]
fn binary_ply() {
    let head = format!("ply\nformat binary_little_endian 1.0\n{PLY}");
    let mut file = head.into_bytes();
    file.extend([0, 0, 0, 0, 1, 7, 0]);
    for i in 0..4u8 {
        file.extend([0, 0, i, 0x40, i, 0, 0, 0, 0, 0, 0, 0, i, 0x40]);
    }
    for face in [[0, 1, 2], [1, 2, 3i32]] {
        file.extend([9, 3]);
        face.iter().for_each(|i| file.extend(i.to_le_bytes()));
    }
    [4, 0, 1, 2, 3i32].iter().for_each(|i| file.extend(i.to_le_bytes()));
    survives("b.ply", &file);
}

#[test]
fn obj() {
    let text = "# a\nv 0 0 0\nv 1 0 0 1\nv 1 1 0 1 0 0\nv .5 1e1 nan\ng a\nvt 0 0\nvn 0 0 1\n\
                usemtl b\nf 1/1/1 2//1 \\\n3\nf -4 -2 -1\nf 1 2 3 4\nl 1 2\n";
    survives("a.obj", text.as_bytes());
}

#[test]
fn ascii_stl() {
    let facet = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 .5 0\nvertex 0 1 1e1\n\
                 endloop\nendfacet\n";
    let text = format!("solid a\n{facet}endsolid a\nsolid b\n{facet}endsolid\n");
    survives("a.stl", text.as_bytes());
}

#[test]
fn binary_stl() {
    let mut file = vec![b' '; 80];
    file.extend(3u32.to_le_bytes());
    file.extend((0..150).map(|i| i as u8));
    survives("b.stl", &file);
}

#[test]
fn gzipped() {
    let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n".repeat(20);
    survives("a.obj.gz", &gzip(text.as_bytes()));
}

const GLTF: &str = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],
    "nodes":[{"mesh":0,"scale":[1,2,-1],"children":[1]},{"mesh":0,"matrix":
    [1,0,0,0,0,1,0,0,0,0,1,0,5,6,7,1]}],"meshes":[{"primitives":[{"attributes":
    {"POSITION":0},"indices":1,"mode":4},{"attributes":{"POSITION":2},"mode":5}]}],
    "buffers":[{"byteLength":64URI}],"bufferViews":[{"buffer":0,"byteLength":48,
    "byteStride":12},{"buffer":0,"byteOffset":48,"byteLength":12},{"buffer":0,
    "byteOffset":60,"byteLength":4}],"accessors":[{"bufferView":0,"byteOffset":0,
    "componentType":5126,"count":4,"type":"VEC3"},{"bufferView":1,"componentType":
    5123,"count":6,"type":"SCALAR"},{"bufferView":0,"componentType":5126,"count":4,
    "type":"VEC3","sparse":{"count":1,"indices":{"bufferView":2,"componentType":5121},
    "values":{"bufferView":0,"byteOffset":12}}}]}"#;

fn buffer() -> Vec<u8> {
    let mut bytes = vec![0; 48];
    bytes[15] = 0x41;
    bytes[31] = 0x41;
    [0u16, 1, 2, 0, 2, 3].iter().for_each(|i| bytes.extend(i.to_le_bytes()));
    bytes.extend([2, 0, 0, 0]);
    bytes
}

#[test]
fn gltf() {
    let data: String = buffer().iter().map(|b| format!("%{b:02x}")).collect();
    let text = GLTF.replace("URI", &format!(r#","uri":"data:,{data}""#));
    survives("a.gltf", text.as_bytes());
}

#[test]
fn glb() {
    let json = GLTF.replace("URI", "");
    let json = format!("{json:<width$}", width = json.len().next_multiple_of(4));
    let length = 28 + json.len() + 64;
    let mut file = b"glTF\x02\0\0\0".to_vec();
    file.extend((length as u32).to_le_bytes());
    file.extend((json.len() as u32).to_le_bytes());
    file.extend(b"JSON");
    file.extend(json.as_bytes());
    file.extend(b"\x40\0\0\0BIN\0");
    file.extend(buffer());
    survives("b.glb", &file);
}
