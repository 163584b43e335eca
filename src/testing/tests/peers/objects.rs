//! Meshes to and from other remeshers, as OBJ files with a line of what they took.

use glam::Vec3;
use std::fmt::Write as _;
use std::path::Path;
use tailor::sim::Baseline;
use tailor_mesh::connectivity::VertexId;

/// The mesh of another remesher.
pub struct Other {
    /// The remesher.
    pub name: String,
    /// Time of remeshing alone.
    pub milliseconds: f64,
    pub points: Vec<Vec3>,
    pub triangles: Vec<[usize; 3]>,
}

/// Writes a surface as `NAME.obj`: its triangles, a line `l` for each constrained edge, and the mean target length.
pub fn write(folder: &Path, name: &str, baseline: &Baseline) {
    let mut text = String::new();
    let mean = baseline.target.iter().map(|&t| f64::from(t)).sum::<f64>() / baseline.target.len() as f64;
    let _ = writeln!(text, "# length {mean}");
    for p in baseline.points.iter() {
        let _ = writeln!(text, "v {} {} {}", p.x, p.y, p.z);
    }
    for face in baseline.topology.faces.ids() {
        let [a, b, c] = [0, 1, 2].map(|k| baseline.topology.faces.vertices_of(face)[k].index() + 1);
        let _ = writeln!(text, "f {a} {b} {c}");
    }
    for pair in baseline.chains.iter().filter(|c| !c.kind.feature).flat_map(|c| c.vertices.windows(2)) {
        let [a, b] = [pair[0], pair[1]].map(|v: VertexId| v.index() + 1);
        let _ = writeln!(text, "l {a} {b}");
    }
    let file = folder.join(format!("{name}.obj"));
    std::fs::write(&file, text).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
}

/// The files `NAME.REMESHER.obj` in a folder, by remesher.
pub fn others(folder: &Path, name: &str) -> Vec<Other> {
    let entries = std::fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    let mut files: Vec<_> = entries.filter_map(|e| Some(e.ok()?.path())).collect();
    files.sort();
    let of = |file: &Path| {
        let own = file.file_name()?.to_str()?;
        let remesher = own.strip_prefix(name)?.strip_prefix('.')?.strip_suffix(".obj")?;
        Some(read(file, remesher))
    };
    files.iter().filter_map(|f| of(f)).collect()
}

fn read(file: &Path, name: &str) -> Other {
    let text = std::fs::read_to_string(file).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
    let mut other = Other { name: name.into(), milliseconds: 0.0, points: Vec::new(), triangles: Vec::new() };
    for line in text.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        let number = |i: usize| words.get(i).and_then(|w| w.parse::<f64>().ok()).unwrap_or(0.0);
        let index = |i: usize| words.get(i).and_then(|w| w.split('/').next()?.parse::<usize>().ok()).unwrap_or(1) - 1;
        match words.first() {
            Some(&"v") => other.points.push(Vec3::new(number(1) as f32, number(2) as f32, number(3) as f32)),
            Some(&"f") => other.triangles.push([index(1), index(2), index(3)]),
            Some(&"#") if words.get(1) == Some(&"milliseconds") => other.milliseconds = number(2),
            _ => {}
        }
    }
    other
}
