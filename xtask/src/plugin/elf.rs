//! Reads an ELF shared library: its symbols, dependencies, relocations and bytes, for the check against a wheel.

use std::collections::HashMap;
use std::fs;
use std::ops::Range;
use std::path::Path;

use object::Endianness;
use object::elf::{self, FileHeader64};
use object::read::elf::{Dyn, FileHeader, Rela, SectionHeader, Sym};

use crate::process::{Failure, Outcome};

/// An exported symbol.
#[derive(Clone, Copy)]
pub struct Export {
    pub address: u64,
    pub size: u64,
}

/// The value that the dynamic linker writes at an address.
enum Relocation {
    /// The address of a symbol.
    Symbol(u32),
    /// An address in this library.
    Local(u64),
}

/// The content of a slot of a virtual table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Slot {
    /// All symbol names of one function. Constructors and merged identical functions have several.
    Functions(Vec<String>),
    Number(u64),
}

/// A shared library.
pub struct Elf {
    /// File name.
    pub name: String,
    /// File names of the libraries that it links to.
    pub needed: Vec<String>,
    versions: Vec<String>,
    exports: HashMap<String, Export>,
    undefined: Vec<String>,
    symbols: Vec<String>,
    names_at: HashMap<u64, Vec<String>>,
    relocations: HashMap<u64, Relocation>,
    /// Address ranges with the file offset of each.
    loaded: Vec<(Range<u64>, usize)>,
    bytes: Vec<u8>,
}

type Header = FileHeader64<Endianness>;

impl Elf {
    pub fn read(path: &Path) -> Outcome<Self> {
        let fault = |error: &dyn std::fmt::Display| Failure::new(format!("cannot read {}: {error}", path.display()));
        let bytes = fs::read(path).map_err(|error| fault(&error))?;
        let mut elf = Self {
            name: path.file_name().unwrap_or_default().to_string_lossy().into_owned(),
            needed: Vec::new(),
            versions: Vec::new(),
            exports: HashMap::new(),
            undefined: Vec::new(),
            symbols: Vec::new(),
            names_at: HashMap::new(),
            relocations: HashMap::new(),
            loaded: Vec::new(),
            bytes: Vec::new(),
        };
        elf.parse(&bytes).map_err(|error| fault(&error))?;
        elf.bytes = bytes;
        Ok(elf)
    }

    fn parse(&mut self, data: &[u8]) -> object::read::Result<()> {
        let header = Header::parse(data)?;
        let endian = header.endian()?;
        let sections = header.sections(endian, data)?;
        let symbols = sections.symbols(endian, data, elf::SHT_DYNSYM)?;
        for symbol in symbols.iter() {
            let name = String::from_utf8_lossy(symbol.name(endian, symbols.strings())?).into_owned();
            self.add_symbol(&name, symbol.st_shndx(endian), symbol.st_value(endian), symbol.st_size(endian));
            self.symbols.push(name);
        }
        for section in sections.iter() {
            let address = section.sh_addr(endian);
            if section.sh_type(endian) != elf::SHT_NOBITS && section.sh_flags(endian) & u64::from(elf::SHF_ALLOC) != 0 {
                self.loaded.push((address..address + section.sh_size(endian), section.sh_offset(endian) as usize));
            }
            if let Some((relocations, link)) = section.rela(endian, data)?
                && link == symbols.section()
            {
                for relocation in relocations {
                    let target = match relocation.r_sym(endian, false) {
                        0 => Relocation::Local(relocation.r_addend(endian) as u64),
                        symbol => Relocation::Symbol(symbol),
                    };
                    self.relocations.insert(relocation.r_offset(endian), target);
                }
            }
            if let Some((mut libraries, link)) = section.gnu_verneed(endian, data)? {
                let strings = sections.strings(endian, data, link)?;
                while let Some((_, mut versions)) = libraries.next()? {
                    while let Some(version) = versions.next()? {
                        self.versions.push(String::from_utf8_lossy(version.name(endian, strings)?).into_owned());
                    }
                }
            }
            if let Some((entries, link)) = section.dynamic(endian, data)? {
                let strings = sections.strings(endian, data, link)?;
                for entry in entries.iter().filter(|entry| entry.tag32(endian) == Some(elf::DT_NEEDED)) {
                    self.needed.push(String::from_utf8_lossy(entry.string(endian, strings)?).into_owned());
                }
            }
        }
        Ok(())
    }

    fn add_symbol(&mut self, name: &str, section: u16, address: u64, size: u64) {
        if name.is_empty() {
            return;
        }
        if section == elf::SHN_UNDEF {
            self.undefined.push(name.to_owned());
            return;
        }
        self.exports.insert(name.to_owned(), Export { address, size });
        self.names_at.entry(address).or_default().push(name.to_owned());
    }

    pub fn export(&self, name: &str) -> Option<Export> {
        self.exports.get(name).copied()
    }

    pub fn exports(&self) -> impl Iterator<Item = &str> {
        self.exports.keys().map(String::as_str)
    }

    pub fn undefined(&self) -> impl Iterator<Item = &str> {
        self.undefined.iter().map(String::as_str)
    }

    /// The versions of symbols that it needs, such as `GLIBC_2.28`.
    pub fn versions(&self) -> impl Iterator<Item = &str> {
        self.versions.iter().map(String::as_str)
    }

    /// Up to `count` bytes from an address.
    pub fn at(&self, address: u64, count: usize) -> &[u8] {
        let found = self.loaded.iter().find(|(addresses, _)| addresses.contains(&address));
        found.map_or(&[], |(addresses, offset)| {
            let start = offset + (address - addresses.start) as usize;
            let end = (start + count).min(offset + (addresses.end - addresses.start) as usize);
            self.bytes.get(start..end).unwrap_or(&[])
        })
    }

    /// The function slots of an exported virtual table, without the leading offset and type information.
    pub fn vtable(&self, name: &str) -> Option<Vec<Slot>> {
        let table = self.export(name)?;
        let slots = (table.address..table.address + table.size).step_by(8).skip(2);
        Some(slots.map(|address| self.slot(address)).collect())
    }

    fn slot(&self, address: u64) -> Slot {
        match self.relocations.get(&address) {
            Some(Relocation::Symbol(symbol)) => Slot::Functions(vec![self.symbols[*symbol as usize].clone()]),
            Some(Relocation::Local(target)) => {
                self.names_at.get(target).map_or(Slot::Number(*target), |names| Slot::Functions(names.clone()))
            }
            None => Slot::Number(self.at(address, 8).try_into().map_or(0, u64::from_le_bytes)),
        }
    }
}
