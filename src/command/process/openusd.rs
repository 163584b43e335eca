//! OpenUSD beside this program, for what only it reads: its Python, or `usdcat`. No other program is started.

use std::ffi::{OsStr, OsString};
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};
use tailor_usd::{Foreign, Rewritten, temporary_folder};

/// The Python that runs this program, which its package names. If it is empty, no OpenUSD is started.
const PYTHON: &str = "USDTAILOR_PYTHON";

/// The time that a program may take for one layer or stage.
const LIMIT: Duration = Duration::from_secs(120);

/// The script of both kinds. Modules in the current folder are not imported.
const SCRIPT: &str = include_str!("openusd.py");

/// A layer or a stage as a crate, and the program that wrote it; none where no program can. `usdcat` tells no files of a stage, so that
/// it writes layers alone.
///
/// # Errors
/// A program that took too long.
pub fn converted(Foreign { path, is_stage }: Foreign<'_>) -> Result<Option<Rewritten>, String> {
    let own = std::env::var_os(PYTHON);
    let Some(folder) = temporary_folder().ok().filter(|_| own.as_ref().is_none_or(|own| !own.is_empty())) else {
        return Ok(None);
    };
    let file = folder.path().join("layer.usdc");
    let kind = if is_stage { "stage" } else { "layer" };
    let script: [&OsStr; 5] = ["-c".as_ref(), SCRIPT.as_ref(), path.as_ref(), file.as_ref(), kind.as_ref()];
    let pythons = own.into_iter().chain(["python3", "python"].map(OsString::from));
    let usdcat = || ("usdcat".into(), vec![path.as_ref(), "-o".as_ref(), file.as_ref()]);
    for (program, args) in pythons.map(|python| (python, script.to_vec())).chain((!is_stage).then(usdcat)) {
        let name = Path::new(&program).file_name().unwrap_or_default().display().to_string();
        let words = output(Command::new(&program).args(args), folder.path(), LIMIT).map_err(|limit| {
            format!("OpenUSD ({name}) was ended, as it took over {} seconds for {path}", limit.as_secs())
        })?;
        let Some((words, content)) = words.and_then(|words| Some((words, fs::read(&file).ok()?))) else { continue };
        let mut lines = words.lines();
        let version = lines.next().filter(|line| line.starts_with("OpenUSD"));
        let program = version.map_or(name.clone(), |version| format!("{version} ({name})"));
        return Ok(Some(Rewritten { content: content.into(), program, files: lines.map(PathBuf::from).collect() }));
    }
    Ok(None)
}

/// The output of a program, by way of a file in `folder`; none where it fails.
///
/// # Errors
/// The limit, if the program has not ended by then. It is killed.
fn output(command: &mut Command, folder: &Path, limit: Duration) -> Result<Option<String>, Duration> {
    let (file, started) = (folder.join("output"), Instant::now());
    let begun = File::create(&file)
        .and_then(|output| command.stdin(Stdio::null()).stdout(output).stderr(Stdio::null()).spawn());
    let Ok(mut child) = begun else { return Ok(None) };
    loop {
        match child.try_wait() {
            Ok(None) if started.elapsed() < limit => sleep(Duration::from_millis(10)),
            Ok(Some(status)) => return Ok(fs::read_to_string(&file).ok().filter(|_| status.success())),
            _ => break,
        }
    }
    // One that has ended in the meantime needs no end.
    let _ = child.kill();
    let _ = child.wait();
    Err(limit)
}

#[cfg(unix)]
#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_program_that_does_not_end_is_killed() {
        let folder = temporary_folder().expect("a folder");
        let (mark, started) = (folder.path().join("mark"), Instant::now());
        let run = |script: String| {
            output(Command::new("sh").args(["-c", &script]), folder.path(), Duration::from_millis(300))
        };
        let ended = run(format!("for i in 1 2 3 4 5 6 7 8 9 10; do sleep 0.1; done; touch {}", mark.display()));
        assert_eq!(ended, Err(Duration::from_millis(300)));
        assert!(started.elapsed() < Duration::from_millis(900));
        sleep(Duration::from_secs(1));
        assert!(!mark.exists(), "it is dead");
        assert_eq!(run("echo words".to_owned()), Ok(Some("words\n".to_owned())));
        assert_eq!(run("exit 3".to_owned()), Ok(None));
    }
}
