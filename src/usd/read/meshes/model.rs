//! Panels that are sewn together as one model.

use super::recipe;
use crate::names;
use crate::read::bindings::resolve_inherited;
use crate::read::facts::{material_paths, materials};
use crate::read::model::{Model, Sewing, SubsetRecord};
use crate::read::primvars::{Declarations, read_primvar};
use crate::read::query::prim_at;
use crate::read::recipe::add_constraint;
use crate::read::source::{PanelSeam, Source};
use crate::read::space::{Transforms, space as space_of, transforms};
use crate::read::surroundings::siblings;
use crate::record::{Content, Record};
use glam::DMat4;
use openusd::sdf::Path;
use openusd::usd::{Stage, TimeCode};
use std::collections::BTreeMap;
use std::sync::Arc;
use tailor_mesh::error::{Error, Warning, Warnings};
use tailor_mesh::garment::sew::{Panel, Seams, Sewn, merge, place};
use tailor_mesh::garment::{Elements, Interpolation, Units};

/// Names of panels in that of the garment.
const NAMED: usize = 3;
/// Prefixes of properties of skinning.
const SKINNING: [&str; 2] = ["skel:", "primvars:skel:"];

/// The garment of the meshes number `members`: the mesh itself, or the panels sewn together. It has its name from the first.
///
/// # Errors
/// Panels that cannot be one mesh, or whose options contradict each other.
pub fn sewn(
    stage: &Stage,
    sources: &mut [Source],
    members: &[usize],
    seams: &Seams,
    time: Option<TimeCode>,
) -> Result<Source, Error> {
    if let &[lone] = members {
        return Ok(sources[lone].clone());
    }
    let parent = common_parent(sources, members);
    for &member in members {
        let model = &mut sources[member].model;
        resolve_inherited(&prim_at(stage, &model.path)?, &parent, model)?;
    }
    let panels: Vec<&Source> = members.iter().map(|&i| &sources[i]).collect();
    let first = panels[0];
    let space = transforms(&prim_at(stage, &parent)?, time)?.to_world;
    let to_space = to_space(&panels, &parent, space)?;
    check_skinning(&panels, &to_space)?;
    let of_panels = panels.iter().flat_map(|panel| panel.warnings.iter().cloned());
    let mut warnings: Warnings = of_panels.map(with_faces_in_words).collect();
    let mut declarations = declarations(&panels);
    let (carried, unlike) = warnings.absorb(shared_properties(&panels));
    let mut meshes = Vec::with_capacity(panels.len());
    for (panel, to_space) in panels.iter().zip(&to_space) {
        let mut mesh = panel.garment.clone()?;
        let prim = prim_at(stage, &panel.model.path)?;
        for name in &unlike {
            match read_primvar(&prim, name, Interpolation::Constant, time, &mut declarations) {
                Ok(primvar) => mesh.primvars.extend(primvar),
                Err(e) => warnings.push(Warning::unread(format!("{}.primvars:{name}", panel.prim()), &e)),
            }
        }
        place(&mut mesh, to_space);
        meshes.push(Panel { name: panel.model.path.name().unwrap_or("panel").to_owned(), mesh });
    }
    let mut model = Model {
        panels: panels.iter().map(|panel| panel.model.path.clone()).collect(),
        parent,
        carried,
        declarations,
        applied: union(panels.iter().map(|panel| &panel.model.applied)),
        staying: union(panels.iter().map(|panel| &panel.model.staying)),
        below: union(panels.iter().map(|panel| &panel.model.below)),
        transforms: Transforms { to_parent: DMat4::IDENTITY, to_world: space },
        ..first.model.clone()
    };
    let units = units(first, space);
    let mut sewn = merge(name(&model), units, meshes, &welds(members, seams))?;
    warnings.extend(std::mem::take(&mut sewn.warnings));
    model.sewing = Sewing { sets: sewn.panels.clone(), points: points(&panels, &sewn), edges: Vec::new() };
    model.siblings = Arc::new(siblings(stage, &model)?);
    model.subsets = subset_records(&panels)?;
    move_materials(&panels, &mut model, &mut sewn);
    let of_panels = panels.iter().map(|panel| Ok((panel.prim(), panel.recipe.clone()?)));
    let recipe = of_panels.collect::<Result<Vec<_>, Error>>().and_then(|panels| {
        let mut options = recipe::merge(&panels)?;
        add_constraint(&mut options, &sewn.seams);
        Ok(options)
    });
    let mut facts = first.facts.clone();
    facts.prim = sewn.mesh.prim.clone();
    facts.transform = Vec::new();
    facts.staying = model.staying.clone();
    facts
        .constant_primvars
        .retain(|name| model.carried.iter().any(|r| r.name.strip_prefix(names::PRIMVARS) == Some(name)));
    facts.bindings = union(panels.iter().map(|panel| &panel.facts.bindings));
    facts.api_schemas = union(panels.iter().map(|panel| &panel.facts.api_schemas));
    facts.variants = union(panels.iter().map(|panel| &panel.facts.variants));
    let between = seams.seams.iter().filter(|seam| members.contains(&seam.panels[0]));
    let between = between.map(|seam| PanelSeam {
        panels: seam.panels.map(|panel| sources[panel].prim().to_owned()),
        edges: seam.edges,
        gap: seam.gap,
    });
    let within = panels.iter().flat_map(|panel| panel.seams.iter().cloned());
    let seams = within.chain(between).collect();
    sewn.mesh.space = space_of(stage, &space)?;
    let bound = material_paths(&model, &facts);
    sewn.mesh.materials = materials(&bound);
    Ok(Source { model, garment: Ok(sewn.mesh), recipe, facts, warnings, seams, fitted: None })
}

/// The nearest prim above all panels.
fn common_parent(sources: &[Source], members: &[usize]) -> Path {
    let mut parent = sources[members[0]].model.parent.clone();
    while !members.iter().all(|&member| sources[member].model.parent.has_prefix(&parent)) {
        parent = parent.parent().unwrap_or_else(Path::abs_root);
    }
    parent
}

/// The transform of each panel to the space of the garment.
fn to_space(panels: &[&Source], parent: &Path, space: DMat4) -> Result<Vec<DMat4>, Error> {
    let inverse = space.inverse();
    let of_panel = |panel: &&Source| {
        let transforms = &panel.model.transforms;
        let matrix = if panel.model.parent == *parent { transforms.to_parent } else { inverse * transforms.to_world };
        let is_usable = matrix.is_finite() && matrix.determinant() != 0.0;
        is_usable.then_some(matrix).ok_or_else(|| {
            let fault = Error::usd(format!("{} has a transform to {parent} that flattens it", panel.prim()));
            fault.code(tailor_mesh::codes::PANELS_DIFFER).remedy("give it scales that are not 0")
        })
    };
    panels.iter().map(of_panel).collect()
}

/// Joints move the points of all panels in one space, so skinned panels must be in it already.
fn check_skinning(panels: &[&Source], to_space: &[DMat4]) -> Result<(), Error> {
    let of_skin = |panel: &&Source| -> Vec<Record> {
        let is_of_skin = |record: &&Record| SKINNING.iter().any(|prefix| record.name.starts_with(prefix));
        panel.model.carried.iter().filter(is_of_skin).cloned().collect()
    };
    let skins: Vec<Vec<Record>> = panels.iter().map(of_skin).collect();
    let has_joints = |panel: &&Source| {
        let mesh = panel.garment.as_ref();
        mesh.is_ok_and(|mesh| mesh.primvars.iter().any(|p| p.name.starts_with(SKINNING[0])))
    };
    if skins.iter().all(Vec::is_empty) && !panels.iter().any(has_joints) {
        return Ok(());
    }
    let odd = skins.iter().position(|skin| *skin != skins[0]);
    if let Some(i) = odd.or_else(|| to_space.iter().position(|m| *m != DMat4::IDENTITY).map(|i| i.max(1))) {
        let what =
            if odd.is_some() { "their skeleton, joints or bind transform differ" } else { "they have transforms" };
        let text =
            format!("{}, {}: they are skinned and sewn together, and {what}", panels[0].prim(), panels[i].prim());
        let remedy = "bind both to the same joints, with their transforms in their points";
        return Err(Error::usd(text).code(tailor_mesh::codes::PANELS_DIFFER).remedy(remedy));
    }
    Ok(())
}

fn declarations(panels: &[&Source]) -> Declarations {
    let mut all = Declarations::default();
    for own in panels.iter().rev().map(|panel| panel.model.declarations.clone()) {
        all.primvars.extend(own.primvars);
        all.assets.extend(own.assets);
    }
    all
}

/// The properties that all panels have alike, and the constant primvars that they have not. Others become warnings, except for
/// transforms, which the points have, and materials, which face sets have.
fn shared_properties(panels: &[&Source]) -> ((Vec<Record>, Vec<String>), Warnings) {
    let is_elsewhere =
        |name: &str| name.starts_with(names::XFORM_OP) || name == names::XFORM_OP_ORDER || names::is_material(name);
    let (mut shared, mut unlike, mut warnings) = (Vec::new(), Vec::<String>::new(), Warnings::default());
    let of = |panel: &&Source, name: &str| panel.model.carried.iter().find(|r| r.name == name).cloned();
    for name in union(panels.iter().map(|panel| panel.model.carried.iter().map(|record| &record.name))) {
        let records: Vec<Option<Record>> = panels.iter().map(|panel| of(panel, &name)).collect();
        if let Some(record) = records[0].as_ref().filter(|_| records.iter().all(|record| *record == records[0])) {
            if !name.starts_with(names::XFORM_OP) && name != names::XFORM_OP_ORDER {
                shared.push(record.clone());
            }
            warnings.extend(moves(record, panels[0].prim()));
            continue;
        }
        if let Some(primvar) = name.strip_prefix(names::PRIMVARS) {
            let primvar = primvar.strip_suffix(names::INDICES_SUFFIX).unwrap_or(primvar).to_owned();
            if !unlike.contains(&primvar) {
                unlike.push(primvar);
            }
        } else if !is_elsewhere(&name) {
            let panels: Vec<&str> = panels.iter().map(|panel| panel.prim()).collect();
            let why = "panels that are sewn together do not have it alike";
            warnings.push(Warning::not_carried(format!("{name} of {}", panels.join(", ")), why));
        }
        for (panel, record) in panels.iter().zip(&records) {
            warnings.extend(record.as_ref().and_then(|record| moves(record, panel.prim())));
        }
    }
    shared.retain(|r| {
        !r.name.strip_prefix(names::PRIMVARS).is_some_and(|name| {
            unlike.iter().any(|unlike| name.strip_suffix(names::INDICES_SUFFIX).unwrap_or(name) == unlike)
        })
    });
    ((shared, unlike), warnings)
}

/// The warning of a transform that moves with time, as the points of the garment do not.
fn moves(record: &Record, panel: &str) -> Option<Warning> {
    let Content::Attribute { samples: Some(samples), .. } = &record.content else { return None };
    let is_moving = record.name.starts_with(names::XFORM_OP) && samples.len() > 1;
    let why = "the panels are sewn together at one time; move the prim above them";
    is_moving.then(|| Warning::not_carried(format!("the motion of {panel}.{}", record.name), why))
}

/// Faces that a panel names twice as words, as the faces of the garment have other numbers.
fn with_faces_in_words(mut warning: Warning) -> Warning {
    if warning.code != tailor_mesh::codes::REPEATED_POINTS {
        return warning;
    }
    let problem = format!("{}: {}", warning.elements.in_words(usize::MAX), warning.problem);
    (warning.problem, warning.elements) = (problem, Elements::Faces(Vec::new()));
    warning
}

/// The records of the subsets of all panels.
///
/// # Errors
/// Subsets of one name with different materials.
fn subset_records(panels: &[&Source]) -> Result<BTreeMap<String, SubsetRecord>, Error> {
    let mut all = std::collections::BTreeMap::<String, (&Source, SubsetRecord)>::new();
    for panel in panels {
        for (name, record) in &panel.model.subsets {
            let known = all.entry(name.clone()).or_insert_with(|| (panel, record.clone()));
            if known.1.carried != record.carried {
                let text = format!(
                    "{}, {}: they are sewn together, and their subset {name} has different materials",
                    known.0.prim(),
                    panel.prim()
                );
                let fault = Error::usd(text).code(tailor_mesh::codes::PANELS_DIFFER);
                return Err(fault.remedy("rename one of the two, or bind one material"));
            }
        }
    }
    Ok(all.into_iter().map(|(name, (_, record))| (name, record)).collect())
}

/// Binds the materials of panels, where they differ, to face sets of the panels: to what no other set with a material has.
fn move_materials(panels: &[&Source], model: &mut Model, sewn: &mut Sewn) {
    if model.carried.iter().any(|record| names::is_material(&record.name)) {
        return;
    }
    let bound: Vec<Vec<Record>> = panels
        .iter()
        .map(|panel| panel.model.carried.iter().filter(|record| names::is_material(&record.name)).cloned().collect())
        .collect();
    let has_material = |s: &&tailor_mesh::garment::SubsetInput| {
        let records = model.subsets.get(&s.name).map_or(&[][..], |record| &record.carried);
        s.element_type == "face" && records.iter().any(|record| names::is_material(&record.name) && record.has_value())
    };
    let taken: std::collections::HashSet<i32> =
        sewn.mesh.subsets.iter().filter(has_material).flat_map(|s| s.indices.iter().copied()).collect();
    for (set, carried) in sewn.panels.clone().iter().zip(bound) {
        if carried.is_empty() {
            continue;
        }
        let Some(at) = sewn.mesh.subsets.iter().position(|subset| subset.name == *set) else { continue };
        let own = sewn.mesh.subsets[at].clone();
        let rest: Vec<i32> = own.indices.iter().copied().filter(|face| !taken.contains(face)).collect();
        let name = if rest.len() == own.indices.len() {
            sewn.mesh.subsets[at].family = names::MATERIAL_FAMILY.to_owned();
            own.name
        } else if rest.is_empty() {
            continue;
        } else {
            let is_taken = |name: &str| sewn.mesh.subsets.iter().any(|subset| subset.name == name);
            let name = tailor_mesh::garment::free_name(&format!("{set}_material"), is_taken);
            let family = names::MATERIAL_FAMILY.to_owned();
            sewn.mesh.subsets.push(tailor_mesh::garment::SubsetInput {
                name: name.clone(),
                indices: rest,
                family,
                ..own
            });
            name
        };
        let applied = vec![openusd::tf::Token::from(names::MATERIAL_BINDING_API)];
        model.subsets.insert(name, SubsetRecord { metadata: Vec::new(), applied, carried });
    }
}

/// The units of the space of the garment.
fn units(first: &Source, space: DMat4) -> Units {
    let scale = space.determinant().abs().cbrt();
    let meters_per_unit = first.garment.as_ref().map_or(Units::default().meters_per_unit, |m| m.units.meters_per_unit);
    Units { meters_per_unit, scale: if scale.is_finite() && scale > 0.0 { scale } else { 1.0 } }
}

/// The name of the garment in messages, such as `/Suit/front+back`.
fn name(model: &Model) -> String {
    let names: Vec<&str> = model.panels.iter().filter_map(Path::name).collect();
    let more = if names.len() > NAMED { format!("+{}", names.len() - NAMED) } else { String::new() };
    format!("{}/{}{more}", model.parent.as_str().trim_end_matches('/'), names[..names.len().min(NAMED)].join("+"))
}

/// The point of the garment behind each point of each panel, also where a panel was sewn to itself before.
fn points(panels: &[&Source], sewn: &Sewn) -> Vec<usize> {
    let of_panel = |(panel, points): (&&Source, &Vec<usize>)| match &panel.model.sewing.points {
        own if own.is_empty() => points.clone(),
        own => own.iter().map(|&point| points[point]).collect(),
    };
    panels.iter().zip(&sewn.points).flat_map(of_panel).collect()
}

/// The pairs of points that are one, with the panels numbered as in the garment.
fn welds(members: &[usize], seams: &Seams) -> Vec<[(usize, usize); 2]> {
    let numbers: BTreeMap<usize, usize> = members.iter().enumerate().map(|(number, &mesh)| (mesh, number)).collect();
    let number = |(mesh, point): (usize, usize)| Some((*numbers.get(&mesh)?, point));
    seams.welds.iter().filter_map(|[a, b]| Some([number(*a)?, number(*b)?])).collect()
}

/// All items of several lists, each once, in the order in which they come.
fn union<'a, T: Clone + PartialEq + 'a>(lists: impl Iterator<Item = impl IntoIterator<Item = &'a T>>) -> Vec<T> {
    let mut all = Vec::new();
    for item in lists.flatten() {
        if !all.contains(item) {
            all.push(item.clone());
        }
    }
    all
}
