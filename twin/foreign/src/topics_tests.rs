//! The shipped maps are valid, the right rule is found, and a bad map is refused with its place.

use super::*;

#[test]
fn every_shipped_map_reads_and_the_generic_rules_stand_behind_it() {
    for (name, text) in SHIPPED {
        let map = Map::over_generic(Map::parse(text, name).unwrap()).unwrap();
        assert!(map.rule("/odom", "nav_msgs/msg/Odometry").is_some(), "{name}");
    }
}

#[test]
fn px4_topics_with_a_version_and_a_prefix_are_found_and_mocap_is_a_later_choice_than_the_estimate()
{
    let map = Map::over_generic(Map::default()).unwrap();
    let schema = "px4_msgs/msg/VehicleOdometry";
    let (estimate, rule) = map.rule("/px4_1/fmu/out/vehicle_odometry_v1", schema).unwrap();
    assert_eq!((rule.world, rule.body), (World::Ned, Body::Frd));
    let (mocap, _) = map.rule("/fmu/in/vehicle_visual_odometry", schema).unwrap();
    assert!(estimate < mocap, "{estimate} {mocap}");
    assert!(map.rule("/chatter", "std_msgs/msg/String").is_none());
}

#[test]
fn patterns_match_like_a_shell() {
    for (pattern, text, fits) in [
        ("*", "/a", true),
        ("/a", "/a", true),
        ("/a", "/ab", false),
        ("/a*", "/ab", true),
        ("*b", "/ab", true),
        ("/a*c*e", "/abcde", true),
        ("/a*c*e", "/abde", false),
    ] {
        assert_eq!(glob(pattern, text), fits, "{pattern} {text}");
    }
}

#[test]
fn a_bad_map_is_refused_with_place_finding_and_what_is_allowed() {
    let rule = |rest: &str| format!("[[topic]]\ntopic = \"/x\"\n[topic.gives.position]\n{rest}\n");
    for (text, wanted) in [
        ("topics = 1".to_owned(), vec!["map.toml", "topics"]),
        (rule("paths = [\"x\"]"), vec!["rule 1", "1 paths", "3 expected"]),
        (rule("paths = [\"x\",\"y\",\"z\"]\nunit = \"furlong\""), vec!["furlong", "\"mm\""]),
        (rule("paths = [\"x\",\"y\",\"z[\"]"), vec!["z[", "control[3]"]),
        (rule("paths = [\"x\",\"y\",\"z\"]\nscale = [1.0]"), vec!["1 scales", "3 paths"]),
        (rule("paths = [\"x\",\"y\",\"z\"]\noffset = nan"), vec!["not finite"]),
        ("[vehicle]\nmass_kg = -1.0".to_owned(), vec!["positive", "-1"]),
    ] {
        let error = Map::parse(&text, "map.toml").unwrap_err().to_string();
        for part in wanted {
            assert!(error.contains(part), "{part:?} is missing in: {error}");
        }
    }
}
