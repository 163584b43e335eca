//! Families whose subsets break their rule.

use super::{cloth, subset};
use crate::codes;
use crate::connectivity::{FaceId, VertexId};
use crate::error::Warning;
use crate::garment::{Elements, Family, FamilyType, Garment, check_garment};

/// The rule of a family after the check, and the one warning of it.
fn checked(family: &str, change: impl Fn(&mut Garment)) -> (FamilyType, Warning) {
    let mut input = cloth();
    change(&mut input);
    let (before, sets) = (input.families.clone(), input.subsets.len());
    let (mesh, warnings) = check_garment(input).expect("a mesh without faults");
    let found: Vec<Warning> = warnings.into_iter().filter(|w| w.code == codes::FAMILY_RULE).collect();
    let [warning] = &found[..] else { panic!("{found:?}") };
    assert_eq!(warning.place, format!("/Coat/model.subsetFamily:{family}:familyType"));
    assert_eq!(mesh.subsets.len(), sets);
    for (before, after) in before.iter().zip(&mesh.families).filter(|(before, _)| before.name != family) {
        assert_eq!(before, after, "other families keep their rule");
    }
    let rule = mesh.families.iter().find(|f| f.name == family).expect("the family stays").kind;
    (rule, warning.clone())
}

#[test]
fn a_partition_with_gaps_is_not_overlapping() {
    let (rule, warning) = checked("panels", |i| i.subsets[1].indices = vec![0]);
    assert_eq!(rule, FamilyType::NonOverlapping);
    assert_eq!(warning.elements, Elements::Faces(vec![FaceId::new(2)]));
    assert!(warning.problem.starts_with("1 face of the mesh are in no subset"), "{}", warning.problem);

    let (rule, warning) = checked("seams", |i| i.families[1].kind = FamilyType::Partition);
    assert_eq!((rule, warning.elements.len()), (FamilyType::NonOverlapping, 12 - 3));
}

#[test]
fn subsets_with_common_elements_are_unrestricted() {
    let (rule, warning) = checked("panels", |i| i.subsets[1].indices.push(3));
    assert_eq!((rule, warning.elements), (FamilyType::Unrestricted, Elements::Faces(vec![FaceId::new(3)])));

    let (rule, warning) = checked("seams", |i| i.subsets[3].indices = vec![4, 1]);
    let Elements::Edges(edges) = &warning.elements else { panic!("{warning:?}") };
    let ends: Vec<[usize; 2]> = edges.iter().map(|ends| ends.map(VertexId::index)).collect();
    assert_eq!((rule, ends.len()), (FamilyType::Unrestricted, 1));
    assert!(ends[0] == [1, 4] || ends[0] == [4, 1], "{ends:?}");

    let (rule, warning) = checked("dots", |i| {
        i.families.push(Family { name: "dots".into(), kind: FamilyType::NonOverlapping });
        i.subsets[4].family = "dots".into();
        i.subsets.push(subset("more", "point", "dots", &[1, 2]));
    });
    assert_eq!((rule, warning.elements), (FamilyType::Unrestricted, Elements::Points(vec![VertexId::new(2)])));
}
