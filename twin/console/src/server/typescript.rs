//! `web/src/protocol.ts` out of the types of [`super::protocol`] (tests only: the file is committed, because the page is
//! built before anything here can run).

use ts_rs::{Config, TS};

use super::protocol as p;
use twin_record::scene as s;

const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../web/src/protocol.ts");

const HEADER: &str = "// Generated from twin/console/src/server/protocol.rs and twin/record/src/scene.rs; do not edit.\n\
    // Refresh: TWIN_UPDATE=1 cargo test --release protocol_ts\n";

fn declaration<T: TS>(config: &Config) -> String {
    let docs = T::docs().unwrap_or_default();
    format!("\n{docs}export {}\n", T::decl(config))
}

fn text() -> String {
    let config = Config::new().with_large_int("number");
    let c = &config;
    let declarations = [
        declaration::<p::ServerMessage>(c),
        declaration::<p::ClientMessage>(c),
        declaration::<p::DisturbanceForm>(c),
        declaration::<p::Hello>(c),
        declaration::<p::QuantityInfo>(c),
        declaration::<p::MirrorInfo>(c),
        declaration::<p::ScenarioInfo>(c),
        declaration::<p::ChannelInfo>(c),
        declaration::<p::GainInfo>(c),
        declaration::<p::GainEcho>(c),
        declaration::<p::GainList>(c),
        declaration::<p::PresetName>(c),
        declaration::<p::StateInfo>(c),
        declaration::<p::TwinInfo>(c),
        declaration::<p::TwinAxis>(c),
        declaration::<twin_foreign::Light>(c),
        declaration::<p::StageCost>(c),
        declaration::<p::FlightPhase>(c),
        declaration::<p::ForkInfo>(c),
        declaration::<p::ForkState>(c),
        declaration::<p::ForkOutcome>(c),
        declaration::<p::ForkChange>(c),
        declaration::<p::ForkMetric>(c),
        declaration::<p::EventInfo>(c),
        declaration::<p::Notice>(c),
        declaration::<p::NoticeLevel>(c),
        declaration::<twin_record::RecordingStatus>(c),
        declaration::<twin_record::RecordingState>(c),
        declaration::<s::Scene>(c),
        declaration::<s::SceneBody>(c),
        declaration::<s::ScenePose>(c),
        declaration::<s::SceneGroup>(c),
        declaration::<s::ShapeInfo>(c),
        declaration::<twin_plant::model::Shape>(c),
        declaration::<s::SceneRotor>(c),
    ];
    format!(
        "{HEADER}\nexport const PROTOCOL_VERSION = {};\n{}",
        p::PROTOCOL_VERSION,
        declarations.concat()
    )
}

#[test]
fn protocol_ts_is_fresh() {
    let wanted = text();
    if std::env::var_os("TWIN_UPDATE").is_some_and(|value| value == "1") {
        std::fs::create_dir_all(std::path::Path::new(FILE).parent().unwrap()).unwrap();
        std::fs::write(FILE, &wanted).unwrap();
    }
    let found = std::fs::read_to_string(FILE).unwrap_or_default();
    assert!(
        found == wanted,
        "web/src/protocol.ts is stale; run TWIN_UPDATE=1 cargo test --release protocol_ts"
    );
}

#[test]
fn every_type_that_is_used_is_declared() {
    let text = text();
    let words = text
        .split(|c: char| !c.is_alphanumeric())
        .filter(|word| word.starts_with(char::is_uppercase));
    for word in words.filter(|word| word.len() > 6 && word.chars().any(char::is_lowercase)) {
        let is_type_name = word.chars().skip(1).any(char::is_uppercase);
        assert!(
            !is_type_name || text.contains(&format!("export type {word} ")),
            "{word} is not declared"
        );
    }
}
