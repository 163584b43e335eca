//! The operators of merged options, also where a recipe has faults.

use super::{Layers, Recipe};
use serde::Serialize;
use serde_json::{Map, Value};

/// An operator with its place in the order.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS), ts(rename = "Stacked"))]
pub struct ListedOperator {
    /// The group of its options, such as `seam`.
    #[cfg_attr(feature = "typescript", ts(type = "KindName"))]
    pub kind: &'static str,
    /// Its name.
    pub name: String,
    /// The start of its keys, such as `seam.side`.
    pub full: String,
    /// False if `render.operators` leaves it out.
    pub listed: bool,
}

impl Layers {
    /// The operators in the order in which they run; those that `render.operators` leaves out are last.
    pub fn operators(&self) -> Vec<ListedOperator> {
        let mut others = self.default_order();
        let listed = self.list();
        let mut order: Vec<ListedOperator> = Vec::new();
        for entry in &listed {
            let found = others.iter().position(|one| one.full == *entry);
            if let Some(at) = found.or_else(|| others.iter().position(|one| one.name == *entry)) {
                order.push(others.remove(at));
            }
        }
        others.iter_mut().for_each(|one| one.listed = listed.is_empty());
        order.extend(others);
        order
    }

    /// True if `render.operators` has all operators in the order that holds without it.
    pub fn lists_default_order(&self) -> bool {
        self.list().into_iter().eq(self.default_order().into_iter().map(|one| one.full))
    }

    fn list(&self) -> Vec<String> {
        let list = self.map().get("render").and_then(|render| render.get("operators")).and_then(Value::as_array);
        list.into_iter().flatten().filter_map(|name| name.as_str().map(str::to_owned)).collect()
    }

    fn default_order(&self) -> Vec<ListedOperator> {
        let of_kind = |kind: &'static str| {
            let names = self.map().get(kind).and_then(Value::as_object).into_iter().flat_map(Map::keys);
            names.map(move |name| ListedOperator {
                kind,
                name: name.clone(),
                full: format!("{kind}.{name}"),
                listed: true,
            })
        };
        Recipe::OPERATORS.iter().flat_map(|group| of_kind(group.name)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layers(list: &[&str]) -> Layers {
        let mut layers = Layers::default();
        let all = serde_json::json!({
            "seam": {"side": {}, "hem": {}}, "fold": {"neck": {}}, "render": {"operators": list},
        });
        layers.add(all.as_object().cloned().unwrap_or_default());
        layers
    }

    fn order(list: &[&str]) -> Vec<(String, bool)> {
        layers(list).operators().into_iter().map(|one| (one.full, one.listed)).collect()
    }

    #[test]
    fn the_list_comes_first_and_names_may_lack_their_kind() {
        let all =
            |names: &[(&str, bool)]| names.iter().map(|&(name, listed)| (name.to_owned(), listed)).collect::<Vec<_>>();
        assert_eq!(order(&[]), all(&[("fold.neck", true), ("seam.hem", true), ("seam.side", true)]));
        let expected = all(&[("seam.side", true), ("fold.neck", true), ("seam.hem", false)]);
        assert_eq!(order(&["side", "fold.neck", "side", "gone"]), expected);
    }

    #[test]
    fn the_default_order_is_known() {
        assert!(layers(&["fold.neck", "seam.hem", "seam.side"]).lists_default_order());
        assert!(!layers(&["seam.side", "seam.hem", "fold.neck"]).lists_default_order());
    }
}
