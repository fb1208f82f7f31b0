//! Checks who talks to the server. It accepts pages that it served itself, and programs on this machine.
//!
//! The server listens on loopback only. A `Host` that is no loopback name therefore comes from a foreign page whose DNS name
//! points to this machine (DNS rebinding); such a page would pass a comparison of `Origin` with `Host`.
//!
//! Foxglove and Lichtblick are pages from elsewhere, or programs that show such a page. The port for Foxglove accepts those of
//! [`KNOWN_APPS`], the pages of this machine, and those that the operator names.

use std::net::IpAddr;

/// Origins of the applications that speak Foxglove's protocol: Foxglove, its former address, Lichtblick, and the desktop programs of both,
/// which load their page from a file.
pub(super) const KNOWN_APPS: [&str; 4] = [
    "https://app.foxglove.dev",
    "https://studio.foxglove.dev",
    "https://lichtblick-suite.github.io",
    "file://",
];

/// The origin of a page, `https://HOST` or `https://HOST:PORT`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AppOrigin(String);

impl std::str::FromStr for AppOrigin {
    type Err = String;

    /// Reads an origin as a browser sends it.
    fn from_str(text: &str) -> Result<Self, String> {
        let lower = text.to_ascii_lowercase();
        let authority = lower.strip_prefix("https://").or_else(|| lower.strip_prefix("http://"));
        let plain =
            |name: &str| !name.is_empty() && !name.contains(['/', '?', '#', '@', '*', ' ', ',']);
        match authority {
            Some(name) if plain(name) => Ok(Self(lower)),
            _ => Err(format!(
                "found {text:?}, expected the origin of one page, https://HOST or https://HOST:PORT"
            )),
        }
    }
}

/// Why a request was refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub(super) enum OriginError {
    /// The `Host` header names another machine.
    #[error(
        "host {found:?} refused: expected localhost, 127.0.0.1 or [::1]; open the console under one of these names"
    )]
    Host {
        /// The header that was sent.
        found: String,
    },
    /// The page comes from another host.
    #[error(
        "origin {found:?} refused: expected a page of this server; open the console from the server itself"
    )]
    Origin {
        /// The header that was sent.
        found: String,
    },
    /// The page is none of the applications that may use the port for Foxglove.
    #[error(
        "origin {found:?} refused: expected {}, a page of this machine, or one named by --foxglove-origin",
        KNOWN_APPS.join(", ")
    )]
    #[cfg_attr(
        not(feature = "foxglove-ws"),
        allow(dead_code, reason = "a build without the port for Foxglove asks no application")
    )]
    App {
        /// The header that was sent.
        found: String,
    },
}

/// Checks the `Host` header of any request; a request without this header is refused.
///
/// # Errors
/// [`OriginError::Host`] if it is no loopback name.
pub(super) fn check_host(host: Option<&str>) -> Result<(), OriginError> {
    match host {
        Some(host) if is_loopback(host_name(host)) => Ok(()),
        other => Err(OriginError::Host { found: shortened(other.unwrap_or_default()) }),
    }
}

/// Checks the `Origin` header of an upgrade or a change. A request without this header is allowed: browsers always send it,
/// and the server listens on loopback only. Any two loopback names count as equal, and any two ports do, because another
/// program of the same user serves a page under development.
///
/// # Errors
/// [`OriginError::Origin`] if the page comes from another host.
pub(super) fn check_origin(origin: Option<&str>, host: Option<&str>) -> Result<(), OriginError> {
    let Some(origin) = origin else {
        return Ok(());
    };
    let refused = || OriginError::Origin { found: shortened(origin) };
    let (scheme, authority) = origin.split_once("://").ok_or_else(refused)?;
    let page = host_name(authority);
    let same =
        is_loopback(page) || host.is_some_and(|host| host_name(host).eq_ignore_ascii_case(page));
    if matches!(scheme, "http" | "https") && same { Ok(()) } else { Err(refused()) }
}

/// Checks the `Origin` header of an upgrade on the port for Foxglove: a program sends none, and a page must be one of [`KNOWN_APPS`], of
/// this machine, or among `more`.
///
/// # Errors
/// [`OriginError::App`] for every other page.
#[cfg_attr(
    not(feature = "foxglove-ws"),
    allow(dead_code, reason = "a build without the port for Foxglove asks no application")
)]
pub(super) fn check_app(origin: Option<&str>, more: &[AppOrigin]) -> Result<(), OriginError> {
    let Some(found) = origin else { return Ok(()) };
    let same = |known: &str| known.eq_ignore_ascii_case(found);
    let known = KNOWN_APPS.into_iter().any(same) || more.iter().any(|AppOrigin(more)| same(more));
    if known || check_origin(origin, None).is_ok() {
        return Ok(());
    }
    Err(OriginError::App { found: shortened(found) })
}

/// Whether `name` is `localhost` or an address of the loopback interface.
pub(super) fn is_loopback(name: &str) -> bool {
    name.eq_ignore_ascii_case("localhost")
        || name.parse::<IpAddr>().is_ok_and(|address| address.is_loopback())
}

/// The name in `name:port` or `[address]:port`; text of any other form is returned as it is, and is no loopback name.
fn host_name(authority: &str) -> &str {
    let name = match authority.rsplit_once(':') {
        Some((name, port))
            if !name.is_empty() && port.bytes().all(|byte| byte.is_ascii_digit()) =>
        {
            name
        }
        _ => authority,
    };
    // An IPv6 address contains colons; its brackets separate it from the port.
    match authority.strip_prefix('[').and_then(|rest| rest.split_once(']')) {
        Some((address, "")) => address,
        Some((address, _)) if name.ends_with(']') => address,
        _ => name,
    }
}

fn shortened(text: &str) -> String {
    text.chars().take(100).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn loopback_names_are_equal_and_others_are_refused() {
        for origin in [
            "http://localhost:8080",
            "http://127.0.0.1:8080",
            "http://[::1]:8080",
            "https://LOCALHOST",
        ] {
            assert_eq!(check_origin(Some(origin), Some("127.0.0.1:8080")), Ok(()), "{origin}");
        }
        let foreign = [
            "http://evil.example",
            "http://localhost.evil.example:8080",
            "http://127.0.0.1.evil.example",
            "http://evil.example:127.0.0.1",
            "null",
            "",
            "file://localhost",
            "http://",
            "http://localhost@evil.example",
            "http://localhost:80@evil.example",
            "http://[::1]evil.example",
            "http://[::1]:80.evil.example",
            "http://evil.example/localhost",
        ];
        for origin in foreign {
            assert!(check_origin(Some(origin), Some("127.0.0.1:8080")).is_err(), "{origin}");
        }
        assert_eq!(check_origin(None, Some("127.0.0.1:8080")), Ok(()));
    }

    #[test]
    fn the_port_for_foxglove_takes_known_applications_this_machine_and_named_pages() {
        let more: Vec<AppOrigin> = vec!["https://Viewer.example:8443".parse().unwrap()];
        for origin in KNOWN_APPS {
            assert_eq!(check_app(Some(origin), &[]), Ok(()), "{origin}");
        }
        for origin in [None, Some("http://localhost:8080"), Some("http://[::1]:1")] {
            assert_eq!(check_app(origin, &[]), Ok(()), "{origin:?}");
        }
        assert_eq!(check_app(Some("https://viewer.example:8443"), &more), Ok(()));
        for foreign in [
            "http://app.foxglove.dev",
            "https://app.foxglove.dev.evil.example",
            "https://evil.example",
            "https://viewer.example",
            "file://evil",
            "null",
            "",
        ] {
            assert!(check_app(Some(foreign), &more).is_err(), "{foreign}");
        }
        for text in ["evil.example", "https://", "https://*", "https://a/b", "null", "ftp://a"] {
            assert!(text.parse::<AppOrigin>().is_err(), "{text}");
        }
    }

    #[test]
    fn a_name_that_was_made_to_point_here_is_refused() {
        for host in ["127.0.0.1:8080", "localhost", "[::1]:80", "127.8.8.8:1"] {
            assert_eq!(check_host(Some(host)), Ok(()), "{host}");
        }
        for host in
            [Some("evil.example:8080"), Some("0.0.0.0:8080"), Some(""), Some("192.168.0.4"), None]
        {
            assert!(check_host(host).is_err(), "{host:?}");
        }
    }
}
