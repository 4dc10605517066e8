//! Columns of text.

use std::io::Cursor;

use formats::LengthUnit;
use formats::points::{Columns, Note, ReadOptions};

use crate::support::{cloud, places, refusal};

const PLACES: [[f64; 3]; 3] = [[0.5, 0.25, 1.0], [-1.0, 20.0, 3.5], [4.0, 5.0, -6.25]];

/// Names of columns and three points, with a separator and a decimal mark.
fn table(separator: &str, decimal: &str) -> String {
    let row = |row: [&str; 3]| row.join(separator).replace('.', decimal) + "\n";
    ["x y z", "0.5 0.25 1.0", "-1.0 20.0 3.5", "4.0 5.0 -6.25"]
        .map(|line| row(line.split(' ').collect::<Vec<_>>().try_into().expect("three")))
        .concat()
}

#[test]
fn any_separator_will_do() {
    for separator in [" ", "   ", "\t", ",", ", ", " , ", ";", " ; ", "|", ",\t"] {
        let cloud = cloud("scan.txt", table(separator, "."));
        assert_eq!(places(&cloud), PLACES, "{separator:?}");
        assert!(cloud.notes.is_empty());
    }
}

#[test]
fn decimal_commas_are_told() {
    for separator in [" ", "\t", ";", "; ", "|"] {
        let cloud = cloud("scan.txt", table(separator, ","));
        assert_eq!(places(&cloud), PLACES, "{separator:?}");
        assert_eq!(cloud.notes, [Note::DecimalCommas]);
    }
}

#[test]
fn two_marks_in_a_number_are_refused() {
    for text in ["1.234,5;2.345,5;3.456,5\n", "1,234.5 2,345.5 3,456.5\n", "1.234,5 2.345,5 3\n"] {
        refusal("scan.txt", text.repeat(5), "");
    }
}

#[test]
fn commas_between_and_within_numbers_are_refused() {
    let word = "commas between and within";
    refusal("scan.csv", "x,y,z\n0,5,0,25,1,0\n-1,0,20,0,3,5\n", word);
    refusal("scan.csv", "42,794,37,017,12,555\n42,001,37,500,12,250\n", word);
    assert_eq!(cloud("scan.csv", "0,5,10\n2,3,20\n").len(), 2);
}

#[test]
fn line_ends_and_marks_do_not_matter() {
    let text = table(",", ".");
    for text in [
        text.replace('\n', "\r\n"),
        text.replace('\n', "\r"),
        format!("\u{feff}{text}"),
        text.replace('\n', "\n\n"),
        text.replace('\n', ",\n"),
        text.trim_end().to_owned(),
        format!("{text}\u{1a}"),
        format!("# a comment, with 1 2 3 numbers\n{text}"),
        text.replace("x,y,z", "//X,Y,Z"),
        text.replace("x,y,z", "\"x\",\"y\",\"z\""),
        text.replace("x,y,z\n", ""),
        text.replace("x,y,z", "Points of the shop: 3"),
        format!("3\n{text}"),
    ] {
        assert_eq!(places(&cloud("scan.csv", &text)), PLACES, "{text:?}");
    }
}

#[test]
fn names_decide_what_columns_hold() {
    let text = "id;Z [mm];Y;X;Nx;Ny;Nz;Red;Green;Blue;Intensity;label;class\n\
                a;1;0,25;0,5;0;0;1;1;2;3;;tree;1\nb;3;2;1;0;1;0;1;2;3;;;1\n";
    let cloud = cloud("scan.csv", text);
    assert_eq!(places(&cloud), [[0.5, 0.25, 1.0], [1.0, 2.0, 3.0]]);
    assert_eq!(cloud.normals, Some(vec![[0.0, 0.0, 1.0], [0.0, 1.0, 0.0]]));
    assert_eq!((cloud.lost.colours, cloud.lost.intensities), (2, 2));
    assert_eq!(cloud.lost.columns, ["id", "label", "class"]);
}

#[test]
fn numbers_decide_where_there_are_no_names() {
    for (row, normal, colours, intensities) in [
        ("1 2 3", None, 0, 0),
        ("1 2 3 0.5", None, 0, 2),
        ("1 2 3 0.6 0 0.8", Some([0.6f32, 0.0, 0.8]), 0, 0),
        ("1 2 3 255 0 128", None, 2, 0),
        ("1 2 3 -1613 52 70 64", None, 2, 2),
        ("1 2 3 52 70 64 0.6 0 0.8", Some([0.6, 0.0, 0.8]), 2, 0),
        ("1 2 3 0.6 0 0.8 52 70 64", Some([0.6, 0.0, 0.8]), 2, 0),
    ] {
        let cloud = cloud("scan.xyz", format!("{row}\n{row}\n"));
        assert_eq!(places(&cloud), [[1.0, 2.0, 3.0]; 2], "{row}");
        assert_eq!(cloud.normals, normal.map(|n| vec![n; 2]), "{row}");
        assert_eq!((cloud.lost.colours, cloud.lost.intensities), (colours, intensities), "{row}");
    }
}

#[test]
fn pts_is_in_metres_and_its_counts_are_hints() {
    let text = "2\n1 2 3 -5 0 0 0\n4 5 6 -5 0 0 0\n";
    let twice = cloud("scan.pts", text.repeat(2));
    assert_eq!((twice.len(), twice.unit), (4, Some(LengthUnit::Metre)));
    assert_eq!(twice.notes, [Note::MetresByCustom]);
    let lie = cloud("scan.pts", text.replacen('2', "1000000000000", 1));
    let count = Note::CountDiffers { announced: 1_000_000_000_000, found: 2 };
    assert_eq!(lie.notes, [Note::MetresByCustom, count]);
    // Without its name only the count tells it; and XYZ may have one, too.
    assert_eq!(cloud("scan", text).unit, Some(LengthUnit::Metre));
    assert_eq!(cloud("scan.xyz", text).unit, None);
    assert_eq!(cloud("scan", &text[2..]).unit, None);
}

#[test]
fn what_is_cut_off_is_told() {
    let cut = cloud("scan.pts", "3\n1 2 3\n4 5 6\n7 8");
    let count = Note::CountDiffers { announced: 3, found: 2 };
    assert_eq!(cut.notes, [Note::MetresByCustom, count, Note::LastLineCut]);
    // The last number may have had more digits.
    let cut = cloud("scan.pts", "4\n1 2 3\n4 5 6\n7 8 9");
    assert_eq!(cut.len(), 2);
    assert_eq!(cut.lost.unreadable_lines, 1);
    // But here it is the last point, and complete.
    assert_eq!(cloud("scan.pts", "3\n1 2 3\n4 5 6\n7 8 9").len(), 3);
    assert_eq!(cloud("scan.xyz", "1 2 3\n4 5 6\n7 8 9").len(), 3);
}

#[test]
fn points_that_are_no_numbers_are_counted() {
    let text = "1 2 3\nnan 0 0\n4 5 inf\n1.#QNAN 1 1\n0 0 0\n0 0 0\n0 0 0.5\n";
    let cloud = cloud("scan.xyz", text);
    assert_eq!(places(&cloud), [[1.0, 2.0, 3.0], [0.0, 0.0, 0.5]]);
    assert_eq!((cloud.lost.not_finite, cloud.lost.at_zero), (3, 2));
    refusal("scan.xyz", "nan nan nan\n", "no valid point: all 1");
}

#[test]
fn few_bad_lines_are_counted_and_many_refused() {
    let good = "1 2 3\n".repeat(300);
    let few = format!("{good}what is this\n1 2\n1 2 x\n");
    let cloud = cloud("scan.xyz", few);
    assert_eq!((cloud.len(), cloud.lost.unreadable_lines), (300, 3));
    let many = format!("{good}1 2 3 4\n1 2\n1 2 x\n1\u{202f}2 3\n");
    let error = refusal("scan.xyz", many, "4 of 304 lines that are no points, first");
    assert_eq!(error.place, Some(formats::Location::Line(301)));
    refusal("ragged.csv", "x,y,z\n1,2,3\n4,5\n6,7,8,9\n", "2 of 3 lines");
}

#[test]
fn what_is_no_cloud_is_refused() {
    refusal("scan.xyz", "this is no point cloud\nat all\n", "no line with three numbers");
    refusal("scan.xyz", "\n\n", "no line with three numbers");
    refusal("scan.xyz", b"\0\x01\x02 1 2 3\n", "is binary");
    refusal("scan.pts", b"[Binary/0.1]\ndata\n\xc3\x00\x01", "is binary");
    refusal("molecule.xyz", "2\nwater\nO 0 0 0\nH 1 0 0\n", "are no points");
    refusal("scan.xyz", "", "is empty");
    refusal("scan", "hello\n", "no known format");
}

/// Lines of fields that are made of a number, in a sheet of 12 x 5 points.
fn sheet(line: impl Fn(usize, usize) -> String) -> String {
    (0..60).map(|n| line(n / 12, n % 12) + "\n").collect()
}

/// The place of a point of the sheet.
fn place(row: usize, column: usize) -> [f64; 3] {
    let [i, j] = [row, column].map(|i| i as f64);
    [0.5 * j + 0.01 * (i * j).sin(), 0.5 * i, (0.3 * j).sin() + 0.1 * i]
}

fn joined(numbers: &[f64]) -> String {
    numbers.iter().map(ToString::to_string).collect::<Vec<_>>().join(" ")
}

#[test]
fn numbers_of_points_are_no_coordinates() {
    let all: Vec<[f64; 3]> = (0..60).map(|n| place(n / 12, n % 12)).collect();
    let number = |row: usize, column: usize| 12 * row + column + 1;
    let at = |row, column| joined(&place(row, column));
    let normal = "0 0.6 0.8";
    for (columns, text) in [
        (1, sheet(|i, j| format!("{} {}", number(i, j), at(i, j)))),
        (1, sheet(|i, j| format!("{};{}", 1000 + 3 * number(i, j), at(i, j).replace(' ', ";")))),
        (1, sheet(|i, j| format!("{}\t{} {normal}", number(i, j), at(i, j)))),
        (1, sheet(|i, j| format!("{} {} 10 200 30", number(i, j), at(i, j)))),
        (2, sheet(|i, j| format!("{i} {j} {}", at(i, j)))),
        (2, sheet(|i, j| format!("{} {} {} 17", j + 5, 2 * i + 9, at(i, j)))),
        (2, sheet(|i, j| format!("{i} {j} {} {normal}", at(i, j)))),
    ] {
        let cloud = cloud("scan.txt", &text);
        assert_eq!(cloud.notes, [Note::PointNumbers { columns }], "{text}");
        assert_eq!(places(&cloud), all, "{text}");
        let has_normals = text.contains(normal);
        assert_eq!(cloud.normals.is_some_and(|n| n[0] == [0.0, 0.6, 0.8]), has_normals);
    }
}

#[test]
fn coordinates_are_no_numbers_of_points() {
    let height = |i: usize, j: usize| place(i, j)[2];
    for text in [
        // A raster of whole coordinates, with an intensity, colours, or normals.
        sheet(|i, j| format!("{j} {i} {} 17", height(i, j))),
        sheet(|i, j| format!("{i} {j} {} 10 200 30", height(i, j))),
        sheet(|i, j| format!("{i} {j} {} 0 0.6 0.8", height(i, j))),
        // With an intensity and a class, or two.
        sheet(|i, j| format!("{i} {j} {:.4} 0.{:03} {}", height(i, j), 83 * (i * j) % 100, j % 3)),
        sheet(|i, j| {
            format!("{i} {j} {:.4} 0.{:03} 1 {}", height(i, j), 83 * (i * j) % 100, j % 3)
        }),
        // Whole coordinates that are sorted, but for one.
        sheet(|i, j| format!("{} {} 5 {}", 3 * (12 * i + j) % 177, 17 * j % 12, 7 * j % 5)),
        // Coordinates alone.
        sheet(|i, j| format!("{} {i} {}", 12 * i + j, height(i, j))),
    ] {
        let cloud = cloud("scan.txt", &text);
        assert!(cloud.notes.is_empty(), "{text}");
        let first: Vec<f64> =
            text.split_whitespace().take(3).map(|x| x.parse().expect("a number")).collect();
        assert_eq!(places(&cloud)[0][..], first, "{text}");
    }
}

#[test]
fn times_of_points_are_no_coordinates() {
    let all: Vec<[f64; 3]> = (0..60).map(|n| place(n / 12, n % 12)).collect();
    let [time, week] = [0.1, 345_600.0].map(|start| {
        move |i: usize, j: usize| start + 0.033 * (12 * i + j) as f64 + 0.001 * (j % 3) as f64
    });
    let at = |i: usize, j: usize| place(i, j).map(|x| format!("{x:.4}")).join(" ");
    // A scan in lines along x, whatever the times are; one in no order, whose times are in seconds of the week; several
    // echoes of each pulse; and a name.
    let turned = |i: usize, j: usize| (5 * i + j * j) % 12;
    for text in [
        sheet(|i, j| format!("{:.4} {}", time(i, j), at(i, j))),
        sheet(|i, j| format!("{:.2} {} 17", time(i, j), at(i, j))),
        sheet(|i, j| format!("{} {} 10 200 30", week(i, j), at(i, turned(i, j)))),
        sheet(|i, j| format!("{:.4} {}", week(i, j - (j % 3).min(1)), at(i, j))),
        format!("Time, a, b, c\n{}", sheet(|i, j| format!("{} {}", 7 * (j % 2), at(i, j)))),
    ] {
        let cloud = cloud("scan.txt", &text);
        assert_eq!(cloud.notes, [Note::PointNumbers { columns: 1 }], "{text}");
        let is_place =
            |p: &[f64; 3]| all.iter().any(|q| (0..3).all(|axis| (p[axis] - q[axis]).abs() < 1e-4));
        assert!(places(&cloud).iter().all(is_place), "{text}");
    }
}

#[test]
fn sorted_coordinates_are_no_times() {
    let height = |i: usize, j: usize| place(i, j)[2];
    let x = |i: usize, j: usize| 0.125 * (12 * i + j) as f64 + 0.01 * (j as f64).sin();
    for (text, may_be_times) in [
        // A cloud in the order of its x, with an intensity or colours.
        (
            sheet(|i, j| {
                format!(
                    "{:.3} {:.3} {:.3} 0.{:03}",
                    x(i, j),
                    0.5 * (7 * j % 12) as f64,
                    height(i, j),
                    41 * j
                )
            }),
            true,
        ),
        (
            sheet(|i, j| {
                format!("{:.3} {:.3} {:.3} 9 8 7", x(i, j), 0.5 * (7 * j % 12) as f64, height(i, j))
            }),
            true,
        ),
        // A raster along x or along y, with an intensity, and one whose x moves while y does.
        (
            sheet(|i, j| {
                format!(
                    "{:.3} {:.3} {:.3} 0.{:02}",
                    0.5 * j as f64,
                    0.5 * i as f64,
                    height(i, j),
                    7 * j
                )
            }),
            false,
        ),
        (
            sheet(|i, j| {
                format!(
                    "{:.3} {:.3} {:.3} 0.{:02}",
                    0.5 * i as f64,
                    0.5 * j as f64,
                    height(i, j),
                    7 * j
                )
            }),
            false,
        ),
        (
            sheet(|i, j| {
                format!("{:.3} {:.3} {:.3} 0.{:02}", x(i, j), 0.5 * j as f64, height(i, j), 7 * j)
            }),
            true,
        ),
        // A row of a fine raster whose heights rise by less than their last digit.
        (
            sheet(|i, j| {
                let n = (12 * i + j) as f64;
                format!("{:.3} 0.250 {:.3} 0.{:03}", 0.125 * n, 0.0004 * n, 83 * (i + j) % 100)
            }),
            true,
        ),
        // Coordinates alone, far along x.
        (
            sheet(|i, j| {
                format!("{:.3} {:.3} {:.3}", 5000.0 + x(i, j), 0.5 * j as f64, height(i, j))
            }),
            false,
        ),
    ] {
        let cloud = cloud("scan.txt", &text);
        let first: Vec<f64> =
            text.split_whitespace().take(3).map(|x| x.parse().expect("a number")).collect();
        assert_eq!(places(&cloud)[0][..], first, "{text}");
        let notes = if may_be_times { vec![Note::FirstColumnRises] } else { Vec::new() };
        assert_eq!(cloud.notes, notes, "{text}");
    }
}

#[test]
fn a_user_chooses_columns() {
    let chosen = |columns: &str, text: &str| {
        let columns = Some(columns.parse().expect("columns"));
        let options = ReadOptions { columns, ..ReadOptions::default() };
        options.read_points_from("scan.txt".as_ref(), Cursor::new(text.to_owned()))
    };
    let plain = "7 1 2 3 0.6\n9 4 5 6 0.8\n";
    let named = "Point Id;Up;East;North;\u{20}\n7;3;1;2;0.6\n9;6;4;5;0.8\n";
    for (columns, text) in [
        ("2,3,4", plain),
        ("id, x, y, z", plain),
        ("id,x,y,z,quality", plain),
        ("East,NORTH,up", named),
        ("3,4,2", named),
        ("x,y,up", named),
    ] {
        let cloud = chosen(columns, text).expect("a cloud");
        assert_eq!(places(&cloud), [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]], "{columns}");
        assert!(cloud.notes.is_empty() && cloud.normals.is_none());
    }
    let cloud = chosen("4,3,2,5,1,6", "7 1 2 3 0.5 0.25\n".repeat(2).as_str());
    let cloud = cloud.expect("a cloud with normals");
    assert_eq!(places(&cloud)[0], [3.0, 2.0, 1.0]);
    assert_eq!(cloud.normals.map(|n| n[0]), Some([0.5, 7.0, 0.25]));
    for (columns, word) in
        [("2,3,9", "no column 9"), ("a,b,c", "a, b, c"), ("x,y,z,a,b,c", "6 are named")]
    {
        let error = chosen(columns, plain).expect_err("should be refused");
        assert!(error.to_string().contains(word), "{error}");
    }
    for columns in ["", "1,2", "1,2,3,4", "0,1,2", "1,1,2", "1,,2", "x"] {
        assert!(columns.parse::<Columns>().is_err(), "{columns}");
    }
    assert!(chosen("1,2,3", "v 0 0 0\nv 1 0 0\nv 0 1 0\n").is_err());
}

#[test]
fn lists_of_unused_columns_end() {
    let text = "1 2 3 4 5 6 7 8 9 10 11 12\n".repeat(3);
    let remarks = cloud("scan.txt", text).remarks();
    let list = "not used: the columns column 4, column 5, column 6, column 7, column 8 and 4 more";
    assert_eq!(remarks, [list]);
}

#[test]
fn degrees_are_refused() {
    let line = |i: usize, j: usize| {
        let [x, y, z] = place(i, j);
        format!("{:.7} {:.7} {:.3}", 11.25 + x * 1e-5, 47.5 + y * 1e-5, 300.0 + z)
    };
    for text in [
        // By the names, in any order, whatever the digits are.
        format!("lon lat h\n{}", sheet(line)),
        format!(
            "# id Latitude Longitude height\n{}",
            sheet(|i, j| format!("{} {}", 12 * i + j, joined(&[47.5, 11.25, place(i, j)[2]])))
        ),
        "lat,lon,alt\n47.5,11.25,3.125\n47.625,101.25,3\n".to_owned(),
        // By the digits.
        sheet(line),
        format!("x y z\n{}", sheet(line)),
    ] {
        let error = refusal("scan.txt", text, "has coordinates in degrees");
        assert!(error.help.contains("Project it"), "{error}");
    }
    let rod =
        |i: usize, j: usize| format!("{:.3} {:.3} {}", 0.001 * i as f64, 0.001 * j as f64, 12 * i);
    for text in [
        // Names of degrees over lengths, a unit, and a thin rod that stands.
        format!("lon lat h\n{}", sheet(|i, j| joined(&[500_000.0 + j as f64, i as f64, 3.0]))),
        format!("x[m] y[m] z[m]\n{}", sheet(line)),
        sheet(rod).replace('\n', ".125\n"),
    ] {
        assert_eq!(cloud("scan.txt", &text).len(), 60, "{text}");
    }
}
