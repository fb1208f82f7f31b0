//! The state of one client of a stock viewer that does not depend on its protocol.

use rmpv::Value;

use crate::server::App;
use crate::server::client::{refuse_data, shown};
use crate::server::hub::Client;
use crate::server::published::Published;
use crate::server::socket::code;
use crate::server::telemetry::{Picture, Telemetry};
use crate::server::viewers::controls::Sliders;
use crate::server::viewers::drawing::{Drawing, SentPoses};
use crate::server::viewers::forces::Forces;
use crate::server::viewers::layers::Layers;
use crate::server::viewers::pack;
use crate::server::viewers::trail::Trails;

/// The reason of a closed connection quotes at most this many characters of a decoding error.
const REASON_CHARACTERS: usize = 80;

/// The drawing, the controls and the poses that one client has got.
#[derive(Default)]
pub(super) struct ViewerState {
    pub(super) drawing: Drawing,
    pub(super) sliders: Sliders,
    pub(super) layers: Layers,
    pub(super) trails: Trails,
    pub(super) forces: Forces,
    told: SentPoses,
}

impl ViewerState {
    /// Whether the client is new, so that nothing was drawn for it yet.
    pub(super) fn is_new(&self) -> bool {
        self.sliders.is_empty()
    }

    /// Starts with the scene, the gains and the channels of a new flight.
    pub(super) fn begin(&mut self, published: &Published) {
        self.drawing = Drawing::new(&published.scene);
        self.told = SentPoses::default();
        self.sliders.set(&published.gains);
        self.layers.drawn_anew();
        self.trails = Trails::new(&published.channels);
        self.forces = Forces::new(&published.channels);
    }

    /// Adds rows to the trails and the arrows.
    pub(super) fn extend(&mut self, telemetry: &Telemetry) {
        self.trails.extend(telemetry);
        self.forces.extend(telemetry);
    }

    /// Index and pose of each moving node whose pose has changed.
    pub(super) fn moved<'a>(
        &'a mut self,
        picture: &'a Picture,
    ) -> impl Iterator<Item = (usize, [f32; 7])> {
        self.told.news(self.drawing.poses(picture))
    }
}

/// Decodes a message of a client; closes the connection if the message cannot be decoded.
pub(super) fn understood(bytes: &[u8], client: &Client, app: &App) -> Option<Value> {
    let said = pack::decode(bytes);
    said.inspect_err(|why| {
        refuse_data(code::INVALID, &shown(why, REASON_CHARACTERS), client, app);
    })
    .ok()
}
