//! Routes of the stock viewers: their pages from the viewer folder, and the sockets of viser and of Drake's page at the same paths.
//! (The socket of MeshCat is at `/`.)

use std::sync::Arc;

use axum::Router;
use axum::extract::State;
use axum::http::header::{
    CACHE_CONTROL, CONTENT_SECURITY_POLICY, CONTENT_TYPE, SEC_WEBSOCKET_PROTOCOL,
};
use axum::http::{HeaderMap, StatusCode};
use axum::response::{IntoResponse, Redirect, Response};
use axum::routing::get;

use crate::server::App;
use crate::server::client::connect;
use crate::server::socket::{NoUpgrade, Upgrade};
use crate::server::viewers::meshcat::MeshCat;
use crate::server::viewers::viser::Viser;
use crate::server::viewers::{DRAKE, MESHCAT, VISER, Wheel};
use twin_input::budget::VIEWER_BYTES;

/// Content policy of the stock pages. They have inline scripts, evaluate the callbacks of controls, and load parts of themselves
/// from `data:` and `blob:`. They too may talk to this server only.
const POLICY: &str = "default-src 'none'; script-src 'self' 'unsafe-inline' 'unsafe-eval' blob: data:; \
    worker-src 'self' blob: data:; style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; \
    font-src 'self' data:; connect-src 'self' data: blob:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// Start of the sub-protocol that a viser client asks for; the client's version follows.
const VISER_PROTOCOL: &str = "viser-v";

const HTML: &str = "text/html; charset=utf-8";

/// Routes of the viewers.
pub(in crate::server) fn routes() -> Router<Arc<App>> {
    Router::new()
        .route("/meshcat", get(|| async { Redirect::permanent("/meshcat/") }))
        .route("/meshcat/", get(meshcat_page))
        .route("/meshcat/main.min.js", get(meshcat_script))
        .route("/drake", get(|| async { Redirect::permanent("/drake/") }))
        .route("/drake/", get(drake))
        .route("/drake/meshcat.js", get(drake_script))
        .route("/viser", get(viser))
        .route("/viser/", get(viser))
}

async fn meshcat_page(State(app): State<Arc<App>>) -> Response {
    file(&app, MESHCAT, "index.html", HTML).await
}

async fn meshcat_script(State(app): State<Arc<App>>) -> Response {
    file(&app, MESHCAT, "main.min.js", "text/javascript; charset=utf-8").await
}

/// Drake's page, or its socket at the same path.
async fn drake(
    upgrade: Result<Upgrade, NoUpgrade>,
    State(app): State<Arc<App>>,
    headers: HeaderMap,
) -> Response {
    match upgrade {
        Ok(upgrade) => connect(upgrade, app, MeshCat::default()),
        Err(refused) if headers.contains_key("upgrade") => refused.into_response(),
        Err(_) => file(&app, DRAKE, "index.html", HTML).await,
    }
}

async fn drake_script(State(app): State<Arc<App>>) -> Response {
    file(&app, DRAKE, "meshcat.js", "text/javascript; charset=utf-8").await
}

/// viser's page, or its socket at the same path.
async fn viser(
    upgrade: Result<Upgrade, NoUpgrade>,
    State(app): State<Arc<App>>,
    headers: HeaderMap,
) -> Response {
    match upgrade {
        Ok(upgrade) => {
            let asked = headers.get(SEC_WEBSOCKET_PROTOCOL).and_then(|value| value.to_str().ok());
            let Some(protocol) = asked.and_then(viser_protocol) else {
                return (StatusCode::BAD_REQUEST, "expected the sub-protocol viser-v1.1.1")
                    .into_response();
            };
            if protocol != format!("{VISER_PROTOCOL}{}", VISER.version) {
                tracing::warn!(
                    "a viser client asks for the sub-protocol {protocol}; only version {} is known to work",
                    VISER.version
                );
            }
            connect(upgrade.protocol(&protocol), app, Viser::default())
        }
        Err(refused) if headers.contains_key("upgrade") => refused.into_response(),
        Err(_) => file(&app, VISER, "index.html", HTML).await,
    }
}

/// Chooses the sub-protocol to accept. It must be one that the client asked for, or the browser aborts the connection.
fn viser_protocol(asked: &str) -> Option<String> {
    let mut names = asked.split(',').map(str::trim);
    names.find(|name| name.starts_with(VISER_PROTOCOL) && name.len() < 64).map(str::to_owned)
}

/// Answers with a file of the viewer folder. `name` comes from the routes above only, never from a client.
async fn file(app: &App, wheel: Wheel, name: &'static str, mime: &'static str) -> Response {
    let Some(folder) = app.viewer_dir.clone() else {
        return absent(wheel);
    };
    let path = folder.join(wheel.folder()).join(name);
    match tokio::task::spawn_blocking(move || twin_input::file::read(&path, VIEWER_BYTES)).await {
        Ok(Ok(bytes)) => {
            let headers = [
                (CONTENT_TYPE, mime),
                (CONTENT_SECURITY_POLICY, POLICY),
                (CACHE_CONTROL, "no-cache"),
            ];
            (headers, bytes).into_response()
        }
        _ => absent(wheel),
    }
}

fn absent(wheel: Wheel) -> Response {
    let flag = if wheel.package == DRAKE.package { " --drake" } else { "" };
    let text = format!(
        "the {} viewer is not installed: run `twin viewers fetch{flag}` once, then reload this page\n",
        wheel.package
    );
    (StatusCode::NOT_FOUND, text).into_response()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_viser_sub_protocol_is_found_among_others_and_nothing_else_is_echoed() {
        assert_eq!(viser_protocol("viser-v1.1.1").as_deref(), Some("viser-v1.1.1"));
        assert_eq!(viser_protocol("chat, viser-v1.0.30").as_deref(), Some("viser-v1.0.30"));
        for foreign in ["", "chat", "viser", &format!("viser-v{}", "1".repeat(100))] {
            assert_eq!(viser_protocol(foreign), None, "{foreign}");
        }
    }
}
