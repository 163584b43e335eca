//! Between USD's typed values and the flat arrays that geometry code works with.

use crate::garment::{Mixing, Values};
use bytemuck::{Pod, cast_slice};
use openusd::gf::f16;
use openusd::sdf::{AssetPath, Role, TimeCode, Value, ValueKind, ValueTypeName};
use openusd::tf::Token;

/// Numbers in one value of an array, and the array, flat. Halves are widened, which is exact.
pub fn flat(value: Value) -> Option<(usize, Values)> {
    use Value as V;
    Some(match value {
        V::BoolVec(v) => (1, Values::Bool(v)),
        V::UcharVec(v) => (1, Values::U8(v)),
        V::IntVec(v) => (1, Values::I32(v)),
        V::Vec2iVec(v) => (2, Values::I32(cast_slice(&v).to_vec())),
        V::Vec3iVec(v) => (3, Values::I32(cast_slice(&v).to_vec())),
        V::Vec4iVec(v) => (4, Values::I32(cast_slice(&v).to_vec())),
        V::UintVec(v) => (1, Values::U32(v)),
        V::Int64Vec(v) => (1, Values::I64(v)),
        V::Uint64Vec(v) => (1, Values::U64(v)),
        V::HalfVec(v) => (1, widened(&v)),
        V::Vec2hVec(v) => (2, widened(&v)),
        V::Vec3hVec(v) => (3, widened(&v)),
        V::Vec4hVec(v) => (4, widened(&v)),
        V::QuathVec(v) => (4, widened(&v)),
        V::FloatVec(v) => (1, Values::F32(v)),
        V::Vec2fVec(v) => (2, Values::F32(cast_slice(&v).to_vec())),
        V::Vec3fVec(v) => (3, Values::F32(cast_slice(&v).to_vec())),
        V::Vec4fVec(v) => (4, Values::F32(cast_slice(&v).to_vec())),
        V::QuatfVec(v) => (4, Values::F32(cast_slice(&v).to_vec())),
        V::DoubleVec(v) => (1, Values::F64(v)),
        V::Vec2dVec(v) => (2, Values::F64(cast_slice(&v).to_vec())),
        V::Vec3dVec(v) => (3, Values::F64(cast_slice(&v).to_vec())),
        V::Vec4dVec(v) => (4, Values::F64(cast_slice(&v).to_vec())),
        V::QuatdVec(v) => (4, Values::F64(cast_slice(&v).to_vec())),
        V::Matrix2dVec(v) => (4, Values::F64(cast_slice(&v).to_vec())),
        V::Matrix3dVec(v) => (9, Values::F64(cast_slice(&v).to_vec())),
        V::Matrix4dVec(v) => (16, Values::F64(v.iter().flat_map(|m| m.0).collect())),
        V::TimeCodeVec(v) => (1, Values::F64(v.iter().map(|t| t.0).collect())),
        V::StringVec(v) => (1, Values::Text(v)),
        V::TokenVec(v) => (1, Values::Text(v.iter().map(|t| t.as_str().to_owned()).collect())),
        V::AssetPathVec(v) => (1, Values::Text(v.into_iter().map(AssetPath::into_string).collect())),
        _ => return None,
    })
}

fn widened<T: Pod>(halves: &[T]) -> Values {
    Values::F32(cast_slice::<T, f16>(halves).iter().map(|h| h.to_f32()).collect())
}

/// Flat values as an array of USD's type `type_name`; none when the two do not fit.
pub fn typed(type_name: &ValueTypeName, values: &Values) -> Option<Value> {
    let kind = type_name.kind()?;
    match values {
        Values::F32(v) => floats(kind, v),
        Values::F64(v) => doubles(kind, v),
        Values::I32(v) => ints(kind, v),
        Values::Text(v) => texts(kind, v),
        Values::Bool(v) if kind == ValueKind::BoolVec => Some(Value::BoolVec(v.clone())),
        Values::U8(v) if kind == ValueKind::UcharVec => Some(Value::UcharVec(v.clone())),
        Values::U32(v) if kind == ValueKind::UintVec => Some(Value::UintVec(v.clone())),
        Values::I64(v) if kind == ValueKind::Int64Vec => Some(Value::Int64Vec(v.clone())),
        Values::U64(v) if kind == ValueKind::Uint64Vec => Some(Value::Uint64Vec(v.clone())),
        _ => None,
    }
}

/// The numbers as values of a type that is nothing but numbers; none when they do not fill whole values.
fn grouped<N: Pod, T: Pod>(numbers: &[N]) -> Option<Vec<T>> {
    bytemuck::try_cast_slice(numbers).ok().map(<[T]>::to_vec)
}

fn floats(kind: ValueKind, v: &[f32]) -> Option<Value> {
    use ValueKind as K;
    Some(match kind {
        K::FloatVec => Value::FloatVec(v.to_vec()),
        K::Vec2fVec => Value::Vec2fVec(grouped(v)?),
        K::Vec3fVec => Value::Vec3fVec(grouped(v)?),
        K::Vec4fVec => Value::Vec4fVec(grouped(v)?),
        K::QuatfVec => Value::QuatfVec(grouped(v)?),
        _ => return halves(kind, &v.iter().map(|&x| f16::from_f32(x)).collect::<Vec<_>>()),
    })
}

fn halves(kind: ValueKind, v: &[f16]) -> Option<Value> {
    use ValueKind as K;
    Some(match kind {
        K::HalfVec => Value::HalfVec(v.to_vec()),
        K::Vec2hVec => Value::Vec2hVec(grouped(v)?),
        K::Vec3hVec => Value::Vec3hVec(grouped(v)?),
        K::Vec4hVec => Value::Vec4hVec(grouped(v)?),
        K::QuathVec => Value::QuathVec(grouped(v)?),
        _ => return None,
    })
}

fn doubles(kind: ValueKind, v: &[f64]) -> Option<Value> {
    use ValueKind as K;
    Some(match kind {
        K::DoubleVec => Value::DoubleVec(v.to_vec()),
        K::Vec2dVec => Value::Vec2dVec(grouped(v)?),
        K::Vec3dVec => Value::Vec3dVec(grouped(v)?),
        K::Vec4dVec => Value::Vec4dVec(grouped(v)?),
        K::QuatdVec => Value::QuatdVec(grouped(v)?),
        K::Matrix2dVec => Value::Matrix2dVec(grouped(v)?),
        K::Matrix3dVec => Value::Matrix3dVec(grouped(v)?),
        K::Matrix4dVec => Value::Matrix4dVec(grouped(v)?),
        K::TimeCodeVec => Value::TimeCodeVec(v.iter().map(|&t| TimeCode(t)).collect()),
        _ => return None,
    })
}

fn ints(kind: ValueKind, v: &[i32]) -> Option<Value> {
    use ValueKind as K;
    Some(match kind {
        K::IntVec => Value::IntVec(v.to_vec()),
        K::Vec2iVec => Value::Vec2iVec(grouped(v)?),
        K::Vec3iVec => Value::Vec3iVec(grouped(v)?),
        K::Vec4iVec => Value::Vec4iVec(grouped(v)?),
        _ => return None,
    })
}

fn texts(kind: ValueKind, v: &[String]) -> Option<Value> {
    use ValueKind as K;
    Some(match kind {
        K::StringVec => Value::StringVec(v.to_vec()),
        K::TokenVec => Value::TokenVec(v.iter().map(Token::from).collect()),
        K::AssetPathVec => Value::AssetPathVec(v.iter().map(AssetPath::new).collect()),
        _ => return None,
    })
}

/// How values of a type combine: normals and quaternions keep their length, other real numbers are summed, and the
/// rest is taken as it is.
pub fn mixing(type_name: &ValueTypeName) -> Mixing {
    use ValueKind as K;
    match type_name.kind() {
        Some(K::QuathVec | K::QuatfVec | K::QuatdVec) => Mixing::Rotation,
        _ if type_name.role() == Some(Role::Normal) => Mixing::Direction,
        Some(
            K::HalfVec
            | K::Vec2hVec
            | K::Vec3hVec
            | K::Vec4hVec
            | K::FloatVec
            | K::Vec2fVec
            | K::Vec3fVec
            | K::Vec4fVec
            | K::DoubleVec
            | K::Vec2dVec
            | K::Vec3dVec
            | K::Vec4dVec
            | K::Matrix2dVec
            | K::Matrix3dVec
            | K::Matrix4dVec
            | K::TimeCodeVec,
        ) => Mixing::Linear,
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
