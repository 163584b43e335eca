//! OpenUSD beside this program, for layers that only it reads: its Python, or `usdcat`. No other program is started.

use std::ffi::OsString;
use std::path::Path;
use std::process::{Command, Stdio};
use tailor_usd::temporary_folder;

/// The Python that runs this program, which its package names. If it is empty, no OpenUSD is started.
const PYTHON: &str = "USDTAILOR_PYTHON";

/// Writes the layer of the first argument to the file of the second one, and prints the version. Modules in the current folder are
/// not imported.
const SCRIPT: &str = "
import sys
sys.path = [path for path in sys.path if path]
from pxr import Sdf, Usd
written = Sdf.Layer.FindOrOpen(sys.argv[1]).Export(sys.argv[2])
print('OpenUSD', '.'.join(str(part) for part in Usd.GetVersion()[1:]))
sys.exit(not written)
";

/// A layer as a crate, and the program that wrote it; none where no program can.
pub fn converted(layer: &str) -> Option<(Vec<u8>, String)> {
    let folder = temporary_folder().ok()?;
    let file = folder.path().join("layer.usdc");
    let read = |words: String| std::fs::read(&file).ok().map(|content| (content, words));
    let own = std::env::var_os(PYTHON);
    if own.as_ref().is_some_and(|own| own.is_empty()) {
        return None;
    }
    let pythons = own.into_iter().chain(["python3", "python"].map(OsString::from));
    let by_python = |python: OsString| {
        let mut command = Command::new(&python);
        let words = printed(command.args(["-c", SCRIPT, layer]).arg(&file))?;
        read(format!("{} ({})", words.trim(), Path::new(&python).file_name()?.display()))
    };
    pythons.into_iter().find_map(by_python).or_else(|| {
        printed(Command::new("usdcat").args([layer, "-o"]).arg(&file))?;
        read("usdcat".to_owned())
    })
}

/// The output of a program; none where it fails.
fn printed(command: &mut Command) -> Option<String> {
    let done = command.stdin(Stdio::null()).stderr(Stdio::null()).output().ok()?;
    done.status.success().then(|| String::from_utf8_lossy(&done.stdout).into_owned())
}
