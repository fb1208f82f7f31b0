//! What a viewer's operator may hide: the reference, the trails and the arrows. Each connection has its own choice, which outlives a
//! restart of the flight.

use crate::server::viewers::drawing::GHOST;
use crate::server::viewers::forces::FORCES;
use crate::server::viewers::trail::TRAILS;

/// Label and path of everything that can be hidden.
pub(super) const LAYERS: [(&str, &str); 3] =
    [("reference", GHOST), ("trails", TRAILS), ("forces", FORCES)];

/// What one client sees of the layers, in the order of [`LAYERS`].
#[derive(Clone, Debug, Default)]
pub(super) struct Layers {
    hidden: [bool; LAYERS.len()],
    told: [bool; LAYERS.len()],
}

impl Layers {
    /// Shows or hides the layer called `label`; `None` turns it over. Whether there is such a layer.
    pub(super) fn show(&mut self, label: &str, visible: Option<bool>) -> bool {
        let found = LAYERS.iter().position(|(known, _)| *known == label);
        if let Some(index) = found {
            self.hidden[index] = visible.map_or(!self.hidden[index], |visible| !visible);
        }
        found.is_some()
    }

    /// Everything was drawn anew, and so is visible.
    pub(super) fn drawn_anew(&mut self) {
        self.told = [false; LAYERS.len()];
    }

    /// Paths whose visibility the client does not know yet, with what it is; they count as told.
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
