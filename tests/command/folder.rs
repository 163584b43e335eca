//! A folder that goes away with the test, and the command run in it.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

/// A folder with an empty `out` in it.
pub struct Folder(tempfile::TempDir);

/// What a run of the command gave.
pub struct Run {
    /// The arguments, for messages.
    pub shown: String,
    /// The exit code; none where a signal ended it.
    pub code: Option<i32>,
    /// Standard output.
    pub stdout: String,
    /// Standard error.
    pub stderr: String,
}

impl Folder {
    pub fn new() -> Self {
        let folder = Self(tempfile::tempdir().expect("a folder for the test"));
        fs::create_dir(folder.at("out")).expect("an output folder");
        folder
    }

    pub fn at(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Writes a file.
    pub fn file(&self, name: &str, bytes: impl AsRef<[u8]>) {
        fs::write(self.at(name), bytes).expect("a file of the test");
    }

    /// The content of a file.
    #[track_caller]
    pub fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.at(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    /// The content of a text file.
    #[track_caller]
    pub fn text(&self, name: &str) -> String {
        String::from_utf8(self.read(name)).expect("text is UTF-8")
    }

    /// The command in this folder, with arguments that are separated by blanks.
    pub fn command(&self, args: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_usdtailor"));
        command.current_dir(self.0.path()).args(args.split_whitespace()).stdin(Stdio::null());
        command
    }

    /// Runs the command.
    pub fn run(&self, args: &str) -> Run {
        Run::of(args, &mut self.command(args))
    }

    /// Runs a shell script in this folder; `"$@"` is the command with its arguments.
    #[cfg(unix)]
    pub fn run_in_shell(&self, script: &str, args: &str) -> Run {
        let mut shell = Command::new("sh");
        shell.current_dir(self.0.path()).args(["-c", script, "sh", env!("CARGO_BIN_EXE_usdtailor")]);
        Run::of(args, shell.args(args.split_whitespace()).stdin(Stdio::null()))
    }

    /// Runs the command, which must succeed.
    #[track_caller]
    pub fn good(&self, args: &str) -> Run {
        let run = self.run(args);
        assert_eq!(run.code, Some(0), "{run}");
        run
    }

    /// Every file below the folder with its bytes, every folder, and every link with its target.
    pub fn snapshot(&self) -> BTreeMap<PathBuf, Vec<u8>> {
        let mut all = BTreeMap::new();
        collect(self.0.path(), &mut all);
        all
    }

    /// Names in the output folder.
    pub fn written(&self) -> Vec<String> {
        let entries = fs::read_dir(self.at("out")).expect("the output folder");
        let mut names: Vec<String> =
            entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }
}

fn collect(folder: &Path, all: &mut BTreeMap<PathBuf, Vec<u8>>) {
    for entry in fs::read_dir(folder).expect("a folder of the test") {
        let path = entry.expect("an entry").path();
        let kind = fs::symlink_metadata(&path).expect("an entry").file_type();
        if kind.is_symlink() {
            let target = fs::read_link(&path).expect("a link");
            all.insert(path, format!("link to {}", target.display()).into_bytes());
        } else if kind.is_dir() {
            all.insert(path.clone(), b"folder".to_vec());
            collect(&path, all);
        } else {
            let bytes = fs::read(&path).expect("a file of the test");
            all.insert(path, bytes);
        }
    }
}

impl Run {
    fn of(args: &str, command: &mut Command) -> Self {
        let Output { status, stdout, stderr } = command.output().expect("the command starts");
        let text = |bytes| String::from_utf8(bytes).expect("what is printed is UTF-8");
        Self { shown: args.into(), code: status.code(), stdout: text(stdout), stderr: text(stderr) }
    }

    /// Checks that standard error has each of `parts`.
    #[track_caller]
    pub fn says(&self, parts: &[&str]) {
        for part in parts {
            assert!(self.stderr.contains(part), "{part:?} is not said by {self}");
        }
    }

    /// Checks that standard output has each of `parts`.
    #[track_caller]
    pub fn prints(&self, parts: &[&str]) {
        for part in parts {
            assert!(self.stdout.contains(part), "{part:?} is not printed by {self}");
        }
    }
}

impl std::fmt::Display for Run {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { shown, code, stdout, stderr } = self;
        write!(f, "usdtailor {shown}\nexit code {code:?}\n--- stdout\n{stdout}\n--- stderr\n{stderr}")
    }
}
