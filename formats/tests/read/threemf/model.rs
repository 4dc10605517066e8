//! Objects, components, units, colours and what is left out.

use formats::{Format, LengthUnit};

use super::{TETRAHEDRON, file, model};
use crate::seeds::{MODEL, PART, threemf};
use crate::support::{case, refusal, scene, soup, tree};

const OBJECT: &str = r#"<object id="1">MESH</object>"#;
const ITEM: &str = r#"<item objectid="1"/>"#;

/// The notes of a scene in words.
fn notes(content: &[u8]) -> Vec<String> {
    scene("a.3mf", content).notes.iter().map(ToString::to_string).collect()
}

#[test]
fn objects_components_and_items_are_a_tree() {
    let content = threemf(&[("3D/3dmodel.model", MODEL), ("3D/b.model", PART)]);
    let scene = scene("a.bin", &content);
    let expected = [
        "0 left: group pair",
        "1 -: tet A None 4",
        "1 -: tet A None 4 stretched",
        "1 -: - None 1 stretched",
        "0 -: tet A None 4 stretched",
    ];
    assert_eq!(tree(&scene), expected);
    assert_eq!(scene.unit, Some(LengthUnit::Centimetre));
    assert_eq!(scene.notes.len(), 1);
    assert!(scene.notes[0].to_string().contains("1 object for supports"));
    assert_eq!(Format::of(&case("a.bin", &content).path).ok(), Some(Format::ThreeMf));
    let colours = &scene.meshes()[0].colours;
    let colours: Vec<_> = colours.iter().map(|(_, value)| colours.values()[value]).collect();
    let expected = [[255, 0, 0], [0, 0, 255], [16, 32, 48], [16, 32, 48]].map(Some);
    assert_eq!(colours, expected[..3]);
    // Ten millimetres of the other part are one centimetre, and the last item is twice as large.
    let soup = scene.into_soup().unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(soup.points[9], [1.0, 0.0, 0.0]);
    assert_eq!(soup.points[12], [2.0, 0.0, 7.0]);
    // The mirrored use has its triangles turned over.
    let polygons: Vec<_> = soup.polygons.iter().collect();
    assert_eq!((polygons[0], polygons[4]), (&[0, 1, 2][..], &[4, 6, 5][..]));
}

#[test]
fn units_are_those_of_the_model() {
    for (unit, expected) in [
        ("", LengthUnit::Millimetre),
        ("micron", LengthUnit::Micrometre),
        ("inch", LengthUnit::Inch),
        ("foot", LengthUnit::Foot),
        ("meter", LengthUnit::Metre),
    ] {
        let attribute = if unit.is_empty() { String::new() } else { format!("unit=\"{unit}\"") };
        let soup = soup("a.3mf", file(&attribute, OBJECT, ITEM));
        assert_eq!((soup.unit, soup.polygons.len()), (Some(expected), 4), "{unit}");
    }
    refusal("a.3mf", file("unit=\"parsec\"", OBJECT, ITEM), "parsec");
}

#[test]
fn names_are_unescaped_and_bounded() {
    let named = |name: &str| {
        let object = format!(r#"<object id="1" name="{name}">MESH</object>"#);
        tree(&scene("a.3mf", file("", &object, r#"<item objectid="1" partnumber="x&#10;y"/>"#)))
    };
    assert_eq!(named("a &amp; &quot;b&quot; &#x4e2d;"), ["0 x y: a & \"b\" \u{4e2d} None 4"]);
    assert_eq!(named(" "), ["0 x y: - None 4"]);
    assert!(named(&"n".repeat(1 << 20))[0].len() < 400);
}

#[test]
fn what_no_shape_needs_is_said() {
    let odd = |resources: &str, word: &str| {
        let notes = notes(&file("", resources, ITEM));
        assert!(notes.len() == 1 && notes[0].contains(word), "{notes:?}");
    };
    odd(
        r##"<m:colorgroup id="2"><m:color/></m:colorgroup><object id="1">MESH</object>"##,
        "colours without a value",
    );
    odd(
        r##"<m:colorgroup id="2"><m:color color="red"/></m:colorgroup><object id="1">MESH</object>"##,
        "colours that are none",
    );
    odd(
        r#"<m:texture2dgroup id="2" texid="9"/><object id="1">MESH</object>"#,
        "without their texture",
    );
    odd(r#"<object id="1" pid="7" pindex="0">MESH</object>"#, "properties that do not exist");
    odd(r#"<object id="1" pindex="0">MESH</object>"#, "half of a property");
    odd(r#"<odd/><object id="1">MESH</object>"#, "elements that the core specification");
    odd(&format!("{OBJECT}<object id=\"2\">MESH</object>"), "the build does not use");
    let unread = r#"<object id="1" xmlns:s="http://schemas.microsoft.com/3dmanufacturing/slice/2015/07" s:slicestackid="3">MESH</object>"#;
    odd(unread, "slices of 1 object");
}

#[test]
fn supports_and_other_objects_are_left_out() {
    let of = |kind: &str| format!(r#"<object id="2" type="{kind}">MESH</object>"#);
    for kind in ["support", "solidsupport", "other"] {
        let content = file(
            "",
            &(OBJECT.to_owned() + &of(kind)),
            r#"<item objectid="1"/><item objectid="2"/>"#,
        );
        assert_eq!(soup("a.3mf", &content).polygons.len(), 4);
        assert!(notes(&content)[0].contains("left out"), "{kind}");
        refusal("a.3mf", file("", &of(kind), r#"<item objectid="2"/>"#), "only supports");
    }
    let surface = file("", &of("surface"), r#"<item objectid="2"/>"#);
    assert_eq!(soup("a.3mf", surface).polygons.len(), 4);
    refusal("a.3mf", file("", &of("cake"), r#"<item objectid="2"/>"#), "cake");
}

#[test]
fn extensions_count_by_their_address() {
    let required = |address: &str| {
        file(&format!(r#"xmlns:x="{address}" requiredextensions="x""#), OBJECT, ITEM)
    };
    for known in
        ["production/2015/06", "material/2015/02", "beamlattice/2017/02", "trianglesets/2021/07"]
    {
        let address = format!("http://schemas.microsoft.com/3dmanufacturing/{known}");
        assert_eq!(soup("a.3mf", required(&address)).polygons.len(), 4);
    }
    let error =
        refusal("a.3mf", required("http://example.com/cheese"), "http://example.com/cheese");
    assert!(error.help.contains("plain meshes"));
    let secure = "http://schemas.microsoft.com/3dmanufacturing/securecontent/2019/04";
    refusal("a.3mf", required(secure), "encrypted");
    refusal("a.3mf", file("requiredextensions=\"y\"", OBJECT, ITEM), "requires the extension y");
    // Elements of other namespaces are not those of the core.
    let strange = OBJECT.replace("MESH", "<z:mesh xmlns:z=\"http://example.com\"/>MESH");
    assert_eq!(soup("a.3mf", file("", &strange, ITEM)).polygons.len(), 4);
    refusal("a.3mf", file("", &OBJECT.replace("MESH", "<z:mesh/>"), ITEM), "without a namespace");
}

#[test]
fn shapes_that_are_not_meshes_are_refused() {
    let beams = r#"<object id="1"><mesh><vertices><vertex x="0" y="0" z="0"/></vertices><b:beamlattice
        xmlns:b="http://schemas.microsoft.com/3dmanufacturing/beamlattice/2017/02"/></mesh></object>"#;
    let error = refusal("a.3mf", file("", beams, ITEM), "only beam lattices");
    assert!(error.help.contains("mesh"));
    let both = format!("{beams}<object id=\"2\">MESH</object>");
    let content = file("", &both, r#"<item objectid="1"/><item objectid="2"/>"#);
    assert!(notes(&content)[0].contains("beam lattices of 1 object"));
    let boolean = r#"<object id="1"><o:booleanshape xmlns:o="http://example.com"/></object>"#;
    refusal("a.3mf", file("", boolean, ITEM), "only Boolean operations");
    refusal("a.3mf", file("", r#"<object id="1"/>"#, ITEM), "unknown extensions");
    refusal("a.3mf", file("", OBJECT, ""), "no object with triangles");
}

#[test]
fn references_are_checked() {
    let component = |id: u32, of: u32| {
        format!(
            r#"<object id="{id}"><components><component objectid="{of}"/></components></object>"#
        )
    };
    refusal("a.3mf", file("", OBJECT, r#"<item objectid="7"/>"#), "object 7");
    refusal("a.3mf", file("", &component(1, 7), ITEM), "object 7");
    refusal("a.3mf", file("", &component(1, 1), ITEM), "component of itself");
    refusal("a.3mf", file("", &(component(1, 2) + &component(2, 1)), ITEM), "component of itself");
    let twice = format!("{OBJECT}{OBJECT}");
    refusal("a.3mf", file("", &twice, ITEM), "two resources with the number 1");
    let chain: String = (1..70).map(|i| component(i, i + 1)).collect();
    let chain = chain + &OBJECT.replace("id=\"1\"", "id=\"70\"");
    refusal("a.3mf", file("", &chain, ITEM), "more than 64 deep");
    let double = |id: u32| {
        let next = id + 1;
        format!(
            r#"<object id="{id}"><components><component objectid="{next}"/><component objectid="{next}"/></components></object>"#
        )
    };
    let doubled: String = (1..41).map(double).collect();
    let doubled = doubled + &OBJECT.replace("id=\"1\"", "id=\"41\"");
    refusal("a.3mf", file("", &doubled, ITEM), "places more than");
    let mixed = OBJECT.replace("MESH", "MESH<components/>");
    refusal("a.3mf", file("", &mixed, ITEM), "two shapes");
    let apart = OBJECT.replace(
        "MESH",
        r#"<components><component objectid="1" p:path="/3D/absent.model"/></components>"#,
    );
    refusal("a.3mf", file("", &apart, ITEM), "absent.model");
}

#[test]
fn numbers_are_checked() {
    let swapped = |from: &str, to: &str, word: &str| {
        assert!(TETRAHEDRON.contains(from), "{from}");
        let object = OBJECT.replace("MESH", &TETRAHEDRON.replacen(from, to, 1));
        let error = refusal("a.3mf", file("", &object, ITEM), word);
        assert!(error.to_string().contains("(object 1)"), "{error}");
    };
    swapped("x=\"1\"", "x=\"abc\"", "abc");
    swapped("x=\"1\"", "x=\"1,5\"", "1,5");
    swapped("x=\"1\"", "x=\"NaN\"", "NaN");
    swapped("x=\"1\"", "x=\"1e400\"", "1e400");
    swapped("x=\"1\"", "", "fewer than three coordinates");
    swapped("x=\"1\"", "p:x=\"1\"", "fewer than three coordinates");
    swapped("v3=\"1\"", "v3=\"4\"", "vertex 4, but only 4 vertices");
    swapped("v3=\"1\"", "v3=\"-1\"", "-1");
    swapped("v3=\"1\"", "v3=\"4294967296\"", "4294967296");
    swapped("v3=\"1\"", "", "fewer than three corners");
    for transform in
        ["1 0 0 0 1 0 0 0 1 0 0", "1 0 0 0 1 0 0 0 1 0 0 NaN", "0 0 0 0 0 0 0 0 0 0 0 0", ""]
    {
        let item = format!(r#"<item objectid="1" transform="{transform}"/>"#);
        let error = refusal("a.3mf", file("", OBJECT, &item), "");
        assert!(error.to_string().contains("(item 0)"), "{error}");
    }
    refusal("a.3mf", file("", &OBJECT.replace("id=\"1\"", "id=\"0\""), ITEM), "number 0");
}

#[test]
fn other_names_of_attributes_change_nothing() {
    let object =
        OBJECT.replace("MESH", &TETRAHEDRON.replacen("x=\"1\"", "xq=\"7\" x=\"1\" p:x=\"8\"", 1));
    assert_eq!(soup("a.3mf", file("", &object, ITEM)).points[1], [1.0, 0.0, 0.0]);
}

#[test]
fn models_in_utf_16_are_read() {
    let text = format!("<?xml version=\"1.0\" encoding=\"UTF-16\"?>{}", model("", OBJECT, ITEM));
    let bytes: Vec<u8> =
        std::iter::once(0xfeff).chain(text.encode_utf16()).flat_map(u16::to_le_bytes).collect();
    let content = crate::seeds::zip(&[
        ("_rels/.rels", crate::seeds::RELATIONSHIPS.as_bytes()),
        ("3D/3dmodel.model", &bytes),
    ]);
    assert_eq!(soup("a.3mf", content).polygons.len(), 4);
}
