//! Compares virtual tables slot by slot.

use super::member::Member;
use super::{Check, Mismatch};
use crate::plugin::elf::Slot;

/// A class of OpenUSD with virtual functions that the plugin overrides or calls.
pub struct Class {
    name: &'static str,
    /// The derived class in the probe.
    probe: &'static str,
    /// Derived classes in the wheel, whose tables name the pure virtual functions. Versions have different subsets of
    /// them.
    derived: &'static [&'static str],
}

pub const CLASSES: [Class; 4] = [
    Class {
        name: "SdfFileFormat",
        probe: "TailorProbeFormat",
        derived: &["UsdUsdcFileFormat", "SdfUsdcFileFormat", "UsdUsdFileFormat", "SdfUsdFileFormat"],
    },
    Class {
        name: "Sdf_FileFormatFactoryBase",
        probe: "TailorProbeFactory",
        derived: &["Sdf_FileFormatFactory<UsdUsdcFileFormat>", "Sdf_FileFormatFactory<SdfUsdcFileFormat>"],
    },
    // The wheel has no derived class; the trial run tests the pure slots.
    Class { name: "PcpDynamicFileFormatInterface", probe: "TailorProbeDynamic", derived: &[] },
    Class { name: "ArAsset", probe: "TailorProbeAsset", derived: &["ArFilesystemAsset", "ArInMemoryAsset"] },
];

impl Check<'_> {
    pub fn vtables(&self) -> Vec<Mismatch> {
        CLASSES.iter().flat_map(|class| self.vtable(class)).collect()
    }

    fn vtable(&self, class: &Class) -> Vec<Mismatch> {
        let missing = |place: &str, declared: String, found: &str| {
            vec![Mismatch { class: class.name.into(), place: place.into(), declared, found: found.into() }]
        };
        let Some(declared) = self.probe.vtable(&self.table(class.probe)) else {
            return missing("virtual table", "nothing".into(), "not looked for");
        };
        let Some(found) = self.wheel_vtable(class.name) else {
            return missing("virtual table", format!("{} slots", declared.len()), "none is exported");
        };
        if declared.len() != found.len() {
            return missing("virtual table", format!("{} slots", declared.len()), &format!("{} slots", found.len()));
        }
        let derived: Vec<Vec<Slot>> = class.derived.iter().filter_map(|name| self.wheel_vtable(name)).collect();
        let slots = declared.iter().zip(&found).enumerate();
        slots.filter_map(|(at, (declared, found))| self.slot(class, at, declared, found, &derived)).collect()
    }

    fn slot(&self, class: &Class, at: usize, declared: &Slot, found: &Slot, derived: &[Vec<Slot>]) -> Option<Mismatch> {
        let declared = self.members(declared);
        let mut real = self.members(found);
        if real.is_empty() {
            // A pure slot, or the destructor of an abstract class: derived classes name it.
            real = derived.iter().filter_map(|table| table.get(at)).flat_map(|slot| self.members(slot)).collect();
        }
        if real.is_empty() && class.derived.is_empty() || declared.iter().any(|member| real.contains(member)) {
            return None;
        }
        let shown = |members: &[Member]| members.first().map_or("unknown".to_owned(), ToString::to_string);
        let (declared, found) = (shown(&declared), shown(&real));
        Some(Mismatch { class: class.name.into(), place: format!("slot {at}"), declared, found })
    }

    fn members(&self, slot: &Slot) -> Vec<Member> {
        let names: &[String] = match slot {
            Slot::Functions(names) => names,
            Slot::Number(_) => &[],
        };
        names.iter().filter_map(|name| Member::parse(name, &self.namespace)).collect()
    }

    fn wheel_vtable(&self, class: &str) -> Option<Vec<Slot>> {
        let name = self.table(class);
        self.wheel.export(&name).and_then(|(library, _)| library.vtable(&name))
    }

    /// The symbol of a class's virtual table.
    fn table(&self, class: &str) -> String {
        format!("_ZTVN{}E", self.mangled(class))
    }
}
