//! How materials look: the constants of their preview surfaces, and their textures of colour.

use super::Source;
use super::facts::material_paths;
use crate::assets::file_path;
use crate::on_large_stack;
use crate::read::query::{prim_at, text_value, value};
use crate::values::number;
use openusd::sdf::{Path, Value};
use openusd::usd::{Attribute, Prim, Stage};
use std::collections::BTreeMap;
use std::path::PathBuf;

/// Connections that are followed from an input to its value at most.
const MOST_STEPS: usize = 8;

/// The look of a material.
#[derive(Clone, Debug, PartialEq)]
pub struct Look {
    /// `diffuseColor`. \[linear\]
    pub colour: Option<[f32; 3]>,
    /// The image that `diffuseColor` is, over the UVs as they are.
    pub texture: Option<PathBuf>,
    /// `roughness`, from 0 to 1.
    pub roughness: Option<f32>,
}

impl Source {
    /// The looks of materials by subset; that of the whole mesh under an empty name. The stage is opened again for them. What has no
    /// preview surface, or one that cannot be read, is left out: a garment is shown without it.
    pub fn looks(&self) -> BTreeMap<String, Look> {
        let bound = material_paths(&self.model, &self.facts);
        let read = || {
            let stage = self.model.origin.open()?;
            let of = |(subset, material): (&String, &String)| Some((subset.clone(), look(&stage, material)?));
            Ok(bound.iter().filter_map(of).collect())
        };
        on_large_stack(read).unwrap_or_default()
    }
}

fn look(stage: &Stage, material: &str) -> Option<Look> {
    let material = prim_at(stage, &Path::new(material).ok()?).ok()?;
    let (surface, _) = source(stage, &material.attribute("outputs:surface"))?;
    if text_value(&surface, "info:id", None).ok()??.as_str() != "UsdPreviewSurface" {
        return None;
    }
    let (colour, texture) = match constant(stage, &surface, "inputs:diffuseColor") {
        Constant::Value(value) => (vector(&value), None),
        Constant::Fallback => (Some([0.18; 3]), None),
        Constant::Made(by) => (None, by.and_then(|(shader, output)| image(stage, &shader, &output))),
    };
    let roughness = match constant(stage, &surface, "inputs:roughness") {
        Constant::Value(value) => number(&value).map(|value| value as f32),
        Constant::Fallback => Some(0.5),
        Constant::Made(_) => None,
    };
    let is_good = |numbers: &[f32]| numbers.iter().all(|number| number.is_finite());
    Some(Look {
        colour: colour.filter(|colour| is_good(colour)).map(|colour| colour.map(|channel| channel.clamp(0.0, 1.0))),
        texture,
        roughness: roughness.filter(|&roughness| is_good(&[roughness])).map(|roughness| roughness.clamp(0.0, 1.0)),
    })
}

enum Constant {
    Value(Value),
    /// Nothing is authored.
    Fallback,
    /// By an output of another shader; none after too many steps.
    Made(Option<(Prim, String)>),
}

/// The value of an input, also where it is that of an input of the material.
fn constant(stage: &Stage, shader: &Prim, input: &str) -> Constant {
    let (mut prim, mut name) = (shader.clone(), input.to_owned());
    for _ in 0..MOST_STEPS {
        let Some(next) = source(stage, &prim.attribute(name.as_str())) else {
            return value(&prim, &name, None).ok().flatten().map_or(Constant::Fallback, Constant::Value);
        };
        if !next.1.starts_with("inputs:") {
            return Constant::Made(Some(next));
        }
        (prim, name) = next;
    }
    Constant::Made(None)
}

/// The image file of a UsdUVTexture that is read by UVs as they are. A transform of UVs would show it elsewhere, and a file in
/// an archive or of tiles is none.
fn image(stage: &Stage, shader: &Prim, output: &str) -> Option<PathBuf> {
    let id = |prim: &Prim| text_value(prim, "info:id", None).ok()?;
    if id(shader)? != "UsdUVTexture" || output != "outputs:rgb" {
        return None;
    }
    if let Constant::Made(by) = constant(stage, shader, "inputs:st")
        && id(&by?.0)? != "UsdPrimvarReader_float2"
    {
        return None;
    }
    let Constant::Value(Value::AssetPath(asset)) = constant(stage, shader, "inputs:file") else { return None };
    let file = PathBuf::from(file_path(asset.resolved_path()?));
    file.is_absolute().then_some(file)
}

/// The prim and the name of what an attribute is connected to.
fn source(stage: &Stage, attribute: &Attribute) -> Option<(Prim, String)> {
    let connections = attribute.connections().ok()?;
    let (prim, name) = connections.first()?.as_str().rsplit_once('.')?;
    Some((prim_at(stage, &Path::new(prim).ok()?).ok()?, name.to_owned()))
}

fn vector(value: &Value) -> Option<[f32; 3]> {
    match value {
        Value::Vec3f(v) => Some([v[0], v[1], v[2]]),
        Value::Vec3d(v) => Some([v[0] as f32, v[1] as f32, v[2] as f32]),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ReadOptions, Source};
    use std::fs;

    /// A triangle with a material, and a set with another. `inputs` are those of the set's shader.
    fn looks_of(inputs: &str) -> BTreeMap<String, Look> {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("cloth.usda");
        let text = format!(
            r#"#usda 1.0
def Xform "Cloth" {{
    def Mesh "model" (prepend apiSchemas = ["MaterialBindingAPI"]) {{
        rel material:binding = </Cloth/wool>
        int[] faceVertexCounts = [3]
        int[] faceVertexIndices = [0, 1, 2]
        point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
        def GeomSubset "trim" (prepend apiSchemas = ["MaterialBindingAPI"]) {{
            uniform token elementType = "face"
            uniform token familyName = "materialBind"
            int[] indices = [0]
            rel material:binding = </Cloth/silk>
        }}
    }}
    def Material "wool" {{
        color3f inputs:dye = (0.1, 0.2, 2)
        token outputs:surface.connect = </Cloth/wool/surface.outputs:surface>
        def Shader "surface" {{
            uniform token info:id = "UsdPreviewSurface"
            color3f inputs:diffuseColor.connect = </Cloth/wool.inputs:dye>
            token outputs:surface
        }}
    }}
    def Material "silk" {{
        token outputs:surface.connect = </Cloth/silk/surface.outputs:surface>
        def Shader "surface" {{
            {inputs}
            token outputs:surface
        }}
        def Shader "texture" {{
            uniform token info:id = "UsdUVTexture"
            float3 outputs:rgb
        }}
    }}
}}
"#
        );
        fs::write(&path, text).expect("a file");
        fs::write(folder.path().join("silk.png"), "an image").expect("a file");
        Source::open(&path, &ReadOptions::default()).expect("a garment").looks()
    }

    #[test]
    fn constants_of_preview_surfaces_are_looks_and_textures_are_not() {
        let surface = "uniform token info:id = \"UsdPreviewSurface\"\n";
        let wool = Look { colour: Some([0.1, 0.2, 1.0]), texture: None, roughness: Some(0.5) };
        let of = |colour, roughness| Some(Look { colour, texture: None, roughness });
        let texture = "color3f inputs:diffuseColor.connect = </Cloth/silk/texture.outputs:rgb>";
        for (inputs, silk) in [
            (format!("{surface}float inputs:roughness = 0.25"), of(Some([0.18; 3]), Some(0.25))),
            (format!("{surface}{texture}"), of(None, Some(0.5))),
            (format!("{surface}{texture}\nfloat inputs:roughness = nan"), of(None, None)),
            ("uniform token info:id = \"ND_standard_surface_surfaceshader\"".to_owned(), None),
        ] {
            let looks = looks_of(&inputs);
            assert_eq!(looks.get(""), Some(&wool), "an input of the material");
            assert_eq!(looks.get("trim"), silk.as_ref(), "{inputs}");
        }
    }

    #[test]
    fn the_image_of_a_colour_is_found_where_uvs_are_read_as_they_are() {
        let surface = "uniform token info:id = \"UsdPreviewSurface\"
            color3f inputs:diffuseColor.connect = </Cloth/silk/image.outputs:rgb>
            token outputs:surface } def Shader \"image\" { uniform token info:id = \"UsdUVTexture\" float3 outputs:rgb";
        let reader =
            |id: &str| format!("}} def Shader \"uvs\" {{ uniform token info:id = \"{id}\" float2 outputs:result");
        let connected = "float2 inputs:st.connect = </Cloth/silk/uvs.outputs:result>";
        let file = "asset inputs:file = @./silk.png@";
        for (inputs, is_there) in [
            (format!("{surface}\n{file}"), true),
            (format!("{surface}\n{file}\n{connected}\n{}", reader("UsdPrimvarReader_float2")), true),
            (format!("{surface}\n{file}\n{connected}\n{}", reader("UsdTransform2d")), false),
            (surface.to_owned(), false),
        ] {
            let looks = looks_of(&inputs);
            let texture = looks["trim"].texture.as_ref();
            assert_eq!(texture.is_some_and(|path| path.ends_with("silk.png")), is_there, "{inputs}: {texture:?}");
        }
    }

    #[test]
    fn a_material_that_is_connected_to_itself_has_no_colour() {
        let looped = "uniform token info:id = \"UsdPreviewSurface\"
            color3f inputs:diffuseColor.connect = </Cloth/silk/surface.inputs:diffuseColor>";
        assert_eq!(looks_of(looped)["trim"].colour, None);
    }
}
