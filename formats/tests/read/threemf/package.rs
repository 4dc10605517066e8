//! The archive, its relationships and its XML.

use super::model;
use crate::seeds::{RELATIONSHIPS, threemf, zip};
use crate::support::{refusal, soup};

/// A model of one tetrahedron.
fn tetrahedron() -> String {
    model("", r#"<object id="1">MESH</object>"#, r#"<item objectid="1"/>"#)
}

/// A file whose relationships are these.
fn related(relationships: &str) -> Vec<u8> {
    zip(&[
        ("_rels/.rels", relationships.as_bytes()),
        ("3D/3dmodel.model", tetrahedron().as_bytes()),
        ("3D/b.model", tetrahedron().as_bytes()),
    ])
}

#[test]
fn one_relationship_names_the_model() {
    assert_eq!(soup("a.3mf", related(RELATIONSHIPS)).polygons.len(), 4);
    // Names are compared without case and may be relative.
    let relative = RELATIONSHIPS.replace("/3D/3dmodel.model", "3d/3DMODEL.model");
    assert_eq!(soup("a.3mf", related(&relative)).polygons.len(), 4);
    for (target, word) in [
        ("/3D/absent.model", "no part 3d/absent.model"),
        ("/../../etc/passwd", "outside"),
        ("", "outside"),
        ("/", "outside"),
    ] {
        refusal("a.3mf", related(&RELATIONSHIPS.replace("/3D/3dmodel.model", target)), word);
    }
    let external = RELATIONSHIPS.replace("Target=", "TargetMode=\"External\" Target=");
    refusal("a.3mf", related(&external), "outside of it");
    let (start, rest) = RELATIONSHIPS.split_once("<Relationship ").expect("one");
    let second = rest.replace("3dmodel.model\"", "b.model\"");
    let second = second.split_once("/>").expect("one").0;
    let two = format!("{start}<Relationship {second}/><Relationship {rest}");
    refusal("a.3mf", related(&two), "several parts as its 3D model");
    refusal(
        "a.3mf",
        related(&RELATIONSHIPS.replace("2013/01/3dmodel\"", "other\"")),
        "no 3MF file",
    );
    refusal("a.3mf", zip(&[("3D/3dmodel.model", tetrahedron().as_bytes())]), "no 3MF file");
    let keys = RELATIONSHIPS.replace("2013/01/3dmodel\"", "2019/04/keystore\"");
    refusal("a.3mf", related(&keys), "encrypted");
}

#[test]
fn archives_are_checked() {
    let sound = threemf(&[("3D/3dmodel.model", &tetrahedron())]);
    refusal("a.3mf", &sound[..sound.len() - 30], "ZIP archive");
    // Two entries with names that differ in case only.
    let twice = threemf(&[("3D/3dmodel.model", &tetrahedron()), ("3d/3DModel.model", "<a/>")]);
    refusal("a.3mf", twice, "two parts of the name");
    // A changed digit is found by its checksum.
    let at = sound.windows(6).position(|w| w == b"y=\"2\" ").expect("a digit") + 3;
    let mut changed = sound.clone();
    changed[at] = b'5';
    refusal("a.3mf", changed, "");
    for at in 0..sound.len() {
        let cut = crate::seeds::survive("a.3mf", &sound[..at]).expect("no panic");
        assert!(cut.is_err());
    }
}

#[test]
fn xml_is_not_expanded() {
    let of = |text: &str| threemf(&[("3D/3dmodel.model", text)]);
    let plain = tetrahedron();
    refusal("a.3mf", of(&format!("<!DOCTYPE model [<!ENTITY a \"b\">]>{plain}")), "document type");
    let entity = plain.replace("<object id=\"1\">", "<object id=\"1\" name=\"&e;\">");
    refusal("a.3mf", of(&entity), "not sound XML");
    refusal("a.3mf", of(&plain.replace("</build>", "")), "not sound XML");
    refusal("a.3mf", of(plain.strip_suffix("</model>").expect("an end")), "cut short");
    refusal("a.3mf", of(&plain[..plain.len() - 3]), "not sound XML");
    refusal("a.3mf", of(&format!("{plain}{plain}")), "two root elements");
    refusal("a.3mf", of("<cake/>"), "no 3D model");
    refusal("a.3mf", of(""), "cut short");
    let deep = plain.replace("</resources>", &format!("{}</resources>", "<a>".repeat(100)));
    refusal("a.3mf", of(&deep), "64 deep");
    let attributes: String = (0..100).map(|i| format!(" a{i}=\"\"")).collect();
    let many = plain.replace("<object", &format!("<object{attributes}"));
    refusal("a.3mf", of(&many), "64 attributes");
    let prefix = plain.replace("<resources>", "<dcterms:created/><resources>");
    refusal("a.3mf", of(&prefix), "prefix dcterms without a namespace");
    let no_resources = plain.replace("resources>", "metadatagroup>");
    refusal("a.3mf", of(&no_resources), "without resources");
}

#[test]
fn packed_bombs_are_refused() {
    let deflated = |text: &[u8]| {
        use std::io::{Cursor, Write as _};
        let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
        let options = zip::write::SimpleFileOptions::default();
        for (name, content) in
            [("_rels/.rels", RELATIONSHIPS.as_bytes()), ("3D/3dmodel.model", text)]
        {
            archive.start_file(name, options).expect("an entry");
            archive.write_all(content).expect("an entry");
        }
        archive.finish().expect("an archive").into_inner()
    };
    let plain = tetrahedron();
    let (head, tail) = plain.split_once("<resources>").expect("resources");
    let spaces = [head.as_bytes(), &vec![b' '; 64 << 20], b"<resources>", tail.as_bytes()].concat();
    refusal("a.3mf", deflated(&spaces), "more than 4 MiB");
    let vertices = "<vertex x=\"0\" y=\"0\" z=\"0\"/>".repeat(4 << 20);
    let many = plain.replacen("<vertices>", &format!("<vertices>{vertices}"), 1);
    refusal("a.3mf", deflated(many.as_bytes()), "far more than the size");
    assert_eq!(soup("a.3mf", deflated(plain.as_bytes())).polygons.len(), 4);
}
