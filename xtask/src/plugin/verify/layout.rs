//! Compares the size and member offsets of `SdfFileFormat`, read from the wheel's machine code.
//!
//! An accessor that returns a member holds its offset. A factory passes the size of its class to `operator new`.

use super::{Check, Mismatch};

/// The accessors of `SdfFileFormat`'s members, in the order of the probe's table.
const ACCESSORS: [&str; 7] = [
    "GetSchema",
    "GetFormatId",
    "GetTarget",
    "GetFileCookie",
    "GetVersionString",
    "GetFileExtensions",
    "IsPrimaryFormatForExtensions",
];

/// Formats without members of their own. Versions have different subsets of them.
const FORMATS: [&str; 6] = [
    "UsdUsdcFileFormat",
    "SdfUsdcFileFormat",
    "UsdUsdaFileFormat",
    "SdfUsdaFileFormat",
    "UsdUsdFileFormat",
    "SdfUsdFileFormat",
];

impl Check<'_> {
    pub fn layout(&self) -> Vec<Mismatch> {
        let declared = self.declared();
        let members = ACCESSORS.iter().zip(&declared).filter_map(|(name, declared)| {
            let found = self.accessor(name);
            let found_text = found.map_or("unknown".to_owned(), |offset| format!("offset {offset}"));
            let place = format!("the member of {name}");
            (found != Some(*declared)).then(|| mismatch(place, format!("offset {declared}"), found_text))
        });
        let mut all: Vec<Mismatch> = members.collect();
        let (declared, found) = (declared[ACCESSORS.len()], self.size());
        if found != Some(declared) {
            let found = found.map_or("unknown".to_owned(), |size| format!("{size} bytes"));
            all.push(mismatch("size".into(), format!("{declared} bytes"), found));
        }
        all
    }

    /// The probe's table: the offset of each member, then the size.
    fn declared(&self) -> [i32; ACCESSORS.len() + 1] {
        let bytes = self.probe.export("tailorProbeLayout").map_or(&[][..], |table| self.probe.at(table.address, 32));
        let mut numbers = bytes.chunks_exact(4).map(|number| number.try_into().map_or(-1, i32::from_le_bytes));
        std::array::from_fn(|_| numbers.next().unwrap_or(-1))
    }

    fn accessor(&self, name: &str) -> Option<i32> {
        let plain = format!("_ZNK{}{}{name}", self.mangled("SdfFileFormat"), name.len());
        let code = [format!("{plain}Ev"), format!("{plain}B5cxx11Ev")].iter().find_map(|symbol| self.code(symbol))?;
        offset_of_accessor(code)
    }

    /// The smallest size that a format's factory passes to `operator new`: that of a format without own members.
    fn size(&self) -> Option<i32> {
        let sizes = FORMATS.iter().filter_map(|format| {
            let factory = self.mangled(&format!("Sdf_FileFormatFactory<{format}>"));
            size_of_new(self.code(&format!("_ZNK{factory}3NewEv"))?)
        });
        sizes.min()
    }

    fn code(&self, symbol: &str) -> Option<&[u8]> {
        self.wheel.export(symbol).map(|(library, function)| library.at(function.address, 64))
    }
}

fn mismatch(place: String, declared: String, found: String) -> Mismatch {
    Mismatch { class: "SdfFileFormat".into(), place, declared, found }
}

/// The offset from `this` (`rdi`) in a `lea`, `mov` or `movzx` that is followed by `ret`.
fn offset_of_accessor(code: &[u8]) -> Option<i32> {
    const ENDBR64: &[u8] = &[0xf3, 0x0f, 0x1e, 0xfa];
    const RET: u8 = 0xc3;
    let code = code.strip_prefix(ENDBR64).unwrap_or(code);
    match *code {
        [0x48, 0x8d | 0x8b, 0x47, offset, RET, ..] | [0x0f, 0xb6, 0x47, offset, RET, ..] => {
            Some(i32::from(offset.cast_signed()))
        }
        [0x48, 0x8d | 0x8b, 0x87, a, b, c, d, RET, ..] | [0x0f, 0xb6, 0x87, a, b, c, d, RET, ..] => {
            Some(i32::from_le_bytes([a, b, c, d]))
        }
        _ => None,
    }
}

/// The first small number that is loaded into `edi`: the argument of `operator new`.
fn size_of_new(code: &[u8]) -> Option<i32> {
    code.windows(5).find_map(|window| match *window {
        [0xbf, a, b, 0, 0] => Some(i32::from_le_bytes([a, b, 0, 0])),
        _ => None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn offsets_are_read_from_short_and_long_instructions() {
        assert_eq!(offset_of_accessor(&[0x48, 0x8d, 0x47, 0x20, 0xc3]), Some(32));
        assert_eq!(offset_of_accessor(&[0xf3, 0x0f, 0x1e, 0xfa, 0x48, 0x8b, 0x47, 0x18, 0xc3]), Some(24));
        assert_eq!(offset_of_accessor(&[0x0f, 0xb6, 0x87, 0x90, 0, 0, 0, 0xc3]), Some(144));
        assert_eq!(offset_of_accessor(&[0x55, 0x48, 0x89, 0xe5, 0xc3]), None);
    }

    #[test]
    fn the_size_is_the_argument_of_new() {
        assert_eq!(size_of_new(&[0x55, 0xbf, 0x78, 0, 0, 0, 0xe8]), Some(120));
        assert_eq!(size_of_new(&[0x55, 0xc3]), None);
    }
}
