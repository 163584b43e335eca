//! Between USD's typed values and the flat arrays that geometry code works with.

use crate::garment::{Mixing, Values};
use bytemuck::{Pod, cast_slice};
use openusd::gf::f16;
use openusd::sdf::{AssetPath, Role, TimeCode, Value, ValueKind, ValueTypeName};
use openusd::tf::Token;

/// Defines [`flat`] and [`typed`] from one table of USD's array types: those whose vector is kept, those that are cast to
/// their numbers (with how many a value has), and halves, which are widened. Widening is exact.
macro_rules! arrays {
    (
        kept { $($kept:ident $kept_as:ident),* }
        cast { $($cast:ident $cast_as:ident $width:literal),* }
        half { $($half:ident $half_width:literal),* }
    ) => {
        /// Numbers in one value of an array, and the array, flat.
        pub fn flat(value: Value) -> Option<(usize, Values)> {
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
        pub fn typed(type_name: &ValueTypeName, values: &Values) -> Option<Value> {
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

/// How values of a type combine: quaternions and normals stay of unit length, other real numbers are summed, and
/// everything else is copied.
pub fn mixing(type_name: &ValueTypeName) -> Mixing {
    let holds = |none: Values| typed(type_name, &none).is_some();
    match type_name.kind() {
        Some(ValueKind::QuathVec | ValueKind::QuatfVec | ValueKind::QuatdVec) => Mixing::Rotation,
        _ if type_name.role() == Some(Role::Normal) => Mixing::Direction,
        _ if holds(Values::F32(Vec::new())) || holds(Values::F64(Vec::new())) => Mixing::Linear,
        _ => Mixing::Discrete,
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

    /// A value of every array type that has one, filled with numbers that the type holds exactly.
    fn sample(name: &str, flat: &Values) {
        let type_name = ValueTypeName::find(name).unwrap();
        let value = typed(&type_name, flat).unwrap_or_else(|| panic!("{name} from {flat:?}"));
        assert_eq!(type_name.kind(), Some(ValueKind::from(&value)), "{name}");
        let (_, back) = super::flat(value).unwrap();
        assert_eq!(&back, flat, "{name}");
    }

    #[test]
    fn every_type_comes_back() {
        let f32s = Values::F32((0..12).map(|i| i as f32 * 0.25 - 1.0).collect());
        for name in ["float", "float2", "float3", "float4", "quatf", "texCoord2f", "color3f", "point3f", "normal3f"] {
            sample(&format!("{name}[]"), &f32s);
        }
        for name in ["half", "half2", "half3", "half4", "quath", "texCoord3h", "color4h", "vector3h"] {
            sample(&format!("{name}[]"), &f32s);
        }
        let f64s = Values::F64((0..144).map(|i| f64::from(i) / 3.0).collect());
        for name in ["double", "double2", "double3", "double4", "quatd", "matrix2d", "matrix3d", "matrix4d", "frame4d"]
        {
            sample(&format!("{name}[]"), &f64s);
        }
        sample("timecode[]", &f64s);
        for name in ["int", "int2", "int3", "int4"] {
            sample(&format!("{name}[]"), &Values::I32((-6..6).collect()));
        }
        sample("bool[]", &Values::Bool(vec![true, false]));
        sample("uchar[]", &Values::U8(vec![0, 255]));
        sample("uint[]", &Values::U32(vec![0, u32::MAX]));
        sample("int64[]", &Values::I64(vec![i64::MIN, i64::MAX]));
        sample("uint64[]", &Values::U64(vec![0, u64::MAX]));
        for name in ["string", "token", "asset"] {
            sample(&format!("{name}[]"), &Values::Text(vec!["a b".into(), String::new()]));
        }
    }

    #[test]
    fn values_that_do_not_fit_are_refused() {
        let odd = Values::F32(vec![1.0; 5]);
        assert_eq!(typed(&ValueTypeName::find("float2[]").unwrap(), &odd), None);
        assert_eq!(typed(&ValueTypeName::find("int[]").unwrap(), &odd), None);
    }

    #[test]
    fn types_mix_as_their_meaning_says() {
        let mix = |name: &str| mixing(&ValueTypeName::find(name).unwrap());
        assert_eq!(mix("normal3f[]"), Mixing::Direction);
        assert_eq!(mix("vector3f[]"), Mixing::Linear);
        assert_eq!(mix("quath[]"), Mixing::Rotation);
        assert_eq!(mix("matrix4d[]"), Mixing::Linear);
        assert_eq!(mix("int2[]"), Mixing::Discrete);
        assert_eq!(mix("token[]"), Mixing::Discrete);
    }
}
