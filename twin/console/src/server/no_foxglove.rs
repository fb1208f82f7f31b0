//! Replaces the Foxglove server in a build without the feature `foxglove-ws`.

use std::net::{IpAddr, SocketAddr};
use std::sync::Arc;

use tokio::sync::watch;
use tokio::task::JoinHandle;

use crate::server::App;
use crate::server::listen::Beside;

/// Refuses to start a Foxglove server.
///
/// # Errors
/// Always: a sentence that names the missing feature.
#[expect(clippy::unused_async, reason = "the server that it stands for is asynchronous")]
pub(super) async fn start(
    _: IpAddr,
    _: Beside,
    _: Arc<App>,
    _: watch::Receiver<bool>,
) -> Result<(SocketAddr, JoinHandle<()>), String> {
    Err("this twin was built without the feature foxglove-ws".to_owned())
}
