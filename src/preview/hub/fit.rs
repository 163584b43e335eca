//! Shows the garment and the body on the way from one body to the other.

use super::Hub;
use crate::messages::Role;
use std::collections::BTreeMap;
use std::sync::Arc;

impl Hub {
    /// Shows the garment and the body after a share of the way; nothing changes without a fit.
    pub fn show_on_way(&self, share: f64) {
        let stage = self.snapshot().stage;
        let Some((message, meshes)) = stage.on_way(share) else { return };
        self.change(|shared| {
            if !Arc::ptr_eq(&shared.snapshot.stage, &stage) {
                return;
            }
            let mut on_way = BTreeMap::new();
            for (role, points) in [Role::Model, Role::Body].into_iter().zip(meshes) {
                let shown = shared.snapshot.shown.get(&role).map(|shown| Arc::new(shown.moved(points)));
                on_way.extend(shown.map(|shown| (role, shown)));
            }
            shared.snapshot.on_way = on_way;
            shared.snapshot.fit = Some(Arc::new(message));
        });
    }
}
