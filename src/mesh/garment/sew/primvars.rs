//! The primvars of several panels.

use super::merge::{Panel, Points};
use crate::connectivity::{Elements, VertexId};
use crate::error::{Warning, Warnings, names};
use crate::garment::{Garment, Interpolation, Meaning, Mixing, PrimvarInput, PrimvarRole, Values};
use std::collections::BTreeMap;
use std::mem::discriminant;

/// Primvars of skinning, the influences of a point, which are of one panel.
const SKINNING: &str = "skel:joint";

/// The primvars that all panels have, and warnings of others. Constant ones take the interpolation of the others, or are
/// uniform.
pub fn merge_primvars(prim: &str, panels: &[Panel], points: &Points) -> (Vec<PrimvarInput>, Warnings) {
    let mut keys: Vec<(&str, &PrimvarRole)> = Vec::new();
    for primvar in panels.iter().flat_map(|panel| &panel.mesh.primvars) {
        let key = (primvar.name.as_str(), &primvar.role);
        if !keys.contains(&key) {
            keys.push(key);
        }
    }
    let (mut merged, mut warnings) = (Vec::new(), Warnings::default());
    for (name, role) in keys {
        match shared(name, role, panels) {
            Ok((interpolation, primvars)) => {
                let (joined, warning) = join(prim, interpolation, &primvars, panels, points);
                merged.push(joined);
                warnings.extend(warning);
            }
            Err(why) => {
                let remedy = "Give all panels the same primvar, with one type and interpolation";
                warnings.push(Warning::not_carried(format!("{prim}.{}", property(name, role)), why).remedy(remedy));
            }
        }
    }
    (merged, warnings)
}

fn property(name: &str, role: &PrimvarRole) -> String {
    if *role == PrimvarRole::Primvar { format!("primvars:{name}") } else { name.to_owned() }
}

/// The primvar of each panel, and the interpolation of the garment's; or why there is none.
fn shared<'a>(
    name: &str,
    role: &PrimvarRole,
    panels: &'a [Panel],
) -> Result<(Interpolation, Vec<&'a PrimvarInput>), String> {
    if matches!(role, PrimvarRole::BlendShape { .. }) && panels.len() > 1 {
        return Err("blend shapes of panels that are sewn together stay on the panels".to_owned());
    }
    let of_panel = |panel: &'a Panel| {
        let found = panel.mesh.primvars.iter().find(|p| p.name == name && p.role == *role);
        found.ok_or(panel.mesh.prim.as_str())
    };
    let found: Vec<Result<&PrimvarInput, &str>> = panels.iter().map(of_panel).collect();
    let missing: Vec<&str> = found.iter().filter_map(|found| found.err()).collect();
    if !missing.is_empty() {
        return Err(format!("{} of {} sewn panels lack it: {}", missing.len(), panels.len(), names(&missing)));
    }
    let found: Vec<&PrimvarInput> = found.into_iter().flatten().collect();
    let first = found[0];
    let kind = |p: &PrimvarInput| (p.meaning, p.half, p.components, p.element_size, discriminant(&p.values));
    if let Some(i) = found.iter().position(|p| kind(p) != kind(first)) {
        let (a, b) = (&panels[0].mesh.prim, &panels[i].mesh.prim);
        return Err(format!("it is {} on {a} and {} on {b}", described(first), described(found[i])));
    }
    if let Some(i) = found.iter().position(|p| p.interpolation == Interpolation::Constant && rows(p) != Some(1)) {
        return Err(format!("it is a constant of several values on {}", panels[i].mesh.prim));
    }
    let varying = |p: &&PrimvarInput| p.interpolation != Interpolation::Constant;
    let interpolation = found.iter().copied().find(varying).map_or(Interpolation::Uniform, |p| p.interpolation);
    match found.iter().position(|p| varying(p) && p.interpolation != interpolation) {
        Some(i) => {
            let (other, prim) = (found[i].interpolation, &panels[i].mesh.prim);
            Err(format!("it is {interpolation:?} on one panel and {other:?} on {prim}"))
        }
        None => Ok((interpolation, found)),
    }
}

/// The values of one element in words.
fn described(primvar: &PrimvarInput) -> String {
    let number = match primvar.values {
        Values::F32(_) if primvar.half => "half",
        Values::F32(_) => "float",
        Values::F64(_) => "double",
        Values::Bool(_) => "bool",
        Values::U8(_) => "uchar",
        Values::I32(_) => "int",
        Values::U32(_) => "uint",
        Values::I64(_) => "int64",
        Values::U64(_) => "uint64",
        Values::Text(_) => "text",
    };
    let meaning = match primvar.meaning {
        Meaning::Plain => String::new(),
        meaning => format!(" ({meaning:?})"),
    };
    format!("{number} × {}{meaning} with elementSize {}", primvar.components, primvar.element_size)
}

/// Numbers in the row of one element.
fn width(primvar: &PrimvarInput) -> usize {
    primvar.components * primvar.element_size.max(1) as usize
}

/// The number of its rows, if they are whole.
fn rows(primvar: &PrimvarInput) -> Option<usize> {
    let width = width(primvar).max(1);
    primvar.values.len().is_multiple_of(width).then(|| primvar.values.len() / width)
}

/// Joins the values of a primvar. UVs that differ along a seam become face-varying. Warns where the sides of other seams disagree.
fn join(
    prim: &str,
    interpolation: Interpolation,
    primvars: &[&PrimvarInput],
    panels: &[Panel],
    points: &Points,
) -> (PrimvarInput, Option<Warning>) {
    let is_indexed = primvars.iter().any(|p| p.indices.is_some() || p.interpolation == Interpolation::Constant);
    let mut joined = PrimvarInput { interpolation, indices: None, ..primvars[0].clone() };
    let mut first_row = rows(primvars[0]).unwrap_or(0);
    for primvar in &primvars[1..] {
        joined.values.append(&primvar.values);
        first_row += rows(primvar).unwrap_or(0);
    }
    let of_panels: Vec<Vec<usize>> = primvars
        .iter()
        .zip(panels)
        .scan(0, |first, (primvar, panel)| {
            let rows_of = element_rows(primvar, interpolation, &panel.mesh, is_indexed);
            let rows_of = rows_of.into_iter().map(|row| *first + row).collect();
            *first += rows(primvar).unwrap_or(0);
            Some(rows_of)
        })
        .collect();
    let is_of_points = matches!(interpolation, Interpolation::Vertex | Interpolation::Varying);
    let of_corners = || corner_rows(&joined, &of_panels, panels, points);
    if let Some(corners) = (is_of_points && is_uvs(&joined)).then(of_corners).flatten() {
        let indices = Some(corners.into_iter().map(|row| row as i32).collect());
        return (PrimvarInput { interpolation: Interpolation::FaceVarying, indices, ..joined }, None);
    }
    let (rows, warning) = match is_of_points {
        true => point_rows(prim, &mut joined, first_row, &of_panels, points),
        false => (of_panels.concat(), None),
    };
    if is_indexed {
        joined.indices = Some(rows.into_iter().map(|row| row as i32).collect());
    } else if is_of_points {
        joined.values = joined.values.gather(width(&joined), rows.into_iter());
    }
    (joined, warning)
}

/// The row of each element of a panel.
fn element_rows(primvar: &PrimvarInput, as_if: Interpolation, mesh: &Garment, share: bool) -> Vec<usize> {
    let count = match as_if {
        Interpolation::Constant => 1,
        Interpolation::Uniform => mesh.face_vertex_counts.len(),
        Interpolation::Vertex | Interpolation::Varying => mesh.points.len(),
        Interpolation::FaceVarying => mesh.face_vertex_indices.len(),
    };
    match &primvar.indices {
        _ if primvar.interpolation == Interpolation::Constant => vec![0; count],
        Some(indices) => indices.iter().map(|&row| row as usize).collect(),
        // Corners of one value must share its row where other panels have indices: a cut is between different ones.
        None if share && as_if == Interpolation::FaceVarying => shared_rows(primvar, mesh),
        None => (0..count).collect(),
    }
}

/// The rows of corners without indices: those of one point and one value share the first.
fn shared_rows(primvar: &PrimvarInput, mesh: &Garment) -> Vec<usize> {
    let mut corners: Vec<(i32, usize)> = mesh.face_vertex_indices.iter().enumerate().map(|(c, &p)| (p, c)).collect();
    corners.sort_unstable();
    let (mut rows, width): (Vec<usize>, _) = ((0..corners.len()).collect(), width(primvar));
    for at_point in corners.chunk_by(|a, b| a.0 == b.0) {
        let mut firsts: Vec<usize> = Vec::new();
        for &(_, corner) in at_point {
            match firsts.iter().find(|&&first| primvar.values.same_rows(width, first, corner)) {
                Some(&first) => rows[corner] = first,
                None => firsts.push(corner),
            }
        }
    }
    rows
}

/// Whether its values are UVs, which a seam cuts.
fn is_uvs(primvar: &PrimvarInput) -> bool {
    let is_real = matches!(primvar.values, Values::F32(_) | Values::F64(_));
    is_real && primvar.components == 2 && matches!(primvar.meaning, Meaning::TextureCoordinate | Meaning::Plain)
}

/// The row of each corner of the garment, from those of points, if the sides of a seam have different values.
fn corner_rows(
    joined: &PrimvarInput,
    of_panels: &[Vec<usize>],
    panels: &[Panel],
    points: &Points,
) -> Option<Vec<usize>> {
    let width = width(joined);
    let first_alike = |row: usize, garment_point: usize| {
        let rows = points.sources[garment_point].iter().map(|&(panel, point)| of_panels[panel][point]);
        rows.into_iter().find(|&other| joined.values.same_rows(width, other, row)).unwrap_or(row)
    };
    let is_cut = points.sources.iter().any(|sources| {
        let mut rows = sources.iter().map(|&(panel, point)| of_panels[panel][point]);
        let first = rows.next();
        first.is_some_and(|first| !rows.all(|row| joined.values.same_rows(width, first, row)))
    });
    is_cut.then(|| {
        let corners = panels
            .iter()
            .enumerate()
            .flat_map(|(i, panel)| panel.mesh.face_vertex_indices.iter().map(move |&point| (i, point as usize)));
        corners.map(|(i, point)| first_alike(of_panels[i][point], points.of_panel[i][point])).collect()
    })
}

/// The row of each point of the garment. Where the sides of a seam disagree at a point, it gets their mean, or, for what has no
/// mean, the value of the first.
fn point_rows(
    prim: &str,
    joined: &mut PrimvarInput,
    mut next: usize,
    of_panels: &[Vec<usize>],
    points: &Points,
) -> (Vec<usize>, Option<Warning>) {
    let width = width(joined);
    let mixing = joined.values.mixing(joined.meaning);
    let is_mixed = matches!(mixing, Mixing::Linear | Mixing::Direction) && !joined.name.starts_with(SKINNING);
    let mut unlike = Vec::new();
    let mut means = BTreeMap::new();
    let mut rows = Vec::with_capacity(points.sources.len());
    for (point, sources) in points.sources.iter().enumerate() {
        let own: Vec<usize> = sources.iter().map(|&(panel, point)| of_panels[panel][point]).collect();
        let row = if own[1..].iter().all(|&row| joined.values.same_rows(width, own[0], row)) {
            own[0]
        } else {
            unlike.push(VertexId::new(point));
            match is_mixed {
                true => *means.entry(own.clone()).or_insert_with(|| {
                    joined.values.append_mean(width, &own, mixing == Mixing::Direction);
                    next += 1;
                    next - 1
                }),
                false => own[0],
            }
        };
        rows.push(row);
    }
    let warning = (!unlike.is_empty()).then(|| disagreement(prim, joined, is_mixed, unlike));
    (rows, warning)
}

/// The warning of points where panels have different values.
fn disagreement(prim: &str, primvar: &PrimvarInput, is_mixed: bool, unlike: Vec<VertexId>) -> Warning {
    let what = if is_mixed { "their mean" } else { "the value of the first side" };
    let problem = format!("the sides of a seam disagree at {} points, which get {what}", unlike.len());
    let place = format!("{prim}.{}", property(&primvar.name, &primvar.role));
    let warning = Warning::not_carried(place, problem).at(Elements::Points(unlike));
    warning.remedy("Paint both sides of the seam alike")
}

impl Values {
    /// Adds the values of another of the same kind; others are left out.
    fn append(&mut self, others: &Self) {
        match (self, others) {
            (Self::F32(a), Self::F32(b)) => a.extend(b),
            (Self::F64(a), Self::F64(b)) => a.extend(b),
            (Self::Bool(a), Self::Bool(b)) => a.extend(b),
            (Self::U8(a), Self::U8(b)) => a.extend(b),
            (Self::I32(a), Self::I32(b)) => a.extend(b),
            (Self::U32(a), Self::U32(b)) => a.extend(b),
            (Self::I64(a), Self::I64(b)) => a.extend(b),
            (Self::U64(a), Self::U64(b)) => a.extend(b),
            (Self::Text(a), Self::Text(b)) => a.extend(b.iter().cloned()),
            _ => {}
        }
    }

    /// Adds the mean of some rows of `width` numbers, of unit length for a direction.
    fn append_mean(&mut self, width: usize, rows: &[usize], is_direction: bool) {
        let mean = |at: &dyn Fn(usize) -> f64| {
            let number = |i: usize| rows.iter().map(|row| at(row * width + i)).sum::<f64>() / rows.len() as f64;
            let mean: Vec<f64> = (0..width).map(number).collect();
            let length = mean.iter().map(|x| x * x).sum::<f64>().sqrt();
            let scale = if is_direction && length > 0.0 { length.recip() } else { 1.0 };
            mean.into_iter().map(move |x| x * scale)
        };
        match self {
            Self::F32(v) => {
                let mean: Vec<f32> = mean(&|i| f64::from(v[i])).map(|x| x as f32).collect();
                v.extend(mean);
            }
            Self::F64(v) => {
                let mean: Vec<f64> = mean(&|i| v[i]).collect();
                v.extend(mean);
            }
            _ => {}
        }
    }
}
