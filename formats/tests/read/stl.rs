//! STL: supported features and errors.

use formats::Location;

use crate::support::{polygons, read, refusal, soup};

const TRIANGLE: &str = "facet normal 0 0 1\n outer loop\n  vertex 0 0 0\n  vertex 1.5 0 0\n  \
                        vertex 0 1e0 0\n endloop\nendfacet\n";
const CORNERS: [[f64; 3]; 3] = [[0., 0., 0.], [1.5, 0., 0.], [0., 1., 0.]];

fn ascii(facets: &str) -> String {
    format!("solid a name with facet in it\n{facets}endsolid a name\n")
}

fn binary(header: &str, count: u32, triangles: usize) -> Vec<u8> {
    let mut file = header.as_bytes().to_vec();
    file.resize(80, b' ');
    file.extend(count.to_le_bytes());
    for _ in 0..triangles {
        file.extend([0; 12]);
        CORNERS.as_flattened().iter().for_each(|v| file.extend((*v as f32).to_le_bytes()));
        file.extend([0; 2]);
    }
    file
}

#[test]
fn ascii_gives_three_points_for_each_triangle() {
    let soup = soup("two.stl", ascii(&TRIANGLE.repeat(2)));
    assert_eq!(soup.points, [CORNERS, CORNERS].concat());
    assert_eq!(polygons(&soup), [[0, 1, 2], [3, 4, 5]]);
    assert_eq!(soup.unit, None);
}

#[test]
fn several_solids_are_one_mesh() {
    let text = ascii(TRIANGLE) + "\n" + &ascii("") + &ascii(TRIANGLE).to_uppercase();
    assert_eq!(polygons(&soup("solids.stl", text)), [[0, 1, 2], [3, 4, 5]]);
}

#[test]
fn all_of_it_may_be_one_line_and_end_as_in_dos() {
    let line = ascii(&TRIANGLE.repeat(2)).replace('\n', " ");
    assert_eq!(soup("line.stl", &line).points, [CORNERS, CORNERS].concat());
    assert_eq!(soup("dos.stl", ascii(TRIANGLE) + "\u{1a}").points, CORNERS);
    refusal("cut.stl", ascii(TRIANGLE).replace("endfacet", "\u{1a}"), "not valid STL text");
}

#[test]
fn loose_text_is_read() {
    let text = ascii(TRIANGLE);
    let loose = [
        text.replace('\n', "\r\n"),
        text.replace('\n', "\r"),
        text.trim_end().to_owned(),
        "\n  ".to_owned() + &text,
        text.replace("a name", ""),
        ascii(&TRIANGLE.replace('\n', " ")).replace("endsolid", "\nendsolid"),
        text.replace("normal 0 0 1", "normal nan -nan(ind) x"),
    ];
    for text in loose {
        assert_eq!(soup("loose.stl", &text).points, CORNERS, "{text}");
        assert_eq!(soup("loose.txt", &text).points, CORNERS, "{text}");
    }
}

#[test]
fn binary_is_read_whatever_its_header() {
    for header in ["", "solid", "solid in name only", "v 1 2 3", "PK\x03\x04"] {
        for name in ["two.stl", "two.bin"] {
            let soup = soup(name, binary(header, 2, 2));
            assert_eq!(soup.points, [CORNERS, CORNERS].concat());
            assert_eq!(polygons(&soup), [[0, 1, 2], [3, 4, 5]]);
        }
    }
}

#[test]
fn what_follows_a_binary_mesh_is_left_alone() {
    let mut file = binary("made by hand", 1, 1);
    file.extend(b"more");
    assert_eq!(soup("more.stl", file).points, CORNERS);
}

#[test]
fn points_without_a_number_are_kept() {
    let text = ascii(&TRIANGLE.replace("1.5", "nan"));
    assert!(!soup("nan.stl", text).points[1][0].is_finite());
}

#[test]
fn cut_files_are_refused() {
    let error = refusal("cut.stl", binary("", 3, 2), "ends after 2 of its 3");
    assert_eq!(error.place, Some(Location::Face(2)));
    refusal("huge.stl", binary("", u32::MAX, 1), "ends after 1");
    let text = ascii(TRIANGLE);
    let end = text.find("endsolid").expect("an end");
    let start = text.find('\n').expect("a line") + 1;
    for cut in start..end + 8 {
        let error = refusal("cut.stl", &text[..cut], "");
        assert!(matches!(error.place, Some(Location::Line(_))), "{cut}: {error}");
    }
}

#[test]
fn unsound_text_is_refused() {
    let swaps = [
        ("  vertex 0 1e0 0\n", ""),
        ("1e0", "1,0"),
        ("1e0", ""),
        (" endloop\n", ""),
        ("endfacet\n", ""),
        ("facet normal 0 0 1\n", ""),
        ("outer", "inner"),
        ("endsolid", "solid"),
    ];
    for (from, to) in swaps {
        let error = refusal("bad.stl", ascii(TRIANGLE).replacen(from, to, 1), "");
        assert!(matches!(error.place, Some(Location::Line(_))), "{from}: {error}");
    }
}

#[test]
fn cases_and_names_of_every_kind() {
    let text = ascii(TRIANGLE);
    let alternate = |text: &str| {
        let letter = |(i, c): (usize, char)| if i % 2 == 0 { c.to_ascii_uppercase() } else { c };
        text.chars().enumerate().map(letter).collect::<String>()
    };
    let odd = [
        text.to_uppercase(),
        alternate(&text),
        text.replace(' ', "\t"),
        text.replace(' ', "  \t "),
        text.replace("endsolid a name", "endsolid another"),
        text.replace("endsolid a name", "endsolid"),
        "\u{feff}".to_owned() + &text,
        text.replace("endsolid", "\r\n\r\n\tEndSolid"),
        text.clone() + "\n\n",
    ];
    for text in odd {
        for name in ["odd.stl", "ODD.STL", "odd"] {
            assert_eq!(soup(name, &text).points, CORNERS, "{text}");
        }
    }
}

#[test]
fn ascii_numbers_of_every_spelling() {
    for (word, value) in [
        ("1.500000e+00", 1.5),
        ("+1.5E0", 1.5),
        (".5", 0.5),
        ("-5.", -5.),
        ("-4.336808e-16", -4.336_808e-16),
        ("5123456.123456", 5_123_456.123_456),
    ] {
        let text = ascii(&TRIANGLE.replace("1.5", word));
        assert_eq!(soup("number.stl", text).points[1], [value, 0., 0.], "{word}");
    }
    let comma = refusal("comma.stl", ascii(&TRIANGLE.replace("1.5", "1,5")), "vertex 1,5 0 0");
    assert_eq!(comma.place, Some(Location::Line(5)));
    assert!(comma.help.contains("decimal points"));
}

#[test]
fn loops_of_more_corners_are_polygons() {
    let quad = TRIANGLE.replace(" endloop", "  vertex -1 0 0\n endloop");
    assert_eq!(polygons(&soup("quad.stl", ascii(&quad))), [[0, 1, 2, 3]]);
}

#[test]
fn files_without_triangles_are_refused() {
    for text in [
        "solid Empty\nendsolid Empty",
        "solid\nendsolid\n",
        "solid a\nendsolid a\nsolid b\nendsolid b\n",
    ] {
        for name in ["empty.stl", "empty"] {
            refusal(name, text, "neither points nor faces");
        }
    }
    refusal("zero.stl", binary("", 0, 0), "neither points nor faces");
    refusal("zero.stl", binary("", 0, 2), "declares 0 triangles, but its length is that of 2");
}

#[test]
fn solids_without_their_end_are_refused() {
    let text = ascii(TRIANGLE);
    let whole = text.strip_suffix("endsolid a name\n").expect("an end");
    for end in ["", "\n\n", "endsoli"] {
        let error = refusal("open.stl", whole.to_owned() + end, "");
        assert!(matches!(error.place, Some(Location::Line(_))), "{error}");
    }
    let error = refusal("open.stl", whole, "ends without endsolid");
    assert!(error.help.contains("endsolid"));
    // A truncated number is not read as a smaller one.
    let cut = &whole[..whole.find("vertex 0 1e0").expect("a vertex") + 10];
    refusal("cut.stl", cut, "vertex 0 1");
}

#[test]
fn colours_of_a_binary_file_are_left_out() {
    let mut file = binary("solid COLOR=\x7f\x7f\x7f\x7f,MATERIAL=", 2, 2);
    for triangle in 0..2 {
        file[84 + 50 * triangle..][..12].fill(0x7f);
        file[84 + 50 * triangle..][48..50].fill(0xff);
    }
    assert_eq!(soup("colour.stl", &file).points, [CORNERS, CORNERS].concat());
    // Even if every byte of the header is text.
    file[..80].fill(b'x');
    file[..6].copy_from_slice(b"solid ");
    assert_eq!(soup("colour.STL", &file).points, [CORNERS, CORNERS].concat());
}

#[test]
fn binary_points_without_a_number_are_kept() {
    for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut file = binary("", 2, 2);
        file[84 + 12..84 + 16].copy_from_slice(&value.to_le_bytes());
        let soup = soup("nan.stl", file);
        assert!(!soup.points[0][0].is_finite());
        assert_eq!(soup.points[1..], [CORNERS, CORNERS].concat()[1..]);
    }
}

/// A binary file that is sent as text gets an additional byte for each line feed, or three bytes
/// for each byte that is not UTF-8. So its end is at another position.
#[test]
fn binaries_damaged_as_text_are_refused() {
    let mut file = binary("made by hand", 2, 2);
    file[84 + 24..84 + 28].copy_from_slice(&(-1.5f32).to_le_bytes());
    file[84 + 36..84 + 40].copy_from_slice(&[0, b'\n', b'\n', 0x40]);
    assert_eq!(polygons(&soup("sound.stl", &file)).len(), 2);
    let lines = file.iter().flat_map(|&b| if b == b'\n' { vec![13, b] } else { vec![b] });
    refusal("lines.stl", lines.collect::<Vec<u8>>(), "");
    refusal("mangled.stl", String::from_utf8_lossy(&file).as_bytes(), "");
}

/// Text without its first word is not a binary file with a billion triangles.
#[test]
fn text_that_begins_otherwise_is_not_taken_for_binary() {
    let text = ascii(TRIANGLE);
    let facets = text.split_once('\n').expect("a line").1;
    for text in
        [facets.to_owned(), text.replacen("solid ", "solid_", 1), "# a\n".to_owned() + &text]
    {
        match read("odd.stl", &text) {
            Ok(soup) => assert_eq!(soup.points, CORNERS),
            Err(e) => assert!(!e.to_string().contains("triangles"), "{e}"),
        }
    }
}

#[test]
fn a_point_alone_is_no_number() {
    for word in [".", "-.", "+.", ".e5", "-.e-5"] {
        let error = refusal("point.stl", ascii(&TRIANGLE.replace("1.5", word)), word);
        assert_eq!(error.place, Some(Location::Line(5)), "{word}");
    }
}

/// The text after a solid's name in its line belongs to the name.
#[test]
fn line_ends_may_change() {
    let text = ascii(TRIANGLE) + &ascii(TRIANGLE).replace('\n', "\r");
    assert_eq!(polygons(&soup("ends.stl", &text)).len(), 2);
    let text = ascii(TRIANGLE).replace('\n', "\r") + &ascii(TRIANGLE);
    assert_eq!(polygons(&soup("ends.stl", &text)).len(), 2);
}

#[test]
fn text_of_another_beginning_is_refused_by_line() {
    let facets = ascii(TRIANGLE).split_once('\n').expect("a line").1.to_owned();
    let error = refusal("facets.stl", &facets, "endsolid a name");
    assert_eq!(error.place, Some(Location::Line(8)));
    let error = refusal("words.stl", "Hello\nsolid\n", "not valid STL text at \u{201c}Hello");
    assert_eq!(error.place, Some(Location::Line(1)));
}
