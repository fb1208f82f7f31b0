//! Puts a flight into the empty page with its script and its style, which the build script packed.

use std::io::Read;

use flate2::read::GzDecoder;

use super::{Assets, ReplayError, fill};
use twin_scenario::markup::escaped;

include!(concat!(env!("OUT_DIR"), "/replay.rs"));

/// The page with the title `name` and the packed flight `flight`.
pub(super) fn filled(name: &str, flight: &str) -> Result<String, ReplayError> {
    let assets = unpacked()?;
    let part = |key: &str| assets.get(key).map(String::as_str).ok_or(ReplayError::NoConsole);
    // The text `</script` would end the script element. In a string of the script `<\/` means the same as `</`.
    let script = part("replay.js")?.replace("</script", "<\\/script");
    let title = format!("<title>{}</title>", escaped(name));
    let parts = [
        ("<title>twin</title>", title.as_str()),
        ("/*replay.css*/", part("replay.css")?),
        ("/*flight*/", flight),
        ("/*replay.js*/", &script),
    ];
    fill(part("replay.html")?, &parts).ok_or(ReplayError::NoConsole)
}

fn unpacked() -> Result<Assets, ReplayError> {
    let mut assets = Assets::new();
    for (name, packed) in REPLAY {
        let mut text = String::new();
        GzDecoder::new(*packed).read_to_string(&mut text)?;
        assets.insert(name, text);
    }
    Ok(assets)
}
