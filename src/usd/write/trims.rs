//! Trims are bound to the simulation mesh of the garment that they lie on.

use super::product::Author;
use super::role::{GarmentProducts, sims};
use crate::codes;
use crate::read::{FittedTrim, Model, Source, TrimPrim, is_on, trim_path, trims};
use openusd::sdf::{Path, PrimSpec};
use std::collections::BTreeMap;
use tailor_costume::binding::BindSurface;
use tailor_costume::trim::{Ride, TrimMode, TrimOptions};
use tailor_mesh::error::{Error, Warning, Warnings};
use tailor_mesh::garment::Mesh;

/// Largest distance of a trim from the cloth without a warning. \[sizes of the garment\]
const FARTHEST: f32 = 0.02;

/// A trim that is bound.
#[derive(Clone, Debug, PartialEq)]
pub struct BoundTrim {
    /// Path of its prim.
    pub prim: String,
    /// The name of its options in the recipe.
    pub name: String,
    /// Number of the garment that it rides on.
    pub garment: usize,
    /// How it rides.
    pub ride: Ride,
}

/// A prim, and the garments whose recipes have it as a trim, each with its options.
struct Asked<'a> {
    trim: TrimPrim,
    by: Vec<(usize, &'a str, &'a TrimOptions)>,
}

/// A simulation mesh that trims may ride on, with those of coarser levels of detail.
struct Cloth<'a> {
    surface: BindSurface<'a>,
    mesh: &'a Mesh,
    path: Path,
    model: &'a Model,
    coarser: Vec<(BindSurface<'a>, Path)>,
}

/// The trims of some garments of one stage, with their places on the cloth.
pub struct TrimBindings<'a> {
    garments: &'a [GarmentProducts<'a>],
    cloths: Vec<Option<Cloth<'a>>>,
    asked: BTreeMap<Path, Asked<'a>>,
    fitted: FittedTrims<'a>,
}

/// Trims that garments on another body take along, each with the number of its garment.
pub type FittedTrims<'a> = BTreeMap<&'a Path, (usize, &'a FittedTrim)>;

impl<'a> TrimBindings<'a> {
    /// Reads the trims that recipes name.
    ///
    /// # Errors
    /// A prim that is not there, or that has no points.
    pub fn read(garments: &'a [GarmentProducts<'a>]) -> Result<(Self, Warnings), Error> {
        let mut warnings = Warnings::default();
        let fitted = fitted_trims(garments.iter().map(|garment| garment.source));
        let mut bindings = Self { garments, cloths: Vec::new(), asked: BTreeMap::new(), fitted };
        let options = |of: &GarmentProducts<'a>| of.products.iter().find_map(|product| product.trims);
        if garments.iter().all(|garment| options(garment).is_none_or(BTreeMap::is_empty)) {
            return Ok((bindings, warnings));
        }
        let stage = garments[0].source.model.origin.open()?;
        let mut read: BTreeMap<Path, Vec<Path>> = BTreeMap::new();
        for (number, garment) in garments.iter().enumerate() {
            bindings.cloths.push(Cloth::of(garment)?);
            let all = options(garment).into_iter().flatten().filter(|(_, options)| options.mode != TrimMode::None);
            for (name, options) in all {
                for named in &options.prims {
                    let key = format!("trim.{name}.prims");
                    let root = trim_path(&garment.source.model, &key, named)?;
                    if !read.contains_key(&root) {
                        let file = &garment.source.model.origin.file;
                        let found = warnings.absorb(trims(&stage, file, &key, &root, None)?);
                        read.insert(root.clone(), found.iter().map(|trim| trim.path.clone()).collect());
                        for trim in found {
                            let path = trim.path.clone();
                            bindings.asked.entry(path).or_insert(Asked { trim, by: Vec::new() });
                        }
                    }
                    for path in &read[&root] {
                        let asked = bindings.asked.get_mut(path).expect("it was read with its root");
                        asked.by.push((number, name, options));
                    }
                }
            }
        }
        bindings.follow_fits();
        Ok((bindings, warnings))
    }

    /// The trims that go to another body with their garment.
    pub fn fitted(&self) -> &FittedTrims<'a> {
        &self.fitted
    }

    /// Moves the trims that a fit takes along. Those that are nearer to a garment that stays are not among them.
    fn follow_fits(&mut self) {
        let Self { garments, cloths, asked, fitted } = self;
        for (path, Asked { trim, by }) in asked {
            let Some((_, taken)) = fitted.get(path) else { continue };
            let is_nearer = |(garment, _, options): &(usize, &str, &TrimOptions)| {
                let source = garments[*garment].source;
                let cloth =
                    cloths[*garment].as_ref().filter(|_| source.fitted.is_none() && is_on(&source.model, &options.on));
                cloth.is_some_and(|cloth| trim.beside(cloth.model).distance(&cloth.surface) < taken.distance)
            };
            if by.iter().any(is_nearer) {
                fitted.remove(path);
            } else {
                trim.shape = trim.shape.with_points(taken.points.clone(), 1.0);
                trim.to_world = taken.to_world;
            }
        }
    }

    /// Authors where the points of each trim are bound, on the garment that its options name or that is nearest. Warns of trims that
    /// are not on cloth.
    ///
    /// # Errors
    /// A path that the layer does not admit.
    pub fn author(self, author: &mut Author, warnings: &mut Warnings) -> openusd::Result<Vec<BoundTrim>> {
        let mut bound = Vec::with_capacity(self.asked.len());
        for (path, Asked { trim, by }) in &self.asked {
            let model = |garment: usize| &self.garments[garment].source.model;
            let candidates = by.iter().filter(|(garment, _, options)| is_on(model(*garment), &options.on));
            let candidates = candidates.filter_map(|by| {
                let cloth = self.cloths[by.0].as_ref()?;
                let shape = trim.beside(cloth.model);
                Some((shape.distance(&cloth.surface), by, cloth, shape))
            });
            let nearest = candidates.min_by(|a, b| a.0.total_cmp(&b.0));
            let Some((_, &(garment, name, options), cloth, shape)) = nearest else {
                let on: Vec<&str> = by.iter().map(|(_, _, options)| options.on.as_str()).collect();
                let problem = format!("it rides on no cloth, as {} is not a garment of this build", on.join(" or "));
                warnings.push(Warning::not_carried(path, problem).remedy("Name the mesh of the garment, or nothing"));
                continue;
            };
            let size = cloth.mesh.size();
            let (binding, ride) = shape.bound(options.mode, &cloth.surface, size);
            if !binding.coords.iter().all(|coords| coords.is_finite()) {
                warnings.push(Warning::not_carried(path, "it is too far from the cloth to be bound"));
                continue;
            }
            PrimSpec::over(author.data, path)?;
            author.binding(path, &binding, &cloth.path, 0)?;
            for (level, (surface, sim)) in (1..).zip(&cloth.coarser) {
                author.binding(path, &shape.bound(options.mode, surface, size).0, sim, level)?;
            }
            warnings.extend(off_cloth(path, &ride, &cloth.path, size));
            bound.push(BoundTrim { prim: path.to_string(), name: name.to_owned(), garment, ride });
        }
        Ok(bound)
    }
}

/// The warning of a trim that rides on a garment of the size `size` \[mesh units\] and is away from its cloth.
pub fn off_cloth(trim: &Path, ride: &Ride, cloth: &Path, size: f32) -> Option<Warning> {
    let problem = format!("a piece of it is {:.3} mesh units away from {cloth}, on which it rides", ride.gap);
    let remedy = "Move it to the cloth, or name another garment by its option `on`";
    let warning = Warning::new(codes::TRIM_OFF_CLOTH, trim, problem).amount(ride.gap).remedy(remedy);
    (ride.gap > FARTHEST * size).then_some(warning)
}

/// The trims that garments on another body take along, each with the one that is nearest to it.
pub fn fitted_trims<'a>(garments: impl IntoIterator<Item = &'a Source>) -> FittedTrims<'a> {
    let mut nearest = FittedTrims::new();
    for (garment, source) in garments.into_iter().enumerate() {
        for trim in source.fitted.iter().flat_map(|fitted| &fitted.trims) {
            let known = nearest.entry(&trim.path).or_insert((garment, trim));
            if trim.distance < known.1.distance {
                *known = (garment, trim);
            }
        }
    }
    nearest
}

impl<'a> Cloth<'a> {
    fn of(garment: &GarmentProducts<'a>) -> Result<Option<Self>, Error> {
        let model = &garment.source.model;
        let mut sims = sims(garment.products).map(|sim| {
            let path = model.sibling_path(sim.name).map_err(|e| Error::usd(e.to_string()))?;
            Ok((sim.mesh, BindSurface::new(sim.mesh), path))
        });
        let Some((mesh, surface, path)) = sims.next().transpose()? else { return Ok(None) };
        let coarser = sims.map(|sim| sim.map(|(_, surface, path)| (surface, path))).collect::<Result<_, Error>>()?;
        Ok(Some(Self { surface, mesh, path, model, coarser }))
    }
}
