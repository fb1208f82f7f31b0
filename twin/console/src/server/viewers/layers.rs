//! Layers that an operator of a viewer may hide: the reference, the trails and the arrows. Each connection has its own choice,
//! and a restart of the flight does not change it.

use crate::server::viewers::drawing::GHOST;
use crate::server::viewers::forces::FORCES;
use crate::server::viewers::trail::TRAILS;

/// Label and path of each layer.
pub(super) const LAYERS: [(&str, &str); 3] =
    [("reference", GHOST), ("trails", TRAILS), ("forces", FORCES)];

/// The visibility of the layers for one client, in the order of [`LAYERS`].
#[derive(Clone, Debug, Default)]
pub(super) struct Layers {
    hidden: [bool; LAYERS.len()],
    told: [bool; LAYERS.len()],
}

impl Layers {
    /// Shows or hides the layer called `label`; `None` toggles it. Returns whether the layer exists.
    pub(super) fn show(&mut self, label: &str, visible: Option<bool>) -> bool {
        let found = LAYERS.iter().position(|(known, _)| *known == label);
        if let Some(index) = found {
            self.hidden[index] = visible.map_or(!self.hidden[index], |visible| !visible);
        }
        found.is_some()
    }

    /// Notes that the viewer has drawn everything anew, which makes all layers visible.
    pub(super) fn drawn_anew(&mut self) {
        self.told = [false; LAYERS.len()];
    }

    /// Path and visibility of each layer whose visibility has changed. The caller must send them, because they count as sent.
    pub(super) fn changes(&mut self) -> Vec<(&'static str, bool)> {
        let changed = (0..LAYERS.len()).filter(|&index| self.hidden[index] != self.told[index]);
        let changes = changed.map(|index| (LAYERS[index].1, !self.hidden[index])).collect();
        self.told = self.hidden;
        changes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_choice_is_told_once_and_again_after_everything_was_drawn_anew() {
        let mut layers = Layers::default();
        assert!(layers.changes().is_empty());
        assert!(layers.show("trails", None) && !layers.show("floor", None));
        assert_eq!(layers.changes(), [(TRAILS, false)]);
        assert!(layers.changes().is_empty());
        layers.drawn_anew();
        assert_eq!(layers.changes(), [(TRAILS, false)]);
        layers.show("trails", Some(true));
        layers.show("reference", Some(true));
        assert_eq!(layers.changes(), [(TRAILS, true)]);
    }
}
