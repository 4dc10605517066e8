//! Comparison of the drawing of dependencies in `docs/architecture.md` with the imports of the
//! rooms, and of the files of tests with the modules of their programs.

mod common;

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use common::root;

/// The rooms that each room uses.
type Arrows = BTreeMap<String, BTreeSet<String>>;

/// The arrows between groups of rooms in the second drawing of the document.
fn drawn() -> Arrows {
    let text = fs::read_to_string(root().join("docs/architecture.md")).expect("the document");
    let drawing = text.split("```mermaid").nth(2).expect("a second drawing");
    let drawing = drawing.split("```").next().unwrap_or_default();
    let mut arrows = Arrows::new();
    for line in drawing.lines().filter(|line| line.contains("-->")) {
        let sides: Vec<Vec<String>> = line.split("-->").map(rooms).collect();
        for (from, to) in sides[0].iter().flat_map(|a| sides[1].iter().map(move |b| (a, b))) {
            arrows.entry(from.clone()).or_default().insert(to.clone());
        }
    }
    arrows
}

/// The rooms on one side of an arrow, without the text of their boxes.
fn rooms(side: &str) -> Vec<String> {
    let name = |room: &str| room.split('[').next().unwrap_or_default().trim().to_owned();
    side.split(" & ").map(name).collect()
}

/// The imports of the rooms of `src` without their tests.
fn imported() -> Arrows {
    let source = root().join("src");
    let mut arrows = Arrows::new();
    for file in files(&source) {
        let place = file.strip_prefix(&source).expect("below src").to_string_lossy().into_owned();
        let below = place.strip_prefix("stages/").unwrap_or(&place);
        let room = below.split('/').next().unwrap_or_default().trim_end_matches(".rs").to_owned();
        // The program is not part of the library.
        let is_list = place == "stages/mod.rs";
        if matches!(room.as_str(), "main" | "cli" | "lib") || is_list || place.ends_with("tests.rs")
        {
            continue;
        }
        let text = fs::read_to_string(&file).expect("a source file");
        let text = text.split("#[cfg(test)]").next().unwrap_or_default();
        let code = text.lines().filter(|line| !line.trim_start().starts_with("//"));
        let code = code.collect::<Vec<_>>().join("\n");
        let used = arrows.entry(room.clone()).or_default();
        used.extend(uses(&code));
        if code.contains("formats::") {
            used.insert("formats".into());
        }
        used.remove(&room);
    }
    arrows
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("it").path());
    let each = entries.map(|path| if path.is_dir() { files(&path) } else { vec![path] });
    each.flatten().filter(|path| path.extension().is_some_and(|end| end == "rs")).collect()
}

/// The rooms in the paths after `crate::`: of a single path, or of each one in braces.
fn uses(code: &str) -> BTreeSet<String> {
    let rooms = code.split("crate::").skip(1).flat_map(rooms_of);
    rooms.filter(|room| !room.is_empty()).collect()
}

/// The rooms of the paths that a text begins with. A stage is the room of a path below `stages`.
fn rooms_of(paths: &str) -> Vec<String> {
    let paths = paths.trim_start();
    if let Some(stages) = paths.strip_prefix("stages::") {
        return rooms_of(stages);
    }
    match paths.strip_prefix('{') {
        Some(list) => listed(list).into_iter().flat_map(rooms_of).collect(),
        None => vec![word(paths)],
    }
}

/// The paths of a list up to its closing brace.
fn listed(list: &str) -> Vec<&str> {
    let (mut depth, mut from) = (0, 0);
    let mut paths = Vec::new();
    for (at, c) in list.char_indices() {
        match c {
            '{' => depth += 1,
            '}' if depth == 0 => {
                paths.push(&list[from..at]);
                break;
            }
            '}' => depth -= 1,
            ',' if depth == 0 => {
                paths.push(&list[from..at]);
                from = at + 1;
            }
            _ => {}
        }
    }
    paths
}

fn word(text: &str) -> String {
    text.trim().chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect()
}

/// All rooms that a room uses directly or through others.
fn reached(arrows: &Arrows, from: &str) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    let mut left = vec![from.to_owned()];
    while let Some(room) = left.pop() {
        for to in arrows.get(&room).into_iter().flatten() {
            if found.insert(to.clone()) {
                left.push(to.clone());
            }
        }
    }
    found
}

#[test]
fn the_drawing_has_every_import_and_no_other() {
    let (drawn, imported) = (drawn(), imported());
    assert!(imported.len() > 15, "{imported:?}");
    for (room, uses) in &imported {
        let shown = reached(&drawn, room);
        for other in uses {
            assert!(shown.contains(other), "{room} uses {other}, which the drawing does not show");
        }
    }
    for (room, to) in drawn.iter().filter(|(room, _)| *room != "cli") {
        for other in to {
            let used = imported.get(room).is_some_and(|uses| uses.contains(other));
            assert!(used, "the drawing has an arrow from {room} to {other}, which is not used");
        }
    }
}

#[test]
fn no_arrow_runs_back_up() {
    let imported = imported();
    // What the root exports comes from the rooms, so no room takes it from the root.
    for (room, uses) in &imported {
        let root = uses.iter().find(|name| name.starts_with(char::is_uppercase));
        assert!(root.is_none(), "{room} takes {root:?} from the root and not from its room");
    }
    for room in imported.keys() {
        assert!(!reached(&imported, room).contains(room), "{room} uses itself by way of others");
    }
}

/// Cargo finds programs of tests, but not their modules.
#[test]
fn each_file_of_tests_is_a_module() {
    for program in ["library", "program"] {
        let folder = root().join("tests").join(program);
        let main = fs::read_to_string(folder.join("main.rs")).expect("a source file");
        let written: BTreeSet<_> =
            main.lines().filter_map(|line| line.strip_prefix("mod ")).collect();
        for file in files(&folder) {
            let name = file.file_stem().expect("a name").to_string_lossy();
            let is_module = name == "main" || written.contains(&*format!("{name};"));
            assert!(is_module, "{} is in no program", file.display());
        }
    }
}
