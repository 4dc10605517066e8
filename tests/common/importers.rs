//! OpenCASCADE and FreeCAD, each in its own process.

use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdout, Command, Stdio};
use std::sync::{Mutex, PoisonError};

use serde_json::Value;

use super::{arg, root};

/// The properties of a file in OpenCASCADE. With `points`, it also returns their distances.
pub fn opencascade(file: &Path, points: Option<&[[f64; 3]]>) -> Value {
    let list = tempfile::NamedTempFile::new().expect("a temporary file");
    let mut arguments = vec![arg(file)];
    if let Some(points) = points {
        let lines = points.iter().map(|[x, y, z]| format!("{x:?} {y:?} {z:?}\n"));
        std::fs::write(list.path(), lines.collect::<String>()).expect("a temporary file");
        arguments.extend(["--points", arg(list.path())]);
    }
    opencascade_answer("check_occ.py", &arguments)
}

/// The properties of a file in OpenCASCADE, which heals it.
pub fn opencascade_healed(file: &Path) -> Value {
    opencascade_answer("check_occ.py", &[arg(file), "--healed"])
}

/// The properties of a solid's file in OpenCASCADE without healing.
pub fn opencascade_solid(file: &Path) -> Value {
    opencascade_answer("check_solid_occ.py", &[arg(file)])
}

/// The tree of an assembly's file in OpenCASCADE without healing.
pub fn opencascade_assembly(file: &Path) -> Value {
    opencascade_answer("check_assembly_occ.py", &[arg(file)])
}

/// The places of the meshes of a 3MF file in lib3mf. Null if it does not open the file.
pub fn lib3mf_places(file: &Path) -> Value {
    opencascade_answer("places_3mf.py", &[arg(file)])
}

/// Makes meshes of random parts in a folder, and the truth about each.
pub fn make_random_parts(folder: &Path, seeds: &[u32]) {
    random_parts("make", folder, seeds);
}

/// The properties of the STEP files of random parts in OpenCASCADE without healing, for each seed.
pub fn check_random_parts(folder: &Path, seeds: &[u32]) -> Value {
    parsed(&random_parts("check", folder, seeds))
}

fn random_parts(task: &str, folder: &Path, seeds: &[u32]) -> String {
    let seeds: Vec<String> = seeds.iter().map(u32::to_string).collect();
    let mut arguments = vec![task, arg(folder)];
    arguments.extend(seeds.iter().map(String::as_str));
    opencascade_run("random_parts.py", &arguments)
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
    opencascade_run("operate_occ.py", &["make", arg(folder)]);
}

/// What a designer's next steps on a solid give in OpenCASCADE.
pub fn opencascade_operations(file: &Path) -> Value {
    opencascade_answer("operate_occ.py", &[arg(file)])
}

/// What a designer's next steps on a solid give in FreeCAD. `None` if FreeCAD is absent on purpose.
pub fn freecad_operations(file: &Path) -> Option<Value> {
    let mut command = freecad_script("operate_freecad.py")?;
    command.arg(file);
    Some(answer(command))
}

/// Makes CAD files of each kind of surface, curve and placement in a folder, and the truth about each.
pub fn make_kinds(folder: &Path) {
    opencascade_run("make_kinds.py", &[arg(folder)]);
}

/// Lets OpenCASCADE read a file and write it to a folder again.
pub fn rewrite_opencascade(file: &Path, folder: &Path) {
    opencascade_run("rewrite_occ.py", &[arg(file), arg(folder)]);
}

/// The output of a script with OpenCASCADE as JSON.
fn opencascade_answer(script: &str, arguments: &[&str]) -> Value {
    parsed(&opencascade_run(script, arguments))
}

/// Runs a script with OpenCASCADE, which must succeed, and returns its output.
fn opencascade_run(script: &str, arguments: &[&str]) -> String {
    /// The servers that no test uses now. There are as many as tests that ever used one at the same time.
    static FREE: Mutex<Vec<Server>> = Mutex::new(Vec::new());
    let free = || FREE.lock().unwrap_or_else(PoisonError::into_inner);
    let server = free().pop();
    let mut server = server.unwrap_or_else(Server::start);
    let answer = server.answer(script, arguments);
    free().push(server);
    assert!(
        answer["status"] == 0,
        "{script} {arguments:?}: {}: {}",
        answer["status"],
        answer["said"]
    );
    answer["output"].as_str().expect("a text").to_owned()
}

/// A process that has imported OpenCASCADE, which takes longer than most scripts, and runs each script in a fork.
/// It ends when its input does, at the latest with this process.
struct Server {
    process: Child,
    answers: BufReader<ChildStdout>,
}

impl Server {
    fn start() -> Self {
        let python = root().join("target/occ/bin/python");
        assert!(
            python.exists(),
            "OpenCASCADE is absent. Install it with:\n  \
             python3 -m venv target/occ && target/occ/bin/pip install -r tests/roundtrip/requirements.txt"
        );
        let mut command = Command::new(python);
        command.arg("-B").arg(script("serve.py")).arg("check_occ.py");
        command.stdin(Stdio::piped()).stdout(Stdio::piped());
        let mut process = command.spawn().expect("Python runs");
        let answers = BufReader::new(process.stdout.take().expect("it is piped"));
        Self { process, answers }
    }

    fn answer(&mut self, script: &str, arguments: &[&str]) -> Value {
        let request = serde_json::json!([&[script], arguments].concat());
        let mut input = self.process.stdin.as_ref().expect("it is piped");
        writeln!(input, "{request}").expect("the server of OpenCASCADE reads");
        let mut answer = String::new();
        self.answers.read_line(&mut answer).expect("the server of OpenCASCADE answers");
        parsed(&answer)
    }
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
    let output = command.output().expect("the importer runs");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{command:?}: {said}");
    parsed(&String::from_utf8_lossy(&output.stdout))
}

fn parsed(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|e| panic!("{e} in {text}"))
}
