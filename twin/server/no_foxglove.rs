//! Stands for the Foxglove server in a build without the feature `foxglove-ws`.

use std::collections::BTreeMap;
use std::net::{IpAddr, SocketAddr};
use std::sync::Arc;

use tokio::task::JoinHandle;

use crate::scenario::VehicleFiles;
use crate::server::App;

/// Refuses.
///
/// # Errors
/// Always: which feature is missing.
#[expect(clippy::unused_async, reason = "the server that it stands for is asynchronous")]
pub(super) async fn start(
    _: IpAddr,
    _: u16,
    _: Arc<App>,
    _: BTreeMap<String, VehicleFiles>,
) -> Result<(SocketAddr, JoinHandle<()>), String> {
    Err("this twin was built without the feature foxglove-ws".to_owned())
}
