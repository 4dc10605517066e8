//! OpenCASCADE and FreeCAD, each in its own process.

use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

use super::root;

/// The properties of a file in OpenCASCADE. With `points`, it also returns their distances.
pub fn opencascade(file: &Path, points: Option<&[[f64; 3]]>) -> Value {
    let mut command = opencascade_script("check_occ.py");
    command.arg(file);
    let list = tempfile::NamedTempFile::new().expect("a temporary file");
    if let Some(points) = points {
        let lines = points.iter().map(|[x, y, z]| format!("{x:?} {y:?} {z:?}\n"));
        std::fs::write(list.path(), lines.collect::<String>()).expect("a temporary file");
        command.arg("--points").arg(list.path());
    }
    answer(command)
}

/// The properties of a file in OpenCASCADE, which heals it.
pub fn opencascade_healed(file: &Path) -> Value {
    let mut command = opencascade_script("check_occ.py");
    command.arg(file).arg("--healed");
    answer(command)
}

/// The properties of a solid's file in OpenCASCADE without healing.
pub fn opencascade_solid(file: &Path) -> Value {
    let mut command = opencascade_script("check_solid_occ.py");
    command.arg(file);
    answer(command)
}

/// The tree of an assembly's file in OpenCASCADE without healing.
pub fn opencascade_assembly(file: &Path) -> Value {
    let mut command = opencascade_script("check_assembly_occ.py");
    command.arg(file);
    answer(command)
}

/// The places of the meshes of a 3MF file in lib3mf. Null if it does not open the file.
pub fn lib3mf_places(file: &Path) -> Value {
    let mut command = opencascade_script("places_3mf.py");
    command.arg(file);
    answer(command)
}

/// Makes meshes of random parts in a folder, and the truth about each.
pub fn make_random_parts(folder: &Path, seeds: &[u32]) {
    run(&mut random_parts("make", folder, seeds));
}

/// The properties of the STEP files of random parts in OpenCASCADE without healing, for each seed.
pub fn check_random_parts(folder: &Path, seeds: &[u32]) -> Value {
    answer(random_parts("check", folder, seeds))
}

fn random_parts(task: &str, folder: &Path, seeds: &[u32]) -> Command {
    let mut command = opencascade_script("random_parts.py");
    command.arg(task).arg(folder).args(seeds.iter().map(u32::to_string));
    command
}

/// The properties of a solid's file in FreeCAD, and the results of operations on it. `None` if
/// FreeCAD is absent on purpose.
pub fn freecad_solid(file: &Path) -> Option<Value> {
    let mut command = freecad_script("check_solid_freecad.py")?;
    command.arg(file);
    Some(answer(command))
}

/// Makes meshes of a designer's parts in a folder, and the truth about each.
pub fn make_parts(folder: &Path) {
    run(opencascade_script("operate_occ.py").arg("make").arg(folder));
}

/// What a designer's next steps on a solid give in OpenCASCADE.
pub fn opencascade_operations(file: &Path) -> Value {
    let mut command = opencascade_script("operate_occ.py");
    command.arg(file);
    answer(command)
}

/// What a designer's next steps on a solid give in FreeCAD. `None` if FreeCAD is absent on purpose.
pub fn freecad_operations(file: &Path) -> Option<Value> {
    let mut command = freecad_script("operate_freecad.py")?;
    command.arg(file);
    Some(answer(command))
}

/// Makes CAD files of each kind of surface, curve and placement in a folder, and the truth about each.
pub fn make_kinds(folder: &Path) {
    run(opencascade_script("make_kinds.py").arg(folder));
}

/// Lets OpenCASCADE read a file and write it to a folder again.
pub fn rewrite_opencascade(file: &Path, folder: &Path) {
    let mut command = opencascade_script("rewrite_occ.py");
    run(command.arg(file).arg(folder));
}

fn opencascade_script(name: &str) -> Command {
    let python = root().join("target/occ/bin/python");
    assert!(
        python.exists(),
        "OpenCASCADE is absent. Install it with:\n  \
         python3 -m venv target/occ && target/occ/bin/pip install -r tests/roundtrip/requirements.txt"
    );
    let mut command = Command::new(python);
    command.arg("-B").arg(script(name));
    command
}

/// The properties of a file in FreeCAD. `None` if FreeCAD is absent on purpose.
pub fn freecad(file: &Path) -> Option<Value> {
    let mut command = freecad_script("check_freecad.py")?;
    command.arg(file);
    Some(answer(command))
}

/// Lets FreeCAD cut, offset and thicken the face in a file and write the results to a folder.
/// Returns their areas. `None` if FreeCAD is absent on purpose.
pub fn rewrite_freecad(file: &Path, folder: &Path, distance: f64) -> Option<Value> {
    let mut command = freecad_script("rewrite_freecad.py")?;
    command.arg(file).arg(folder).arg(distance.to_string());
    Some(answer(command))
}

/// `FREECAD_LIB` is the folder of FreeCAD's modules if it is not that of Debian. The value `none`
/// means that there is no FreeCAD.
fn freecad_script(name: &str) -> Option<Command> {
    let library = Path::new("/usr/lib/freecad-python3/lib");
    let set = std::env::var_os("FREECAD_LIB").map(PathBuf::from);
    if set.as_deref() == Some(Path::new("none")) {
        eprintln!("NOT TESTED: {name}, since FREECAD_LIB=none");
        return None;
    }
    assert!(
        set.is_some() || library.exists(),
        "FreeCAD is absent. Install it with:\n  \
         sudo apt-get install -y --no-install-recommends freecad-python3"
    );
    let mut command = Command::new("/usr/bin/python3");
    command.arg("-B").arg(script(name));
    Some(command)
}

fn script(name: &str) -> PathBuf {
    root().join("tests/roundtrip").join(name)
}

/// The output of an importer as JSON.
fn answer(mut command: Command) -> Value {
    let text = run(&mut command);
    serde_json::from_str(&text).unwrap_or_else(|e| panic!("{command:?}: {e} in {text}"))
}

/// Runs an importer, which must succeed, and returns its output.
fn run(command: &mut Command) -> String {
    let output = command.output().expect("the importer runs");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{command:?}: {said}");
    String::from_utf8_lossy(&output.stdout).into_owned()
}
