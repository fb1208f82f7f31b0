//! Routes: the page and its assets, `/ws`, the stock viewers, and `/api/…` as JSON. A WebSocket upgrade at `/` is a MeshCat
//! client, because the stock viewer knows no other path.

use std::collections::BTreeMap;
use std::sync::Arc;

use axum::body::Bytes;
use axum::extract::rejection::JsonRejection;
use axum::extract::{Path, Request, State};
use axum::http::header::{
    CACHE_CONTROL, CONNECTION, CONTENT_ENCODING, CONTENT_SECURITY_POLICY, CONTENT_TYPE, HOST,
    ORIGIN, REFERRER_POLICY, RETRY_AFTER, X_CONTENT_TYPE_OPTIONS,
};
use axum::http::{HeaderMap, HeaderName, HeaderValue, StatusCode};
use axum::middleware::{self, Next};
use axum::response::{Html, IntoResponse, Response};
use axum::routing::get;
use axum::{Json, Router};
use serde::Deserialize;
use serde_json::json;

use crate::server::admission::Admission;
use crate::server::admission::refusals::Refusal;
use crate::server::client::{Console, connect};
use crate::server::command::{Command, Request as Ask};
use crate::server::forks::ForkRows;
use crate::server::gains::{self, Change};
use crate::server::mirrored;
use crate::server::origin::{OriginError, check_host, check_origin};
use crate::server::pace::now;
use crate::server::protocol::ClientMessage;
use crate::server::socket::{NoUpgrade, Upgrade};
use crate::server::telemetry::{Picture, Telemetry};
use crate::server::viewers::meshcat::MeshCat;
use crate::server::viewers::pages;
use crate::server::{App, assets, metrics, override_file};
use twin_record::program;

/// The page may load from and talk to this server only. Inline styles are allowed because the sliders set style attributes.
const POLICY: &str = "default-src 'none'; script-src 'self'; worker-src 'self' blob:; style-src 'self' 'unsafe-inline'; \
    img-src 'self' data: blob:; font-src 'self'; connect-src 'self'; base-uri 'none'; form-action 'none'; \
    frame-ancestors 'none'";

/// The page that the server shows if the console is not part of this build.
const STATUS_PAGE: &str = "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><title>twin</title>\
    <body style=\"font:16px system-ui;margin:3em;max-width:40em\"><h1>twin</h1>\
    <p>The flight runs, but this build has no console: build with npm installed, or without \
    <code>--no-default-features</code>.</p>\
    <p><a href=\"/api/state\">state</a> · <a href=\"/api/gains\">gains</a> · <a href=\"/api/health\">health</a></p>";

/// All routes.
pub(super) fn router(app: Arc<App>) -> Router {
    Router::new()
        .route("/", get(index))
        .route("/ws", get(upgrade))
        .route("/api/health", get(health))
        .route("/api/state", get(state))
        .route("/api/gains", get(list_gains).post(set_gain))
        .route("/api/override.toml", get(override_toml))
        .route("/api/forks/{id}/{from}", get(fork_rows))
        .route("/metrics", get(metrics_page))
        .merge(pages::routes())
        .route("/{*path}", get(asset))
        .layer(middleware::from_fn_with_state(Arc::clone(&app.admission), guard))
        .with_state(app)
}

/// Refuses requests of foreign hosts and pages, ends requests whose body does not come, and adds the headers that every answer has.
async fn guard(State(admission): State<Arc<Admission>>, request: Request, next: Next) -> Response {
    let headers = request.headers();
    let host = text(headers, &HOST);
    let changes = !request.method().is_safe() || headers.contains_key("upgrade");
    let checked = check_host(host)
        .and_then(|()| if changes { check_origin(text(headers, &ORIGIN), host) } else { Ok(()) });
    let mut response = match checked {
        Ok(()) => in_time(&admission, next.run(request)).await,
        Err(error) => refusal(&error, &admission),
    };
    for (name, value) in [
        (X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (CONTENT_SECURITY_POLICY, POLICY),
        (REFERRER_POLICY, "no-referrer"),
    ] {
        // The routes of the viewers' pages have set their own policy already.
        response.headers_mut().entry(name).or_insert(HeaderValue::from_static(value));
    }
    response
}

/// The answer, or status 408 if it waits too long for the body of its request.
async fn in_time(admission: &Admission, answer: impl Future<Output = Response>) -> Response {
    let limit = admission.limits.body;
    if let Ok(response) = tokio::time::timeout(limit, answer).await {
        return response;
    }
    let why = format!("the body of the request did not arrive within {} s", limit.as_secs_f64());
    admission.refusals.note(Refusal::Body, &why);
    (StatusCode::REQUEST_TIMEOUT, [(CONNECTION, "close")], why).into_response()
}

/// A header as text. A header that is present but not valid text counts as an empty name, which every check refuses.
pub(super) fn text<'a>(headers: &'a HeaderMap, name: &HeaderName) -> Option<&'a str> {
    headers.get(name).map(|value| value.to_str().unwrap_or_default())
}

/// The answer to a request of a foreign host or page.
pub(super) fn refusal(error: &OriginError, admission: &Admission) -> Response {
    let reason = match error {
        OriginError::Host { .. } => Refusal::Host,
        OriginError::Origin { .. } | OriginError::App { .. } => Refusal::Origin,
    };
    admission.refusals.note(reason, error);
    (StatusCode::FORBIDDEN, error.to_string()).into_response()
}

async fn upgrade(upgrade: Result<Upgrade, NoUpgrade>, State(app): State<Arc<App>>) -> Response {
    match upgrade {
        Ok(upgrade) => connect(upgrade, app, Console),
        Err(refused) => refused.into_response(),
    }
}

async fn index(
    upgrade: Result<Upgrade, NoUpgrade>,
    State(app): State<Arc<App>>,
    headers: HeaderMap,
) -> Response {
    match upgrade {
        Ok(upgrade) => return connect(upgrade, app, MeshCat::default()),
        Err(refused) if headers.contains_key("upgrade") => return refused.into_response(),
        Err(_) => {}
    }
    find("index.html").unwrap_or_else(|| Html(STATUS_PAGE).into_response())
}

async fn asset(Path(path): Path<String>) -> Response {
    find(&path).unwrap_or_else(|| (StatusCode::NOT_FOUND, "no such page").into_response())
}

fn find(path: &str) -> Option<Response> {
    let (name, mime, bytes, gzip) = assets::ASSETS.iter().find(|(name, ..)| *name == path)?;
    let mut response = Bytes::from_static(bytes).into_response();
    let headers = response.headers_mut();
    headers.insert(CONTENT_TYPE, HeaderValue::from_static(mime));
    // The name of a built asset changes with its content, so a browser may cache it forever. The name of a page stays.
    let cache = if name.starts_with("assets/") {
        "public, max-age=31536000, immutable"
    } else {
        "no-cache"
    };
    headers.insert(CACHE_CONTROL, HeaderValue::from_static(cache));
    if *gzip {
        headers.insert(CONTENT_ENCODING, HeaderValue::from_static("gzip"));
    }
    Some(response)
}

async fn health(State(app): State<Arc<App>>) -> Response {
    let flying = app.hub.is_flying();
    let state = app.hub.published().state;
    let cost_ms: BTreeMap<String, f64> =
        state.stages.into_iter().map(|stage| (stage.name, stage.ms)).collect();
    let body = json!({
        "status": if flying { "ok" } else { "flight stopped" },
        "version": program::VERSION,
        "git": program::commit(),
        "uptime_s": app.uptime_s(),
        "mean_ms_per_tick": cost_ms,
        "recording": state.recording,
    });
    let status = if flying { StatusCode::OK } else { StatusCode::SERVICE_UNAVAILABLE };
    (status, Json(body)).into_response()
}

async fn state(State(app): State<Arc<App>>) -> Response {
    Json(app.hub.published().state).into_response()
}

async fn list_gains(State(app): State<Arc<App>>) -> Response {
    let published = app.hub.published();
    Json(json!({ "preset": published.preset, "gains": published.gains })).into_response()
}

/// The rows of a fork from its row `from` on, as a telemetry frame without a picture.
async fn fork_rows(State(app): State<Arc<App>>, Path((id, from)): Path<(u32, usize)>) -> Response {
    let schema_id = app.hub.published().schema_id;
    let Some(ForkRows { first_tick, rows }) = app.hub.forks.rows(id, from) else {
        return (StatusCode::NOT_FOUND, "no such fork").into_response();
    };
    let picture = Arc::new(Picture {
        t_s: 0.0,
        poses: Vec::new(),
        ghost: [f32::NAN; 7],
        contacts: Vec::new(),
        spectrum: Vec::new(),
    });
    let frame = Telemetry { schema_id, first_tick, rows, gap: 0, reset: false, picture };
    let bytes = frame.encode(app.uptime_s());
    ([(CONTENT_TYPE, "application/octet-stream"), (CACHE_CONTROL, "no-store")], bytes)
        .into_response()
}

async fn metrics_page(State(app): State<Arc<App>>) -> Response {
    let text = metrics::text(&app.hub.published(), app.uptime_s(), &app.counts());
    ([(CONTENT_TYPE, "text/plain; version=0.0.4; charset=utf-8")], text).into_response()
}

async fn override_toml(State(app): State<Arc<App>>) -> Response {
    let text = override_file::text(&app.hub.published());
    ([(CONTENT_TYPE, "application/toml; charset=utf-8")], text).into_response()
}

/// Body of `POST /api/gains`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct NamedValue {
    name: String,
    value: f64,
}

/// Queues one gain. The answer is "accepted", because the gain takes effect later, between two ticks.
async fn set_gain(
    State(app): State<Arc<App>>,
    body: Result<Json<NamedValue>, JsonRejection>,
) -> Response {
    let error =
        |status: StatusCode, why: String| (status, Json(json!({ "error": why }))).into_response();
    let NamedValue { name, value } = match body {
        Ok(Json(named)) => named,
        Err(rejection) => return error(rejection.status(), rejection.body_text()),
    };
    let asked = ClientMessage::SetGain { name: name.clone(), value };
    if let Some(why) = mirrored::refusal(&asked, app.mirrored) {
        return error(StatusCode::UNPROCESSABLE_ENTITY, why.to_owned());
    }
    let checked = match gains::check(&app.tuning, name.clone(), value) {
        Ok(checked) => checked,
        Err(refused) => return error(StatusCode::UNPROCESSABLE_ENTITY, refused.to_string()),
    };
    let debt = app.admission.overall().debt(now());
    if !debt.is_zero() {
        app.admission.refusals.note(Refusal::Rate, &"POST /api/gains: too many commands");
        let retry = [(RETRY_AFTER, debt.as_secs_f64().ceil().to_string())];
        let why = json!({ "error": "too many commands per second; try again later" });
        return (StatusCode::TOO_MANY_REQUESTS, retry, Json(why)).into_response();
    }
    match app.ask(Ask { client: None, command: Command::Change(Change::Gain(checked)) }) {
        Ok(()) => {
            (StatusCode::ACCEPTED, Json(json!({ "queued": { "name": name, "value": value } })))
                .into_response()
        }
        Err(why) => error(StatusCode::SERVICE_UNAVAILABLE, why.to_owned()),
    }
}
