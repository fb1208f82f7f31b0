//! What is known of one viewer's client, whichever of the two protocols it speaks.

use rmpv::Value;

use crate::server::client::shown;
use crate::server::hub::Client;
use crate::server::published::Published;
use crate::server::telemetry::{Picture, Telemetry};
use crate::server::viewers::controls::Sliders;
use crate::server::viewers::drawing::{Drawing, Told};
use crate::server::viewers::forces::Forces;
use crate::server::viewers::layers::Layers;
use crate::server::viewers::pack;
use crate::server::viewers::trail::Trails;

/// Most of a message's fault that a reason repeats, characters.
const REASON_CHARACTERS: usize = 80;

/// What one client was told and shows.
#[derive(Default)]
pub(super) struct Watched {
    pub(super) drawing: Drawing,
    pub(super) sliders: Sliders,
    pub(super) layers: Layers,
    pub(super) trails: Trails,
    pub(super) forces: Forces,
    told: Told,
}

impl Watched {
    /// Nothing was ever drawn.
    pub(super) fn is_new(&self) -> bool {
        self.sliders.is_empty()
    }

    /// Everything from nothing, or after a restart the new scene.
    pub(super) fn begin(&mut self, published: &Published) {
        self.drawing = Drawing::new(&published.scene);
        self.told = Told::default();
        self.sliders.set(&published.gains);
        self.layers.drawn_anew();
        self.trails = Trails::new(&published.channels);
        self.forces = Forces::new(&published.channels);
    }

    /// Takes rows in for what is drawn of them.
    pub(super) fn extend(&mut self, telemetry: &Telemetry) {
        self.trails.extend(telemetry);
        self.forces.extend(telemetry);
    }

    /// Place and pose of the moving nodes that have moved.
    pub(super) fn moved<'a>(
        &'a mut self,
        picture: &'a Picture,
    ) -> impl Iterator<Item = (usize, [f32; 7])> {
        self.told.news(self.drawing.poses(picture))
    }
}

/// What a client sent; a client that sends what cannot be read is closed.
pub(super) fn understood(bytes: &[u8], client: &Client) -> Option<Value> {
    let said = pack::decode(bytes);
    said.inspect_err(|why| not_understood(why, client)).ok()
}

/// Closes a client with what is wrong with its message.
pub(super) fn not_understood(why: &str, client: &Client) {
    client.close(1007, format!("message not understood: {}", shown(why, REASON_CHARACTERS)));
}
