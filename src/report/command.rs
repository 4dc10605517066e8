//! The command line that makes the files of a report again.

use super::file_name;

/// How options of `convert` begin whose value is a file.
const FILE_OPTIONS: [&str; 2] = ["--report=", "--stages="];

/// The words of a command as a shell reads them. Files have their names without folders: the
/// command is run in the folder of the scan, and tells nobody where that was.
///
/// The words are those of [`Report::command`](super::Report::command): the program, its command,
/// the files, the options.
pub(super) fn shell_words(words: &[&str]) -> Vec<String> {
    let program = words.iter().take(2).map(|word| quoted(word));
    let arguments = words.iter().skip(2).map(|word| quoted(&without_folder(word)));
    program.chain(arguments).collect()
}

/// An argument, with the name of its file without the folder.
fn without_folder(word: &str) -> String {
    let option = FILE_OPTIONS.iter().find(|option| word.starts_with(**option));
    match option {
        Some(option) => format!("{option}{}", file_name(&word[option.len()..])),
        None if word.starts_with('-') => word.to_owned(),
        None => named(word),
    }
}

/// The name of a file as a word that no program takes for an option.
fn named(path: &str) -> String {
    let name = file_name(path);
    if name.starts_with('-') { format!("./{name}") } else { name }
}

/// A word as POSIX shells take it: in single quotes unless it only has plain characters.
fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_./,:=+@%".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        return word.to_owned();
    }
    format!("'{}'", word.replace('\'', r"'\''"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shell_reads_the_words_again() {
        let words = [
            "scan2step",
            "convert",
            "/tmp/a b/it's $HOME.ply",
            "./-x.step",
            "--box=0,0,0;9,9,9",
            "--report=/tmp/r.html",
            "--smooth=4",
        ];
        let line = r"scan2step convert 'it'\''s $HOME.ply' ./-x.step '--box=0,0,0;9,9,9' --report=r.html --smooth=4";
        assert_eq!(shell_words(&words).join(" "), line);
        assert_eq!(shell_words(&["scan2step", "convert", ""]), ["scan2step", "convert", "''"]);
    }
}
