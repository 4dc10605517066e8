//! Small valid files of every format, which the tests here and the fuzzers (`formats/fuzz`) damage.

use std::io::{Cursor, Write};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use formats::scene::{FormId, NodeContent, NodeId};
use formats::{Result, Scene, Soup, read_scene_from};

/// Reads `content` and checks what a scene and its soup promise.
///
/// # Panics
///
/// The scene or the soup breaks its promise, or the reader panics.
pub fn read_soundly(name: &str, content: &[u8]) -> Result<Soup> {
    let cursor = Cursor::new(content.to_vec());
    let scene = read_scene_from(Path::new(name), cursor, None)?;
    check_scene(&scene);
    let soup = scene.into_soup()?;
    let count = soup.points.len();
    for polygon in soup.polygons.iter() {
        assert!(polygon.len() >= 3, "a polygon of {} corners", polygon.len());
        assert!(polygon.iter().all(|&c| (c as usize) < count), "{polygon:?} of {count} points");
    }
    Ok(soup)
}

fn check_scene(scene: &Scene) {
    assert!(scene.place_count() > 0, "no places");
    for (number, node) in scene.nodes().iter().enumerate() {
        assert!(
            node.parent.is_none_or(|NodeId(parent)| parent < number),
            "a child before its parent"
        );
        if let NodeContent::Form(FormId(form)) = node.content {
            assert!(scene.forms()[form].mesh.0 < scene.meshes().len());
        }
        let axes = node.placement.axes;
        for (i, j) in (0..3).flat_map(|i| (0..=i).map(move |j| (i, j))) {
            let product: f64 = (0..3).map(|k| axes[i][k] * axes[j][k]).sum();
            assert!((product - f64::from(i == j)).abs() < 1e-9, "no rotation: {axes:?}");
        }
    }
    for mesh in scene.meshes() {
        let count = mesh.soup.polygons.len();
        let ends = mesh.groups.iter().chain(mesh.colours.iter()).map(|(run, _)| run.end);
        assert!(ends.max().unwrap_or(0) <= count, "a run beyond {count} polygons");
    }
}

/// The same, but a panic becomes an error with its message.
pub fn survive(name: &str, content: &[u8]) -> std::result::Result<Result<Soup>, String> {
    let read = catch_unwind(AssertUnwindSafe(|| read_soundly(name, content)));
    read.map_err(|_| format!("{name}: {}", content.escape_ascii()))
}

/// A file: its name and its content.
pub type Seed = (&'static str, Vec<u8>);

/// All seeds. Each of them can be read.
pub fn all() -> Vec<Seed> {
    let mut seeds = vec![
        ("rows.ply", ascii_ply()),
        ("strip.ply", STRIP.into()),
        ("faces_first.ply", FACES_FIRST.replace('\n', "\r\n").into()),
        ("little.ply", binary_ply(false)),
        ("big.ply", binary_ply(true)),
        ("words.obj", OBJ.into()),
        ("back.obj", BACK.replace('\n', "\r").into()),
        ("faces.off", OFF.into()),
        ("solids.stl", ascii_stl()),
        ("records.stl", binary_stl()),
        ("nodes.gltf", gltf()),
        ("packed.gltf", PACKED.into()),
        ("nodes.glb", glb(GLTF)),
        ("parts.3mf", threemf(&[("3D/3dmodel.model", MODEL), ("3D/b.model", PART)])),
    ];
    let zipped = [
        ("rows.ply.gz", ascii_ply()),
        ("little.ply.gz", binary_ply(false)),
        ("words.obj.gz", OBJ.repeat(20).into()),
        ("solids.stl.gz", ascii_stl()),
        ("nodes.gltf.gz", gltf()),
        ("nodes.glb.gz", glb(GLTF)),
    ];
    seeds.extend(zipped.map(|(name, content)| (name, gzip(&content))));
    let (head, rest) = OBJ.split_at(20);
    seeds.push(("members.obj.gz", [gzip(head.as_bytes()), gzip(rest.as_bytes())].concat()));
    seeds
}

pub fn gzip(content: &[u8]) -> Vec<u8> {
    let mut zip = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    zip.write_all(content).expect("zipped");
    zip.finish().expect("zipped")
}

const PLY: &str = "comment a\nelement camera 1\nproperty float f\nproperty list uchar short l\n\
    element vertex 4\nproperty float x\nproperty short y\nproperty double z\n\
    element face 2\nproperty uchar c\nproperty list uchar int vertex_indices\n\
    element tristrips 1\nproperty list int int vertex_indices\nend_header\n";

fn ascii_ply() -> Vec<u8> {
    let body =
        "0.5 2 7 8\n0 0 0\n1 0 .5\n1. 1 nan\n0 1 1e3\n9 3 0 1 2\n9 4 0 1 2 3\n5 0 1 2 -1 3\n";
    format!("ply\nformat ascii 1.0\n{PLY}{body}").into()
}

const STRIP: &str = "ply\nformat ascii 1.0\nobj_info b\nelement vertex 4\nproperty double x\n\
    property double y\nproperty double z\nelement tristrips 1\n\
    property list uint uint8 vertex_index\nend_header\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n4\n0 1 2\n3\n";

const FACES_FIRST: &str = "ply\nformat ascii 1.0\nelement face 3\nproperty list ushort uint32 \
    vertex_index\nproperty list uchar float uv\nelement vertex 3\nproperty int8 x\nproperty \
    uint16 y\nproperty int z\nend_header\n3 0 1 2 1 .5\n2 0 1 0\n0 0\n0 0 0\n1 0 0\n0 1 -1\n";

/// The mesh of the ASCII file in either byte order.
fn binary_ply(big: bool) -> Vec<u8> {
    let order = |mut bytes: Vec<u8>| {
        if big {
            bytes.reverse();
        }
        bytes
    };
    let int = |i: i32| order(i.to_le_bytes().to_vec());
    let name = if big { "big" } else { "little" };
    let mut file = format!("ply\nformat binary_{name}_endian 1.0\n{PLY}").into_bytes();
    file.extend([0, 0, 0, 0, 1, 7, 0]);
    for i in 0..4u8 {
        file.extend(order(vec![0, 0, i, 0x40]));
        file.extend(order(vec![i, 0]));
        file.extend(order(vec![0, 0, 0, 0, 0, 0, i, 0x40]));
    }
    for face in [[0, 1, 2], [1, 2, 3]] {
        file.extend([9, 3]);
        face.iter().for_each(|&i| file.extend(int(i)));
    }
    [5, 0, 1, 2, 3, -1].iter().for_each(|&i| file.extend(int(i)));
    file
}

const OBJ: &str = "# a\nv 0 0 0\nv 1 0 0 1\nv 1 1 0 1 0 0\nv .5 1e1 nan\ng a\nvt 0 0\nvn 0 0 1\n\
    usemtl b\nf 1/1/1 2//1 \\\n3\nf -4 -2 -1\nf 1 2 3 4\nl 1 2\n";

const BACK: &str = "f 1 2 3\nv 0 0 0\nv 1. +.5 -1.5e-3 # b\n\tv  1.#IND inf 0\no c\ns off\n\
    f -1// -2/1 -3\nf 1 2\np 1\nf 3 2 1 3 2 1";

const OFF: &str = "CNOFF # a\n4 3 0\n0 0 0 0 0 1 255 0 0\n1 0 0\n1 1 .5\n0 1e1 nan\n\
    3 0 1 2\n4 0 1 2 3 0.5 0.5 0.5\n2 0 1\n";

fn ascii_stl() -> Vec<u8> {
    let facet = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 .5 0\nvertex 0 1 1e1\n\
                 endloop\nendfacet\n";
    format!("solid a\n{facet}endsolid a\nSOLID b\n{facet}endsolid\n").into()
}

fn binary_stl() -> Vec<u8> {
    let mut file = vec![b' '; 80];
    file.extend(3u32.to_le_bytes());
    file.extend((0..150).map(|i| i as u8));
    file
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

/// Quantized positions, fans and strips, data in base64, and an accessor of zeros.
const PACKED: &str = r#"{"asset":{"version":"2.0"},"nodes":[{"mesh":0,"rotation":[0,0,1,0],
    "translation":[1,2,3]}],"extensionsRequired":["KHR_mesh_quantization"],
    "extensionsUsed":["KHR_mesh_quantization"],"meshes":[{"primitives":[{"attributes":
    {"POSITION":0},"indices":1,"mode":6},{"attributes":{"POSITION":2},"indices":1,
    "mode":5}]}],"buffers":[{"byteLength":20,"uri":
    "data:application/octet-stream;base64,AAAAAH8AAAB/fwAAAH8AAAABAgM="}],"bufferViews":
    [{"buffer":0,"byteLength":16,"byteStride":4},{"buffer":0,"byteOffset":16,
    "byteLength":4},{"buffer":0,"byteLength":12}],"accessors":[{"bufferView":0,"componentType":5120,"normalized":true,
    "count":4,"type":"VEC3"},{"bufferView":1,"componentType":5121,"count":4,"type":
    "SCALAR"},{"componentType":5122,"count":4,"type":"VEC3","sparse":{"count":2,"indices":
    {"bufferView":1,"byteOffset":2,"componentType":5121},"values":{"bufferView":2}}}]}"#;

/// The relationships of a package with its model.
pub const RELATIONSHIPS: &str = r#"<?xml version="1.0"?><Relationships
    xmlns="http://schemas.openxmlformats.org/package/2006/relationships"><Relationship Id="r"
    Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel" Target="/3D/3dmodel.model"/>
    </Relationships>"#;

/// A model with colours, components, another part, a mirrored use and what is not read.
pub const MODEL: &str = r##"<?xml version="1.0" encoding="UTF-8"?><model unit="centimeter"
    xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02" xmlns:q="http://schemas.microsoft.com/3dmanufacturing/production/2015/06"
    xmlns:m="http://schemas.microsoft.com/3dmanufacturing/material/2015/02" requiredextensions="q m">
    <metadata name="Title">a &amp; b</metadata><resources><basematerials id="1"><base name="r"
    displaycolor="#FF0000FF"/><base name="b" displaycolor="#0000ff"/></basematerials>
    <m:colorgroup id="2"><m:color color="#10203040"/></m:colorgroup><m:compositematerials id="3" matid="1"
    matindices="0 1"><m:composite values="0.5 0.5"/></m:compositematerials><m:multiproperties id="4"
    pids="3 2"><m:multi pindices="0 0"/></m:multiproperties>
    <object id="5" name="tet &#x41;" pid="1" pindex="0"><mesh><vertices><vertex x="0" y="0" z="0"/>
    <vertex x="1e0" y="0" z="0"/><vertex x="0" y=".5" z="0"/><vertex x="0" y="0" z="-3"/></vertices>
    <triangles><triangle v1="0" v2="1" v3="2"/><triangle v1="0" v2="3" v3="1" pid="1" p1="1"/>
    <triangle v1="1" v2="3" v3="2" pid="2" p1="0"/><triangle v1="2" v2="3" v3="0" pid="4" p1="0"/></triangles></mesh></object>
    <object id="6" type="support"><mesh><vertices/><triangles/></mesh></object>
    <object id="7" partnumber="pair"><components><component objectid="5"/><component objectid="5"
    transform="-1 0 0 0 1 0 0 0 1 2 0 0"/><component objectid="9" q:path="/3D/b.model"/></components></object>
    </resources><build><item objectid="7" partnumber="left"/><item objectid="5" transform="2 0 0 0 2 0 0 0 2 0 0 7"/>
    <item objectid="6"/></build></model>"##;

/// Another part, in another unit.
pub const PART: &str = r#"<p:model unit="millimeter" xmlns:p="http://schemas.microsoft.com/3dmanufacturing/core/2015/02"><p:resources>
    <p:object id="9"><p:mesh><p:vertices><p:vertex x="0" y="0" z="0"/><p:vertex x="10" y="0" z="0"/>
    <p:vertex x="0" y="10" z="0"/></p:vertices><p:triangles><p:triangle v1="0" v2="1" v3="2"/>
    </p:triangles></p:mesh></p:object></p:resources><p:build/></p:model>"#;

/// A 3MF file with these parts.
pub fn threemf(parts: &[(&str, &str)]) -> Vec<u8> {
    let parts: Vec<_> = parts.iter().map(|(name, text)| (*name, text.as_bytes())).collect();
    zip(&[&[("_rels/.rels", RELATIONSHIPS.as_bytes())], parts.as_slice()].concat())
}

/// A ZIP archive of stored files.
pub fn zip(files: &[(&str, &[u8])]) -> Vec<u8> {
    let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
    let stored =
        zip::write::SimpleFileOptions::default().compression_method(zip::CompressionMethod::Stored);
    for (name, content) in files {
        archive.start_file(*name, stored).expect("an entry");
        archive.write_all(content).expect("an entry");
    }
    archive.finish().expect("an archive").into_inner()
}

fn buffer() -> Vec<u8> {
    let mut bytes = vec![0; 48];
    bytes[15] = 0x41;
    bytes[31] = 0x41;
    [0u16, 1, 2, 0, 2, 3].iter().for_each(|i| bytes.extend(i.to_le_bytes()));
    bytes.extend([2, 0, 0, 0]);
    bytes
}

fn gltf() -> Vec<u8> {
    let data: String = buffer().iter().map(|b| format!("%{b:02x}")).collect();
    GLTF.replace("URI", &format!(r#","uri":"data:,{data}""#)).into()
}

fn glb(json: &str) -> Vec<u8> {
    let json = json.replace("URI", "");
    let json = format!("{json:<width$}", width = json.len().next_multiple_of(4));
    let length = 28 + json.len() + 64;
    let mut file = b"glTF\x02\0\0\0".to_vec();
    file.extend((length as u32).to_le_bytes());
    file.extend((json.len() as u32).to_le_bytes());
    file.extend(b"JSON");
    file.extend(json.as_bytes());
    file.extend(b"\x40\0\0\0BIN\0");
    file.extend(buffer());
    file
}
