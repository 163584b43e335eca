//! Between USD's typed values and the flat arrays that geometry code works with.

use bytemuck::{Pod, cast_slice};
use openusd::gf::f16;
use openusd::sdf::{AssetPath, Role, TimeCode, Value, ValueKind, ValueTypeName};
use openusd::tf::Token;
use std::mem::discriminant;
use tailor_mesh::garment::{Meaning, Primvar, Values};

/// Defines [`numbers`], [`typed`] and [`is_half`] from one table of USD's array types: those whose vector is kept, those that are cast to
/// their numbers (with how many a value has), and halves, which are widened. Widening is exact.
macro_rules! arrays {
    (
        kept { $($kept:ident $kept_as:ident),* }
        cast { $($cast:ident $cast_as:ident $width:literal),* }
        half { $($half:ident $half_width:literal),* }
    ) => {
        /// Numbers in one value of an array, and the array, flat.
        fn numbers(value: Value) -> Option<(usize, Values)> {
            Some(match value {
                $(Value::$kept(v) => (1, Values::$kept_as(v)),)*
                $(Value::$cast(v) => ($width, Values::$cast_as(cast_slice(&v).to_vec())),)*
                $(Value::$half(v) => ($half_width, widened(&v)),)*
                Value::TimeCodeVec(v) => (1, Values::F64(v.iter().map(|t| t.0).collect())),
                Value::TokenVec(v) => (1, Values::Text(v.iter().map(|t| t.as_str().to_owned()).collect())),
                Value::AssetPathVec(v) => (1, Values::Text(v.into_iter().map(AssetPath::into_string).collect())),
                _ => return None,
            })
        }

        /// Flat values as an array of USD's type `type_name`; none when the two do not fit.
        fn typed(type_name: &ValueTypeName, values: &Values) -> Option<Value> {
            use ValueKind as K;
            Some(match (type_name.kind()?, values) {
                $((K::$kept, Values::$kept_as(v)) => Value::$kept(v.clone()),)*
                $((K::$cast, Values::$cast_as(v)) => Value::$cast(grouped(v)?),)*
                $((K::$half, Values::F32(v)) => {
                    Value::$half(grouped(&v.iter().map(|&x| f16::from_f32(x)).collect::<Vec<_>>())?)
                })*
                (K::TimeCodeVec, Values::F64(v)) => Value::TimeCodeVec(v.iter().map(|&t| TimeCode(t)).collect()),
                (K::TokenVec, Values::Text(v)) => Value::TokenVec(v.iter().map(Token::from).collect()),
                (K::AssetPathVec, Values::Text(v)) => Value::AssetPathVec(v.iter().map(AssetPath::new).collect()),
                _ => return None,
            })
        }

        /// Whether a type has halves.
        fn is_half(kind: ValueKind) -> bool {
            matches!(kind, $(ValueKind::$half)|*)
        }
    };
}

arrays! {
    kept {
        BoolVec Bool, UcharVec U8, IntVec I32, UintVec U32, Int64Vec I64, Uint64Vec U64, FloatVec F32, DoubleVec F64,
        StringVec Text
    }
    cast {
        Vec2iVec I32 2, Vec3iVec I32 3, Vec4iVec I32 4,
        Vec2fVec F32 2, Vec3fVec F32 3, Vec4fVec F32 4, QuatfVec F32 4,
        Vec2dVec F64 2, Vec3dVec F64 3, Vec4dVec F64 4, QuatdVec F64 4,
        Matrix2dVec F64 4, Matrix3dVec F64 9, Matrix4dVec F64 16
    }
    half { HalfVec 1, Vec2hVec 2, Vec3hVec 3, Vec4hVec 4, QuathVec 4 }
}

fn widened<T: Pod>(halves: &[T]) -> Values {
    Values::F32(cast_slice::<T, f16>(halves).iter().map(|h| h.to_f32()).collect())
}

/// The numbers as whole values; none when the last value is incomplete.
fn grouped<N: Pod, T: Pod>(numbers: &[N]) -> Option<Vec<T>> {
    bytemuck::try_cast_slice(numbers).ok().map(<[T]>::to_vec)
}

/// An array as geometry code holds it. These four determine its type in USD.
#[derive(Clone, Debug, PartialEq)]
pub struct Flat {
    /// The meaning of the values.
    pub meaning: Meaning,
    /// Whether they are halves.
    pub half: bool,
    /// Numbers in one value.
    pub components: usize,
    /// The numbers or texts.
    pub values: Values,
}

/// A value of type `type_name`, flat.
///
/// # Errors
/// Why it cannot be the values of a primvar.
pub fn flat(type_name: &ValueTypeName, value: Value) -> Result<Flat, String> {
    let unknown = || format!("values of type {type_name} cannot vary over a mesh");
    let none = empty(type_name).ok_or_else(unknown)?;
    let (components, values) = numbers(value).ok_or_else(unknown)?;
    let fits = components == none.components && discriminant(&values) == discriminant(&none.values);
    fits.then_some(Flat { values, ..none }).ok_or_else(|| format!("its values are not of its type {type_name}"))
}

/// The values of a primvar, or others of the same kind, as an array with its type; none where USD has no type for them.
pub fn array(primvar: &Primvar, values: &Values) -> Option<(ValueTypeName, Value)> {
    let type_name = type_name(primvar)?;
    Some((type_name.clone(), typed(type_name, values)?))
}

/// USD's name of the type of a primvar.
pub fn type_word(primvar: &Primvar) -> &'static str {
    type_name(primvar).map_or("unknown", ValueTypeName::as_str)
}

/// The type of a primvar's values in USD: the one whose empty array is [`Flat`] alike.
fn type_name(primvar: &Primvar) -> Option<&'static ValueTypeName> {
    let is_own = |none: Flat| {
        (none.meaning, none.half, none.components) == (primvar.meaning, primvar.half, primvar.components)
            && discriminant(&none.values) == discriminant(&primvar.values)
    };
    ValueTypeName::all().find(|name| empty(name).is_some_and(is_own))
}

/// An empty array of a type; none for types whose values cannot vary over a mesh.
fn empty(type_name: &ValueTypeName) -> Option<Flat> {
    let (components, values) = numbers(type_name.default_value()?)?;
    let kind = type_name.kind()?;
    Some(Flat { meaning: meaning(type_name.role(), kind), half: is_half(kind), components, values })
}

/// The meaning of values.
fn meaning(role: Option<Role>, kind: ValueKind) -> Meaning {
    use ValueKind as K;
    match (role, kind) {
        (Some(Role::TextureCoordinate), _) => Meaning::TextureCoordinate,
        (Some(Role::Color), _) => Meaning::Color,
        (Some(Role::Normal), _) => Meaning::Normal,
        (Some(Role::Point), _) => Meaning::Point,
        (Some(Role::Vector), _) => Meaning::Vector,
        (Some(Role::Frame), _) => Meaning::Frame,
        (Some(Role::Transform), _) => Meaning::Transform,
        (Some(Role::PointIndex), _) => Meaning::PointIndex,
        (Some(Role::EdgeIndex), _) => Meaning::EdgeIndex,
        (Some(Role::FaceIndex), _) => Meaning::FaceIndex,
        (_, K::QuathVec | K::QuatfVec | K::QuatdVec) => Meaning::Quaternion,
        (_, K::Matrix2dVec | K::Matrix3dVec | K::Matrix4dVec) => Meaning::Matrix,
        (_, K::TimeCodeVec) => Meaning::TimeCode,
        (_, K::TokenVec) => Meaning::Token,
        (_, K::AssetPathVec) => Meaning::AssetPath,
        (None | Some(Role::Group), _) => Meaning::Plain,
    }
}

/// A token or string value as text.
pub fn text(value: &Value) -> Option<&str> {
    match value {
        Value::Token(t) => Some(t.as_str()),
        Value::String(s) => Some(s),
        _ => None,
    }
}

/// A single number of any type that a double holds exactly.
pub fn number(value: &Value) -> Option<f64> {
    match value {
        Value::Double(x) => Some(*x),
        Value::Float(x) => Some(f64::from(*x)),
        Value::Half(x) => Some(f64::from(x.to_f32())),
        Value::Int(x) => Some(f64::from(*x)),
        _ => None,
    }
}

/// A float as its shortest decimal, which is what the user wrote.
pub fn decimal(float: f32) -> f64 {
    float.to_string().parse().unwrap_or(f64::from(float))
}

#[cfg(test)]
mod tests {
    use super::*;
    use tailor_mesh::garment::Mixing;

    /// A primvar of a type, with numbers that the type holds exactly.
    fn primvar(name: &str, values: Values) -> Primvar {
        let none = empty(&ValueTypeName::find(name).expect(name)).expect(name);
        let mut primvar = Primvar::of_corners(Vec::new(), None);
        (primvar.meaning, primvar.half, primvar.components) = (none.meaning, none.half, none.components);
        Primvar { values, ..primvar }
    }

    /// Checks that values of a type are written as that type, and read as they were.
    fn survives(name: &str, values: &Values) {
        let given = primvar(name, values.clone());
        let (type_name, value) = array(&given, values).unwrap_or_else(|| panic!("{name} from {values:?}"));
        assert_eq!(type_name.as_str(), name);
        assert_eq!(type_name.kind(), Some(ValueKind::from(&value)), "{name}");
        let back = flat(&type_name, value).expect(name);
        let Primvar { meaning, half, components, .. } = given;
        assert_eq!(back, Flat { meaning, half, components, values: values.clone() }, "{name}");
    }

    /// Numbers or texts of the variant that holds values of a type: twelve numbers, or enough for whole values.
    fn sample(none: &Values) -> Values {
        match none {
            Values::F32(_) => Values::F32((0..12).map(|i| i as f32 * 0.25 - 1.0).collect()),
            Values::F64(_) => Values::F64((0..144).map(|i| f64::from(i) / 3.0).collect()),
            Values::Bool(_) => Values::Bool(vec![true, false]),
            Values::U8(_) => Values::U8(vec![0, 255]),
            Values::I32(_) => Values::I32((-6..6).collect()),
            Values::U32(_) => Values::U32(vec![0, u32::MAX]),
            Values::I64(_) => Values::I64(vec![i64::MIN, i64::MAX]),
            Values::U64(_) => Values::U64(vec![0, u64::MAX]),
            Values::Text(_) => Values::Text(vec!["a b".into(), String::new()]),
        }
    }

    #[test]
    fn every_array_type_survives() {
        let (mut read, mut left_out) = (0, Vec::new());
        for name in ValueTypeName::all().filter(|name| name.is_array()) {
            match empty(name) {
                // Old spellings such as `Color[]` become the ones that are written.
                Some(none) => survives(name.serialization_name().as_str(), &sample(&none.values)),
                None => left_out.push(name.as_str()),
            }
            read += usize::from(empty(name).is_some());
        }
        assert_eq!(left_out, ["pathExpression[]"]);
        assert!(read > 80, "{read}");
    }

    #[test]
    fn a_type_is_known_by_what_its_values_stand_for() {
        let of = |name: &str| empty(&ValueTypeName::find(name).unwrap()).map(|f| (f.meaning, f.half, f.components));
        assert_eq!(of("float2[]"), Some((Meaning::Plain, false, 2)));
        assert_eq!(of("color3h[]"), Some((Meaning::Color, true, 3)));
        assert_eq!(of("texCoord2f[]"), Some((Meaning::TextureCoordinate, false, 2)));
        assert_eq!(of("quath[]"), Some((Meaning::Quaternion, true, 4)));
        assert_eq!(of("frame4d[]"), Some((Meaning::Frame, false, 16)));
        assert_eq!(of("Transform[]"), Some((Meaning::Transform, false, 16)));
        assert_eq!(of("float2"), None);
    }

    #[test]
    fn values_that_do_not_fit_are_refused() {
        let odd = Values::F32(vec![1.0; 5]);
        assert_eq!(array(&primvar("float2[]", odd.clone()), &odd), None);
        // No type of USD has five numbers or halves of matrices.
        let five = Primvar { components: 5, ..primvar("float2[]", odd.clone()) };
        assert_eq!(array(&five, &odd), None);
        let halves = Primvar { half: true, ..primvar("matrix4d[]", Values::F64(Vec::new())) };
        assert_eq!(type_name(&halves), None);
        let doubles = Value::Vec3dVec(Vec::new());
        let refused = flat(&ValueTypeName::COLOR3F_ARRAY, doubles).unwrap_err();
        assert_eq!(refused, "its values are not of its type color3f[]");
    }

    #[test]
    fn types_mix_as_their_meaning_says() {
        let mix = |name: &str| {
            let none = empty(&ValueTypeName::find(name).unwrap()).unwrap();
            primvar(name, none.values).mixing()
        };
        assert_eq!(mix("normal3f[]"), Mixing::Direction);
        assert_eq!(mix("vector3f[]"), Mixing::Linear);
        assert_eq!(mix("quath[]"), Mixing::Rotation);
        assert_eq!(mix("matrix4d[]"), Mixing::Linear);
        assert_eq!(mix("int2[]"), Mixing::Discrete);
        assert_eq!(mix("token[]"), Mixing::Discrete);
    }
}
