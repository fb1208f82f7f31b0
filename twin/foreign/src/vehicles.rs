//! Which vehicle a topic belongs to, and which of several vehicles is mirrored.
//!
//! In: the tracks of a recording. Out: the tracks of one vehicle, and what was found of each. Two vehicles are never mixed.

use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;

use super::gather::{Gathered, Track};
use super::recorded::{MirrorError, on_ticks};
use super::signals::signals;
use super::topics::VehicleFacts;
use twin_core::notation::TICK_S;

/// Parts of a topic that say which software sends it; the vehicle is what stands before.
const STACKS: [&str; 2] = ["fmu", "mavros"];

/// What was found of one vehicle.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct VehicleFound {
    /// Namespace of its topics, such as `/px4_1`.
    pub namespace: String,
    /// Time for which it is in the air, s; `None` if no flight could be made of its messages.
    pub air_s: Option<f64>,
    /// Whether it is mirrored.
    pub used: bool,
}

/// The parts of a topic.
fn parts(topic: &str) -> Vec<&str> {
    topic.split('/').filter(|part| !part.is_empty()).collect()
}

/// The namespace before `count` parts of a topic, as `/px4_1`.
fn namespace(parts: &[&str], count: usize) -> String {
    format!("/{}", parts[..count].join("/"))
}

/// Vehicle of each topic; `None` where a topic belongs to no vehicle in particular. Beside the known stacks, topics that differ in one
/// part alone (`/drone1/odom`, `/drone2/odom`) belong to different vehicles.
fn vehicles(topics: &[(&str, &str)]) -> Vec<Option<String>> {
    let split: Vec<Vec<&str>> = topics.iter().map(|(topic, _)| parts(topic)).collect();
    let stack = |parts: &Vec<&str>| parts.iter().position(|part| STACKS.contains(part));
    // Names at one place of topics that are equal elsewhere, of one schema.
    let mut names: BTreeMap<(String, usize, &str), BTreeSet<&str>> = BTreeMap::new();
    let key = |parts: &Vec<&str>, at: usize| {
        let mut rest = parts.clone();
        rest[at] = "";
        rest.join("/")
    };
    for (parts, (_, schema)) in split.iter().zip(topics).filter(|(parts, _)| stack(parts).is_none())
    {
        for at in 0..parts.len().saturating_sub(1) {
            names.entry((key(parts, at), at, schema)).or_default().insert(parts[at]);
        }
    }
    let of = |(parts, (_, schema)): (&Vec<&str>, &(&str, &str))| {
        if let Some(at) = stack(parts) {
            return Some(namespace(parts, at));
        }
        let differs = |at: &usize| {
            names.get(&(key(parts, *at), *at, schema)).is_some_and(|names| names.len() > 1)
        };
        let at = (0..parts.len().saturating_sub(1)).find(differs)?;
        Some(namespace(parts, at + 1))
    };
    split.iter().zip(topics).map(of).collect()
}

/// The tracks of the vehicle that `facts` ask for, or of the one that is in the air for longest, with what was found of each vehicle. The
/// tracks of no vehicle in particular stay.
///
/// # Errors
/// [`MirrorError::NoVehicle`] if there is no vehicle of the name that is asked for.
pub(super) fn one(
    mut gathered: Gathered,
    facts: &VehicleFacts,
) -> Result<(Gathered, Vec<VehicleFound>), MirrorError> {
    let topics: Vec<(&str, &str)> =
        gathered.tracks.iter().map(|track| (&*track.topic, &*track.schema)).collect();
    let of = vehicles(&topics);
    let names: BTreeSet<&String> = of.iter().flatten().collect();
    let wanted = facts.namespace.as_deref();
    if let Some(wanted) = wanted
        && !names.iter().any(|name| *name == wanted)
    {
        let found = names.into_iter().cloned().collect::<Vec<_>>();
        return Err(MirrorError::NoVehicle { wanted: wanted.to_owned(), found: found.join(", ") });
    }
    if names.len() < 2 {
        let all =
            |name: &&String| VehicleFound { namespace: (*name).clone(), air_s: None, used: true };
        let found = names.iter().map(all).collect();
        return Ok((gathered, found));
    }
    let own = |name: &str| -> Vec<bool> {
        of.iter().map(|of| of.as_deref().is_none_or(|of| of == name)).collect()
    };
    let mut found: Vec<VehicleFound> = names
        .iter()
        .map(|name| {
            let air_s = air_s(&gathered, &own(name), facts);
            VehicleFound { namespace: (*name).clone(), air_s, used: false }
        })
        .collect();
    let longest = |a: &&mut VehicleFound, b: &&mut VehicleFound| {
        a.air_s.unwrap_or(-1.0).total_cmp(&b.air_s.unwrap_or(-1.0))
    };
    let chosen = match wanted {
        Some(wanted) => found.iter_mut().find(|vehicle| vehicle.namespace == wanted),
        None => found.iter_mut().max_by(longest),
    };
    let Some(chosen) = chosen else { return Ok((gathered, found)) };
    chosen.used = true;
    let name = chosen.namespace.clone();
    let mut keep = own(&name).into_iter();
    gathered.tracks.retain(|_| keep.next().unwrap_or(true));
    let said: Vec<String> = found.iter().map(VehicleFound::words).collect();
    gathered.notes.push(format!(
        "{} vehicles in the recording: {}; {name} is mirrored{}",
        found.len(),
        said.join(", "),
        if wanted.is_some() { "" } else { ", --vehicle chooses another" }
    ));
    Ok((gathered, found))
}

impl VehicleFound {
    fn words(&self) -> String {
        let air =
            self.air_s.map_or("without a pose".to_owned(), |s| format!("{s:.1} s in the air"));
        format!("{} ({air})", self.namespace)
    }
}

/// Time in the air of the tracks that are `own`, s; `None` if they contain no flight.
fn air_s(gathered: &Gathered, own: &[bool], facts: &VehicleFacts) -> Option<f64> {
    let tracks = gathered.tracks.iter().zip(own).filter(|(_, own)| **own);
    let tracks: Vec<Track> = tracks.map(|(track, _)| track.clone()).collect();
    let flight = on_ticks(&signals(&Gathered { tracks, notes: Vec::new() }), facts).ok()?;
    Some(flight.airborne.iter().filter(|flies| **flies).count() as f64 * TICK_S)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(topics: &[&str]) -> Vec<Option<String>> {
        let topics: Vec<(&str, &str)> = topics.iter().map(|topic| (*topic, "schema")).collect();
        vehicles(&topics)
    }

    #[test]
    fn a_vehicle_is_what_stands_before_its_stack_or_the_part_in_which_topics_differ() {
        let some = |name: &str| Some(name.to_owned());
        assert_eq!(
            of(&["/px4_1/fmu/out/odometry", "/a/b/mavros/odom", "/fmu/in/odometry"]),
            [some("/px4_1"), some("/a/b"), some("/")]
        );
        assert_eq!(
            of(&["/drone1/odom", "/drone2/odom", "/clock"]),
            [some("/drone1"), some("/drone2"), None]
        );
        assert_eq!(
            of(&["/vicon/uav/pose", "/vicon/box/pose"]),
            [some("/vicon/uav"), some("/vicon/box")]
        );
    }

    #[test]
    fn topics_of_one_vehicle_are_not_told_apart_by_their_last_part() {
        assert_eq!(of(&["/vrpn_mocap/uav/pose", "/control/thrust", "/tf"]), [None, None, None]);
        assert_eq!(of(&["/uav/odom", "/uav/odom_filtered"]), [None, None]);
    }
}
