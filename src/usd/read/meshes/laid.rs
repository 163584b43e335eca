//! Meshes of cloth that lie on others, such as pockets, flaps and belts, and are attached there.

use super::model::sewn;
use crate::codes;
use crate::read::source::Source;
use crate::read::trims::PlacedMesh;
use glam::Vec3;
use openusd::usd::{Stage, TimeCode};
use std::cell::OnceCell;
use std::collections::BTreeSet;
use tailor_costume::binding::Triangles;
use tailor_costume::cloth::{COVERED, LOOSE_AREA};
use tailor_mesh::error::{Error, Warning};
use tailor_mesh::garment::sew::{Seams, border_points, edges};

/// Largest distance of a border from the cloth below. \[sizes of the cloth\]
const NEAR: f32 = 0.02;

/// The meshes of a garment, in the space of the stage.
struct Layer {
    members: Vec<usize>,
    /// The points of its border, without those of seams between its meshes.
    border: Vec<Vec3>,
    corners: Vec<[Vec3; 3]>,
    triangles: OnceCell<Triangles>,
    area: f64,
    /// The box of its points.
    bounds: [Vec3; 2],
    /// How near a border lies on it.
    reach: f32,
}

/// The garments of a stage, the meshes of each. A garment that lies on a larger one, by the same rules as a loose piece of one mesh,
/// becomes a part of it, so that its border is attached. It stays one of its own, with a warning, where the two cannot be one mesh
/// without a loss.
///
/// # Errors
/// Panels that cannot be one mesh.
pub fn garments(
    stage: &Stage,
    sources: &mut [Source],
    seams: &Seams,
    time: Option<TimeCode>,
) -> Result<Vec<Source>, Error> {
    let welded: BTreeSet<(usize, usize)> = seams.welds.iter().flatten().copied().collect();
    let layers = seams.garments.iter().map(|members| Layer::new(sources, members, &welded));
    let mut layers = layers.collect::<Result<Vec<Layer>, Error>>()?;
    // From the smallest piece, so that a flap is on its pocket before the pocket is on the coat.
    let mut order: Vec<usize> = (0..layers.len()).collect();
    order.sort_by(|&a, &b| layers[a].area.total_cmp(&layers[b].area).then(a.cmp(&b)));
    let mut together = |members: &[usize]| sewn(stage, sources, members, seams, time);
    let own = seams.garments.iter().map(|members| together(members));
    let mut garments = own.map(|garment| garment.map(Some)).collect::<Result<Vec<Option<Source>>, Error>>()?;
    for piece in order {
        let Some(small) = garments[piece].as_ref().filter(|small| attaches(small)) else { continue };
        let Some(on) = below(&layers, piece) else { continue };
        let Some(large) = garments[on].as_ref().filter(|large| attaches(large)) else { continue };
        let members = [layers[on].members.as_slice(), &layers[piece].members].concat();
        match without_loss(together(&members), [small, large]) {
            Ok(joined) => {
                (garments[piece], garments[on]) = (None, Some(joined));
                layers[on].members = members;
                layers[piece].corners.clear();
            }
            Err(why) => {
                let warning = apart(small, large, &why);
                garments[piece].iter_mut().for_each(|piece| piece.warnings.push(warning.clone()));
            }
        }
    }
    Ok(garments.into_iter().flatten().collect())
}

/// The garment of two others, or why they cannot be one.
fn without_loss(joined: Result<Source, Error>, of: [&Source; 2]) -> Result<Source, String> {
    let words = |fault: &Error| fault.faults.iter().map(|fault| fault.text.as_str()).collect::<Vec<_>>().join("; ");
    let joined = joined.map_err(|fault| words(&fault))?;
    if let Err(fault) = &joined.recipe {
        return Err(words(fault));
    }
    let lost = joined.warnings.iter().filter(|warning| warning.code == tailor_mesh::codes::NOT_CARRIED);
    let known = |warning: &&Warning| !of.iter().any(|source| source.warnings.iter().any(|own| own == *warning));
    let lost: Vec<&str> = lost.filter(known).map(|warning| warning.place.as_str()).collect();
    if lost.is_empty() { Ok(joined) } else { Err(format!("one garment of both would lack {}", lost.join(", "))) }
}

/// Whether the options of a garment let it be attached.
fn attaches(garment: &Source) -> bool {
    let options = garment.recipe.as_ref().ok().and_then(|options| options.get("cloth"));
    options.and_then(|cloth| cloth.get("attach")).is_none_or(|attach| attach != false)
}

fn apart(piece: &Source, cloth: &Source, why: &str) -> Warning {
    let problem = format!("it lies on {} and is not attached to it: {why}", cloth.prim());
    Warning::new(codes::UNATTACHED, piece.prim(), problem)
        .remedy("Give both the same primvars and options; or set cloth.attach to false on it")
}

/// The layer that most of the border of `piece` lies on.
fn below(layers: &[Layer], piece: usize) -> Option<usize> {
    let own = &layers[piece];
    let share = |on: usize| {
        let cloth = &layers[on];
        let is_larger = on != piece && !cloth.corners.is_empty() && own.area <= LOOSE_AREA * cloth.area;
        if !is_larger || own.border.is_empty() || !own.is_near(cloth) {
            return 0.0;
        }
        let triangles = cloth.triangles.get_or_init(|| Triangles::new(cloth.corners.clone()));
        let near = own.border.iter().filter(|&&point| triangles.distance(point) <= cloth.reach).count();
        near as f64 / own.border.len() as f64
    };
    let shares = (0..layers.len()).map(|on| (on, share(on))).filter(|(_, share)| *share >= COVERED);
    shares.reduce(|best, next| if next.1 > best.1 { next } else { best }).map(|(on, _)| on)
}

impl Layer {
    /// Whether its box is within reach of that of `cloth`.
    fn is_near(&self, cloth: &Self) -> bool {
        let ([low, high], [cloth_low, cloth_high]) = (self.bounds, cloth.bounds);
        (cloth_low - cloth.reach).cmple(high).all() && low.cmple(cloth_high + cloth.reach).all()
    }

    /// Of the meshes number `members`. `welded` are the points of seams, each as mesh and point.
    fn new(sources: &[Source], members: &[usize], welded: &BTreeSet<(usize, usize)>) -> Result<Self, Error> {
        let (mut border, mut corners) = (Vec::new(), Vec::new());
        let (mut length, mut count) = (0.0, 0);
        for &member in members {
            let mesh = sources[member].garment.as_ref().map_err(Clone::clone)?;
            let placed = PlacedMesh::new(mesh, sources[member].model.transforms.to_world);
            let open = border_points(mesh).into_iter().filter(|&point| !welded.contains(&(member, point)));
            border.extend(open.map(|point| placed.points[point]));
            corners.extend(placed.triangles());
            for [a, b] in edges(mesh) {
                length += placed.points[a].distance(placed.points[b]);
                count += 1;
            }
        }
        let area = corners.iter().map(|[a, b, c]| f64::from((b - a).cross(c - a).length())).sum();
        let with = |[low, high]: [Vec3; 2], &p: &Vec3| [low.min(p), high.max(p)];
        let bounds = corners.iter().flatten().fold([Vec3::INFINITY, Vec3::NEG_INFINITY], with);
        let reach = (length / count.max(1) as f32).min(NEAR * (bounds[1] - bounds[0]).length());
        Ok(Self { members: members.to_vec(), border, corners, triangles: OnceCell::new(), area, bounds, reach })
    }
}
