//! Sets of a sheet whose elements can be counted by hand.

use super::*;
use tailor_mesh::garment::{DERIVED, Garment, Interpolation, PrimvarInput, Subset, Values, check_garment};
use tailor_testing::sheets::{grid, with_uvs};

/// A sheet of 4 by 4 quads whose left half has UVs of its own. Points are numbered row by row.
fn garment() -> Mesh {
    let mut input: Garment = grid(4, 4, |_, _| true);
    input.primvars.retain(|primvar| primvar.name != "st");
    let mut input = with_uvs(input, |face, point| {
        let shift = if face % 4 < 2 { 0.0 } else { 10.0 };
        [(point % 5) as f32 + shift, (point / 5) as f32]
    });
    let panel = (0..16).map(|face| i32::from(face % 4 == 3)).collect();
    input.primvars.push(PrimvarInput::new("panel", Interpolation::Uniform, Values::I32(panel)));
    let weights = (0..25).map(|point| if point < 10 { 1.0 } else { 0.25 }).collect();
    input.primvars.push(PrimvarInput::weights("pin", weights));
    check_garment(input).expect("a good mesh").0
}

fn count(text: &str) -> usize {
    let garment = garment();
    let derived = SetEvaluator::new(&garment, "st").evaluate(text);
    derived.unwrap_or_else(|fault| panic!("{text}: {}", fault.text)).elements.len()
}

#[test]
fn functions_find_the_elements_of_a_sheet() {
    for (text, expected) in [
        ("borders", 16),
        ("borders.1", 16),
        ("borders.2", 0),
        ("uvSeams", 4),
        ("uvShells.2", 8),
        ("edges", 40),
        ("value(panel)", 4),
        ("value(panel, 0)", 12),
        ("regions(panel)", 4),
        ("border(value(panel))", 10),
        ("border(value(panel)) - borders", 4),
        ("between(value(panel, 0), value(panel, 1))", 4),
        ("weight(pin)", 10),
        ("weight(pin, 0.1)", 25),
        ("edges(weight(pin))", 13),
        ("faces(weight(pin))", 4),
        ("points(uvSeams)", 5),
        ("faces(uvSeams)", 8),
        ("rings(borders)", 12),
        ("rings(borders, 2)", 16),
        ("rings(value(panel))", 8),
        ("within(border(value(panel)) - borders, 0.6)", 8),
        ("shell(value(panel))", 8),
        ("udim(1011)", 1),
        ("borders & edges(weight(pin))", 6),
        ("creases + featureLines", 0),
    ] {
        assert_eq!(count(text), expected, "{text}");
    }
}

#[test]
fn chains_go_on_in_one_direction() {
    let garment = garment();
    for text in ["uvSeams", "borders", "border(value(panel))"] {
        let derived = SetEvaluator::new(&garment, "st").evaluate(text).expect(text);
        let Elements::Edges(edges) = derived.elements else { panic!("{text} gives edges") };
        let starts: std::collections::BTreeSet<_> = edges.iter().map(|edge| edge[0]).collect();
        assert_eq!(starts.len(), edges.len(), "{text}: no two edges leave one point");
    }
}

#[test]
fn faults_name_what_there_is() {
    let garment = garment();
    let evaluate = |text: &str| SetEvaluator::new(&garment, "st").evaluate(text);
    for (text, problem, remedy) in [
        ("uvSeam", "is not a subset", "did you mean uvSeams?"),
        ("border(uvSeams)", "is not a set of faces, and edges are given", "border(faces)"),
        ("borders + faces", "edges and faces cannot be combined", "faces(...)"),
        ("udim()", "has 0 arguments", "udim(tile)"),
        ("rings(borders, 0.5)", "the count 0.5", "whole number"),
    ] {
        let fault = evaluate(text).expect_err(text);
        assert!(fault.text.contains(problem) && fault.remedy.contains(remedy), "{}: {}", fault.text, fault.remedy);
    }
    for (text, note) in [
        ("material(wool)", "the materials are: none"),
        ("borders.3", "the set has 1 pieces"),
        ("weight(pin, 1)", "its largest value is 1"),
        ("uvSeams(map2)", "the face-varying UV sets are: st"),
        ("value(panel, 7)", "its first values are: 0, 1"),
    ] {
        let derived = evaluate(text).expect(text);
        assert!(derived.elements.is_empty() && derived.notes.iter().any(|found| found.contains(note)), "{text}");
    }
}

#[test]
fn every_listed_set_is_what_its_expression_gives() {
    let garment = garment();
    let evaluator = SetEvaluator::new(&garment, "st");
    let listed = evaluator.list();
    for set in &listed {
        let derived = evaluator.evaluate(&set.expression).expect("an expression");
        assert_eq!(derived.elements.len(), set.count, "{}", set.expression);
    }
    let expressions: Vec<&str> = listed.iter().map(|set| set.expression.as_str()).collect();
    for expected in ["borders.1", "uvSeams.1", "value(panel, 1)", "weight(pin)", "uvShells.2"] {
        assert!(expressions.contains(&expected), "{expressions:?}");
    }
}

/// The selection after changes, each a sign and a set; none where no element is left.
fn selected(changes: &[(Change, &str)]) -> Option<ListedSet> {
    let garment = garment();
    let evaluator = SetEvaluator::new(&garment, "st");
    let subset = |set: &ListedSet| Subset {
        name: set.expression.clone(),
        family: DERIVED.to_owned(),
        elements: set.elements.clone(),
        sharpness: None,
    };
    let known: Vec<Subset> = evaluator.list().iter().map(subset).collect();
    let mut last: Option<ListedSet> = None;
    for (change, set) in changes {
        let before = last.map_or_else(String::new, |set| set.expression);
        last = evaluator.select(&before, *change, set, &known).unwrap_or_else(|fault| panic!("{set}: {}", fault.text));
        if let Some(set) = &last {
            let again = evaluator.evaluate(&set.expression).expect("an expression");
            assert_eq!(again.elements.len(), set.count, "{}", set.expression);
        }
    }
    last
}

/// The expression of picked edges or faces.
fn picked(kind: &str, numbers: &str) -> String {
    format!("picked{kind}(\"{}\", \"{numbers}\")", checksum(&garment().faces))
}

#[test]
fn a_selection_has_the_name_of_a_set_or_else_its_own_numbers() {
    let expression = |changes: &[(Change, &str)]| selected(changes).map(|set| set.expression);
    let [seam, column, lower] = ["2-7", "1-6", "7-2"].map(|ends| picked("Edges", ends));
    let [seam_line, column_line] = [&seam, &column].map(|edge| format!("loops({edge})"));
    let replaced = |set: &str| expression(&[(Change::Replace, set)]);
    assert_eq!(replaced(&seam_line).as_deref(), Some("uvSeams.1"));
    assert_eq!(replaced(&column_line), Some(picked("Edges", "1-6-11-16-21")));
    assert_eq!(replaced("borders - edges(weight(pin))").as_deref(), Some("borders - edges(weight(pin))"));
    let both = format!("loops({seam} + {})", picked("Edges", "0-1"));
    assert_eq!(replaced(&both).as_deref(), Some("borders.1 + uvSeams.1"));
    let sum = [(Change::Replace, seam_line.as_str()), (Change::Add, "borders - edges(weight(pin))")];
    assert_eq!(expression(&sum).as_deref(), Some("uvSeams.1 + (borders - edges(weight(pin)))"));
    // A row of quads goes on across the seam, and the seam across the row.
    let half = picked("Edges", "10-11-12");
    assert_eq!(replaced(&format!("onward({half})")), Some(picked("Edges", "14-13-12-11-10")));
    let lower_seam = picked("Edges", "2-7-12");
    assert_eq!(replaced(&format!("onward({lower_seam})")).as_deref(), Some("uvSeams.1"));
    let path = format!("path({}, {})", picked("Edges", "0-1"), picked("Edges", "3-4"));
    assert_eq!(replaced(&path), Some(picked("Edges", "0-1-2-3-4")));
    // Most of the three edges go up.
    let parts = [(Change::Replace, lower.as_str()), (Change::Add, &picked("Edges", "7-12-17"))];
    assert_eq!(expression(&parts), Some(picked("Edges", "2-7-12-17")));
    let faces = [(Change::Replace, "uvShells.1"), (Change::Remove, &picked("Faces", "1, 4-5"))];
    assert_eq!(expression(&faces), Some(picked("Faces", "0, 8-9, 12-13")));
    assert_eq!(expression(&[(Change::Replace, &seam), (Change::Remove, "uvSeams")]), None);
}

#[test]
fn a_path_keeps_to_a_seam_and_goes_straight_on() {
    let garment = garment();
    let sets = SetEvaluator::new(&garment, "st");
    let path = |from: &str, to: &str| {
        let text = format!("path({}, {})", picked("Edges", from), picked("Edges", to));
        sets.select("", Change::Replace, &text, &[]).expect("a path").expect("edges").expression
    };
    let same = |found: String, run: &str| {
        let back: Vec<&str> = run.split('-').rev().collect();
        assert!(found == picked("Edges", run) || found == picked("Edges", &back.join("-")), "{found}");
    };
    // Of the shortest ways from below to above right, the one along the seam.
    same(path("6-7", "17-18"), "6-7-12-17-18");
    // Of those beside the seam, one with two turns.
    same(path("3-8", "14-19"), "3-8-9-14-19");
}

/// A strip of quads around two rows, with points that `place` moves.
fn posed(place: impl Fn(usize, [f32; 3]) -> [f32; 3], has_face: impl Fn(usize) -> bool) -> Mesh {
    let mut input: Garment = grid(6, 4, |x, y| has_face(6 * y + x));
    for (number, point) in input.points.iter_mut().enumerate() {
        *point = place(number, [point.x, point.y, 0.1 * (point.x - 3.0).powi(2) + 0.3 * point.y]).into();
    }
    check_garment(input).expect("a good mesh").0
}

#[test]
fn a_plane_of_symmetry_is_found_by_topology_and_else_by_place() {
    let twin_of = |garment: &Mesh, numbers: &str| {
        let sets = SetEvaluator::new(garment, "st");
        let text = format!("mirror(pickedEdges(\"{}\", \"{numbers}\"))", checksum(&garment.faces));
        let found = sets.evaluate(&text).map(|set| set.elements);
        let symmetry = sets.symmetry().map(|found| (found.axis_name(), found.at, found.share));
        (symmetry, found)
    };
    let even = posed(|_, place| place, |_| true);
    let edge = |ends: [usize; 2]| Elements::Edges(vec![ends.map(tailor_mesh::connectivity::VertexId::new)]);
    // The twin runs the other way, so that the left of the edge stays its left.
    assert_eq!(twin_of(&even, "7-8"), (Some(("x", 3.0, 1.0)), Ok(edge([12, 13]))));
    // One arm is raised: its points have no twin in place.
    let raised = posed(|_, [x, y, z]| [x, y + if x > 4.5 { 3.0 } else { 0.0 }, z], |_| true);
    assert_eq!(twin_of(&raised, "7-8"), (Some(("x", 3.0, 1.0)), Ok(edge([12, 13]))));
    // One side has a hole.
    let torn = posed(|_, place| place, |face| face != 16);
    let (symmetry, found) = twin_of(&torn, "7-8");
    assert_eq!((symmetry.map(|(axis, at, _)| (axis, at)), found), (Some(("x", 3.0)), Ok(edge([12, 13]))));
    assert!(symmetry.is_some_and(|(.., share)| share > 0.9 && share < 1.0));
    let skewed = posed(
        |number, [x, y, z]| [x + 0.3 * y + 0.02 * (number * number % 7) as f32, y, z * x],
        |face| ![0, 4, 9, 16].contains(&face),
    );
    let (symmetry, found) = twin_of(&skewed, "7-8");
    assert!(symmetry.is_none() && found.is_err_and(|fault| fault.text.contains("no plane of symmetry")));
}

#[test]
fn picked_elements_are_of_one_mesh_alone() {
    let garment = garment();
    let evaluate = |text: &str| SetEvaluator::new(&garment, "st").evaluate(text);
    for (text, problem) in [
        ("pickedEdges(\"00000000\", \"0-1\")".to_owned(), "picked on other faces"),
        (picked("Edges", "0-6"), "has no edge 0-6"),
        (picked("Edges", "0-99"), "has no edge 0-99"),
        (picked("Faces", "15-16"), "has no face 16"),
        (picked("Faces", "a"), "words that are not numbers"),
    ] {
        let fault = evaluate(&text).expect_err(&text);
        assert!(fault.text.contains(problem), "{}", fault.text);
    }
    assert!(evaluate(&format!("path(borders, {})", picked("Faces", "3"))).is_err());
}

#[test]
fn painted_weights_are_those_of_their_text() {
    let garment = garment();
    let weights: Vec<f32> = (0..garment.points.len()).map(|point| (point % 6) as f32 / 5.0).collect();
    let text = painted_expression(&garment.faces, &weights);
    let elements = SetEvaluator::new(&garment, "st").evaluate(&text).expect("painted weights").elements;
    let above = weights.iter().filter(|weight| **weight > 0.0).count();
    assert_eq!((elements.kind(), elements.len()), ("point", above));
    let set = Subset { name: text.clone(), family: String::new(), elements, sharpness: None };
    assert_eq!(weights_of(&garment, &set).values, tailor_mesh::garment::Values::F32(weights));
    for (text, fault) in [
        (text.replace(&checksum(&garment.faces), "00000000"), "picked on other faces"),
        (text.replace("33", ""), "two hexadecimal digits"),
        (text.replace("33", "xy"), "two hexadecimal digits"),
    ] {
        let found = SetEvaluator::new(&garment, "st").evaluate(&text).expect_err("a fault").text;
        assert!(found.contains(fault), "{found}");
    }
}

#[test]
fn the_documents_have_every_function() {
    let page = include_str!("../../../docs/sets.md");
    for Function { usage, gives, meaning, .. } in FUNCTIONS {
        let row = format!("| `{usage}` | {gives} | {meaning} |");
        assert!(page.contains(&row), "docs/sets.md lacks: {row}");
    }
}

#[test]
fn a_primvar_with_a_fault_is_told_where_it_is_named() {
    let mut input: Garment = grid(4, 4, |_, _| true);
    input.primvars.push(PrimvarInput::weights("pin", vec![1.0; 7]));
    let garment = check_garment(input).expect("no step needs it").0;
    let fault = SetEvaluator::new(&garment, "st").evaluate("weight(pin)").expect_err("it is left out");
    let error = tailor_mesh::options::float_primvar(&garment, "sim.density", "pin").expect_err("it is left out");
    for (code, text) in [(fault.code, &fault.text), (error.faults[0].code, &error.faults[0].text)] {
        assert!(code == tailor_mesh::codes::VALUE_COUNT && text.contains("primvars:pin holds 7 values"), "{text}");
    }
}

#[test]
fn equal_terms_are_evaluated_once_and_different_ones_are_bounded() {
    let garment = garment();
    let sets = SetEvaluator::new(&garment, "st");
    let evaluation = sets.evaluation();
    let same = vec!["loops(borders)"; 6000].join("+");
    evaluation.evaluate(&Expression::parse(&same).expect("an expression")).expect("edges");
    assert_eq!(evaluation.known.borrow().len(), 2, "borders and their loops");
    let others: Vec<String> = (0..300).map(|i| format!("weight(pin, {})", f64::from(i) / 1000.0)).collect();
    let fault = sets.evaluate(&others.join("+")).expect_err("too many");
    assert!(fault.text.contains("more than 200 different calls") && fault.remedy.contains("--bake"));
    assert!(sets.evaluate(&others[..150].join("+")).is_ok());
}
