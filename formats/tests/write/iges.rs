//! IGES files: columns, sections, pointers, and the content of entities.

use formats::Brep;
use formats::iges::{Form, Options, write};

use crate::iges_file;
use crate::model;

const FORMS: [Form; 2] = [Form::Trimmed, Form::Brep];

/// An entity from its directory entry and its parameters.
struct Record {
    kind: u32,
    form: u32,
    status: String,
    label: String,
    /// The parameters without the entity type.
    parameters: Vec<String>,
}

impl Record {
    fn number<T: std::str::FromStr>(&self, i: usize) -> T
    where
        T::Err: std::fmt::Debug,
    {
        self.parameters[i].replace('D', "E").parse().unwrap()
    }

    fn numbers(&self) -> Vec<f64> {
        (0..self.parameters.len()).map(|i| self.number(i)).collect()
    }

    /// The first and last poles of a B-spline curve (126).
    fn ends(&self) -> [[f64; 3]; 2] {
        assert_eq!(self.kind, 126);
        let n = self.numbers();
        let (upper, degree) = (n[0] as usize, n[1] as usize);
        let poles = &n[6 + upper + degree + 2 + upper + 1..];
        let pole = |i: usize| [poles[3 * i], poles[3 * i + 1], poles[3 * i + 2]];
        [pole(0), pole(upper)]
    }

    fn knots(&self) -> Vec<f64> {
        let n = self.numbers();
        n[6..6 + n[0] as usize + n[1] as usize + 2].to_vec()
    }
}

/// The lines of one section without their sequence numbers, which are checked.
fn section(file: &str, letter: char) -> Vec<&str> {
    let lines = file.lines().filter(|l| l.as_bytes()[72] == letter as u8);
    let mut found = Vec::new();
    for (i, line) in lines.enumerate() {
        assert_eq!(line[73..].trim().parse::<usize>().unwrap(), i + 1);
        found.push(&line[..72]);
    }
    found
}

/// Splits free-format parameters. The lengths of strings and the blanks before numbers are removed.
fn split(text: &str) -> Vec<String> {
    let mut rest = text;
    let mut found = Vec::new();
    loop {
        let end = rest.find([',', ';', 'H']).unwrap();
        let (token, after) = match (rest.as_bytes()[end], rest[..end].trim().parse::<usize>()) {
            (b'H', Ok(length)) => (&rest[end + 1..][..length], &rest[end + 1 + length..]),
            _ => (rest[..end].trim(), &rest[end..]),
        };
        found.push(token.to_string());
        rest = &after[1..];
        if after.starts_with(';') {
            assert_eq!(rest.trim(), "");
            return found;
        }
    }
}

fn records(file: &str) -> Vec<Record> {
    let (directory, parameters) = (section(file, 'D'), section(file, 'P'));
    let mut next_line = 1;
    let records = directory.chunks(2).enumerate().map(|(i, pair)| {
        let field = |line: usize, n: usize| pair[line][8 * n..8 * n + 8].trim();
        let number = |line, n| field(line, n).parse::<usize>().unwrap();
        let (start, count) = (number(0, 1), number(1, 3));
        assert_eq!(start, next_line);
        next_line += count;
        let mut text = String::new();
        for line in &parameters[start - 1..start - 1 + count] {
            assert_eq!(line[64..].trim().parse::<usize>().unwrap(), 2 * i + 1);
            text.push_str(&line[..64]);
        }
        let tokens = split(&text);
        let kind = number(0, 0) as u32;
        assert_eq!(tokens[0], kind.to_string());
        assert_eq!(kind as usize, number(1, 0));
        Record {
            kind,
            form: number(1, 4) as u32,
            status: field(0, 8).to_string(),
            label: field(1, 7).to_string(),
            parameters: tokens[1..].to_vec(),
        }
    });
    let records: Vec<_> = records.collect();
    assert_eq!(next_line, parameters.len() + 1);
    records
}

fn all(records: &[Record], kind: u32) -> Vec<&Record> {
    records.iter().filter(|r| r.kind == kind).collect()
}

/// The entity to which parameter `i` points.
fn follow<'a>(records: &'a [Record], from: &Record, i: usize) -> &'a Record {
    let pointer: usize = from.number(i);
    assert_eq!(pointer % 2, 1);
    &records[pointer / 2]
}

#[test]
fn lines_have_eighty_columns_and_sections_are_counted() {
    for form in FORMS {
        for brep in [model::one_face("part"), model::two_faces("x y z")] {
            let file = iges_file(&brep, form);
            assert!(file.is_ascii() && file.lines().all(|l| l.len() == 80));
            let letters: String = file.lines().map(|l| &l[72..73]).collect();
            let counts = ['S', 'G', 'D', 'P', 'T'].map(|c| section(&file, c).len());
            let ordered = ['S', 'G', 'D', 'P', 'T'].iter().zip(counts);
            assert_eq!(letters, ordered.map(|(c, n)| c.to_string().repeat(n)).collect::<String>());
            let [s, g, d, p, t] = counts;
            assert_eq!([s, t, d % 2], [1, 1, 0]);
            let end = format!("S{s:7}G{g:7}D{d:7}P{p:7}");
            assert!(section(&file, 'T')[0].starts_with(&end));
            assert!(!records(&file).is_empty());
        }
    }
}

#[test]
fn numbers_do_not_cross_lines() {
    for form in FORMS {
        let file = iges_file(&model::one_face(""), form);
        for line in section(&file, 'P') {
            let text = line[..64].trim_end();
            assert!(text.ends_with([',', ';']), "{line}");
            assert_eq!(line.as_bytes()[64], b' ');
        }
    }
}

#[test]
fn the_global_section_says_what_the_file_is() {
    let brep = Brep { uncertainty_mm: 2.5e-6, ..model::two_faces("Teil ä; 1") };
    let options = Options {
        time_stamp: "2024-02-29T13:05:59Z".into(),
        file_name: "a,b;c.igs".into(),
        ..Default::default()
    };
    let mut out = Vec::new();
    write(&brep, &options, &mut out).unwrap();
    let file = String::from_utf8(out).unwrap();
    let global = split(&section(&file, 'G').concat());
    assert_eq!(global.len(), 26);
    assert_eq!(global[..5], [",", ";", "Teil _; 1", "a,b;c.igs", "scan2step"]);
    assert_eq!(global[6..11], ["32", "38", "6", "308", "15"]);
    assert_eq!(global[12..15], ["1.", "2", "MM"]);
    assert_eq!(global[17..20], ["20240229.130559", "2.5D-06", "200."]);
    assert_eq!(global[22..], ["11", "0", "20240229.130559", ""]);
}

#[test]
fn a_trimmed_surface_has_an_explicit_outer_loop() {
    let records = records(&iges_file(&model::one_face(""), Form::Trimmed));
    let face = all(&records, 144)[0];
    assert_eq!(follow(&records, face, 0).kind, 128);
    assert_eq!([face.number::<u32>(1), face.number(2)], [1, 2]);
    for i in 3..6 {
        let on_surface = follow(&records, face, i);
        assert_eq!(on_surface.kind, 142);
        assert_eq!(on_surface.parameters[1], face.parameters[0]);
        for (part, status) in [(2, "00010500"), (3, "00010000")] {
            let composite = follow(&records, on_surface, part);
            assert_eq!([composite.kind, composite.number(0)], [102, if i == 3 { 4 } else { 2 }]);
            let curves: Vec<_> =
                (1..composite.parameters.len()).map(|i| follow(&records, composite, i)).collect();
            assert!(curves.iter().all(|c| c.status == status));
            assert_head_to_tail(&curves);
        }
    }
}

fn assert_head_to_tail(curves: &[&Record]) {
    for (i, curve) in curves.iter().enumerate() {
        let (end, start) = (curve.ends()[1], curves[(i + 1) % curves.len()].ends()[0]);
        assert!(end.iter().zip(start).all(|(a, b)| (a - b).abs() < 1e-12), "{end:?} {start:?}");
    }
}

#[test]
fn a_shell_shares_edges_and_its_pcurves_run_along_the_loops() {
    let records = records(&iges_file(&model::two_faces(""), Form::Brep));
    let shell = all(&records, 514)[0];
    assert_eq!([shell.form, shell.number(0), shell.number(2)], [2, 2, 1]);
    assert_eq!(all(&records, 502)[0].number::<u32>(0), 10);
    let edges = all(&records, 504)[0];
    assert_eq!(edges.number::<usize>(0), 11);
    for tuple in edges.parameters[1..].chunks(5) {
        let ends = [2, 4].map(|i| tuple[i].parse::<usize>().unwrap());
        assert!(ends.iter().all(|n| (1..=10).contains(n)));
    }
    assert_eq!(all(&records, 128).len(), 2);
    let faces = all(&records, 510);
    assert_eq!(faces[0].parameters[1..3], ["3", "1"]);
    assert_eq!(faces[1].parameters[1..3], ["1", "1"]);
    let mut used = vec![0; 11];
    for edge_loop in all(&records, 508) {
        let mut pcurves = Vec::new();
        for use_at in (1..edge_loop.parameters.len()).step_by(7) {
            used[edge_loop.number::<usize>(use_at + 2) - 1] += 1;
            pcurves.push(follow(&records, edge_loop, use_at + 6));
        }
        assert_head_to_tail(&pcurves);
    }
    used.sort_unstable();
    assert_eq!(used, [[1; 10].as_slice(), &[2]].concat());
}

#[test]
fn one_root_stands_alone() {
    for (form, brep, root) in [
        (Form::Trimmed, model::one_face("a"), 144),
        (Form::Trimmed, model::two_faces("a"), 402),
        (Form::Brep, model::two_faces("a"), 514),
    ] {
        let records = records(&iges_file(&brep, form));
        let roots: Vec<_> = records.iter().filter(|r| r.status == "00000000").collect();
        assert_eq!(roots.iter().map(|r| r.kind).collect::<Vec<_>>(), [root]);
    }
    let records = records(&iges_file(&model::two_faces("a"), Form::Trimmed));
    let group = all(&records, 402)[0];
    assert_eq!([group.form, group.number(0)], [7, 2]);
    assert!([1, 2].iter().all(|&i| follow(&records, group, i).status == "00020000"));
}

#[test]
fn an_inverted_face_says_so_in_the_shell_only() {
    let inverted = records(&iges_file(&model::inverted(""), Form::Brep));
    assert_eq!(all(&inverted, 514)[0].parameters[2], "0");
    let (a, b) = (model::inverted(""), model::one_face(""));
    let trimmed = |brep| iges_file(brep, Form::Trimmed).lines().count();
    assert_eq!(trimmed(&a), trimmed(&b));
    for edge_loop in all(&inverted, 508) {
        let uses = (1..edge_loop.parameters.len()).step_by(7);
        let pcurves: Vec<_> = uses.map(|i| follow(&inverted, edge_loop, i + 6)).collect();
        assert_head_to_tail(&pcurves);
    }
}

#[test]
fn reversed_curves_keep_their_range() {
    let records = records(&iges_file(&model::one_face(""), Form::Trimmed));
    for curve in all(&records, 126) {
        let knots = curve.knots();
        assert_eq!((knots[0], knots[knots.len() - 1]), (0.0, 1.0));
        assert!(knots.windows(2).all(|k| k[0] <= k[1]));
    }
}

#[test]
fn names_and_labels() {
    let name = "A rather long näme, with; delimiters and 12H of everything, beyond one line";
    let ascii = name.replace('ä', "_");
    for form in FORMS {
        let records = records(&iges_file(&model::one_face(name), form));
        let property = all(&records, 406)[0];
        assert_eq!(property.form, 15);
        assert_eq!(property.parameters, ["1", &ascii]);
        let root = records.last().unwrap();
        assert_eq!(root.label, "Aratherl");
        let tail = &root.parameters[root.parameters.len() - 3..];
        assert_eq!(tail[..2], ["0", "1"]);
        assert_eq!(follow(&records, root, root.parameters.len() - 1).kind, 406);
    }
    assert!(all(&records(&iges_file(&model::one_face(""), Form::Brep)), 406).is_empty());
}

#[test]
fn the_net_runs_along_u_first() {
    let records = records(&iges_file(&model::one_face(""), Form::Trimmed));
    let surface = all(&records, 128)[0];
    let n = surface.numbers();
    assert_eq!(n[..9], [7.0, 7.0, 3.0, 3.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
    let poles = &n[9 + 12 + 12 + 64..];
    assert_eq!(poles.len(), 3 * 64 + 4);
    assert!(poles[3] > 0.0 && poles[4] == 0.0, "x grows first");
    assert_eq!(poles[3 * 64..], [0.0, 1.0, 0.0, 1.0]);
}

#[test]
fn the_same_part_gives_the_same_bytes() {
    for form in FORMS {
        let file = iges_file(&model::two_faces("part"), form);
        assert_eq!(file, iges_file(&model::two_faces("part"), form));
    }
}
