//! A map: the table from topic and schema to quantity, unit, frame and time. `maps/*.toml` and any file of the same form hold
//! one.
//!
//! In: TOML. Out: a [`Map`]. The first rule that matches a channel says which quantities its messages give. Earlier rules are
//! better sources.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use serde::{Deserialize, Serialize};

use super::pattern::{glob, names};
use super::schema::short;
use super::value::Path;

/// The rules for messages that many software stacks use.
const GENERIC: &str = include_str!("maps/generic.toml");

/// Maps that come with the program, by name.
pub const SHIPPED: [(&str, &str); 3] = [
    ("acsl_x8", include_str!("maps/acsl_x8.toml")),
    ("crazyflie", include_str!("maps/crazyflie.toml")),
    ("px4_arm", include_str!("maps/px4_arm.toml")),
];

/// The generic rules, parsed once.
static GENERIC_MAP: LazyLock<Result<Map, MapError>> =
    LazyLock::new(|| Map::parse(GENERIC, "generic map"));
static SHIPPED_MAPS: LazyLock<Vec<(&str, Map)>> = LazyLock::new(|| {
    SHIPPED.iter().filter_map(|(name, text)| Some((*name, Map::parse(text, name).ok()?))).collect()
});

/// A map: the rules for messages, and facts about the vehicle.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Map {
    /// Facts about the vehicle.
    pub vehicle: VehicleFacts,
    /// Topics that identify the family: a recording with a channel of one of these topics belongs to it.
    pub detect: Vec<String>,
    /// Rules, the best source first.
    pub topic: Vec<Rule>,
}

/// Facts about a vehicle that no message contains.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct VehicleFacts {
    /// Name of the vehicle.
    pub name: String,
    /// Mass, kg; without it forces are per kilogram.
    pub mass_kg: Option<f64>,
    /// Principal inertia about the body axes, kg m²; without it the torques of normalised set-points are per kg m².
    pub inertia_kg_m2: Option<[f64; 3]>,
    /// Namespace of its topics, if the recording has several vehicles [default: the one that is in the air for longest].
    pub namespace: Option<String>,
    /// Names of the joints that become the coordinates q1 and q2 [default: the first two].
    pub joints: Vec<String>,
}

/// The quantities that the messages of one kind of channel give.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rule {
    /// Pattern of the topic; `*` matches any part [default: any].
    #[serde(default = "any")]
    pub topic: String,
    /// Pattern of the schema, such as `nav_msgs/msg/Odometry` [default: any].
    #[serde(default = "any")]
    pub schema: String,
    /// A field that the definition of the message must name, for messages whose fields changed under one name [default: any].
    #[serde(default)]
    pub has: String,
    /// Axes of the world.
    #[serde(default)]
    pub world: World,
    /// Axes of the body.
    #[serde(default)]
    pub body: Body,
    /// Source of the time of a message.
    #[serde(default)]
    pub time: TimeSource,
    /// Roll, pitch and yaw of the measured frame in the body frame, degrees, for a marker that is not mounted level.
    #[serde(default)]
    pub mount_rpy_deg: [f64; 3],
    /// True if the vehicle stands level during the first second; the tilt that is measured then is the tilt of the measured
    /// frame.
    #[serde(default)]
    pub level_at_rest: bool,
    /// The quantities and their fields.
    pub gives: BTreeMap<Quantity, Fields>,
}

fn any() -> String {
    "*".to_owned()
}

/// Axes of a world frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum World {
    /// East, north, up (or any frame with z up).
    #[default]
    Enu,
    /// North, east, down.
    Ned,
}

/// Axes of a body frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Body {
    /// Forward, left, up.
    #[default]
    Flu,
    /// Forward, right, down.
    Frd,
}

/// Source of the time of a message.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case", tag = "from", deny_unknown_fields)]
pub enum TimeSource {
    /// Log time.
    #[default]
    Log,
    /// A `builtin_interfaces/Time` at `path`.
    Stamp {
        /// Path of the stamp.
        path: String,
    },
    /// A number of microseconds at `path`.
    Microseconds {
        /// Path of the number.
        path: String,
    },
}

/// A quantity that a message can give. The last number is the count of values.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Quantity {
    /// Position of the base in the world, 3.
    Position,
    /// Attitude quaternion world-from-body, w x y z.
    Quaternion,
    /// Attitude as ZYX Euler angles roll, pitch, yaw.
    Euler,
    /// Velocity of the base, 3, in the world.
    Velocity,
    /// Velocity of the base, 3, in the body.
    BodyVelocity,
    /// Angular velocity in the body, 3.
    BodyRate,
    /// What an accelerometer reads: acceleration less gravity in the body, m/s², 3.
    SpecificForce,
    /// Force of the actuators in the body, N, 3.
    Force,
    /// Torque of the actuators in the body, N m, 3.
    Torque,
    /// Normalised thrust in the body, 3.
    Thrust,
    /// Normalised torque in the body, 3.
    TorqueSetpoint,
    /// Commanded attitude world-from-body, w x y z.
    AttitudeSetpoint,
    /// Collective thrust in any unit, 1.
    Collective,
    /// Normalised motor outputs, any number; outputs that are not finite belong to no motor.
    Motors,
    /// Joint angles: names, then positions.
    Joints,
    /// Battery voltage, V, 1.
    Battery,
    /// 1 where the autopilot detects that it stands on the ground, else 0, 1.
    Landed,
    /// 1 where the motors are armed, else 0, 1.
    Armed,
    /// Number of times that the estimator set its state anew, 1.
    Resets,
}

impl Quantity {
    /// Number of values in one sample; `None` if any number is allowed.
    pub fn width(self) -> Option<usize> {
        match self {
            Self::Quaternion | Self::AttitudeSetpoint => Some(4),
            Self::Collective | Self::Battery | Self::Landed | Self::Armed | Self::Resets => Some(1),
            Self::Motors | Self::Joints => None,
            _ => Some(3),
        }
    }
}

/// The position of a quantity in a message, and the meaning of its numbers.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fields {
    /// Paths of the numbers, in order.
    pub paths: Vec<String>,
    /// Unit of the numbers: one of [`UNITS`] [default: SI].
    #[serde(default)]
    pub unit: String,
    /// Factor for each number, applied after the unit; it may change the sign.
    #[serde(default)]
    pub scale: Vec<f64>,
    /// Offset for each number, added after scaling.
    #[serde(default)]
    pub offset: f64,
    /// Limits that clip the numbers after scaling and offset.
    #[serde(default)]
    pub clip: Option<[f64; 2]>,
    /// Conditions on other fields: only messages that meet them give the quantity.
    #[serde(default)]
    pub only_if: Option<Condition>,
}

/// A condition: a field must have one of some values.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Condition {
    /// Path of the field.
    pub path: String,
    /// Allowed values.
    pub is: Vec<f64>,
}

/// Units that a map may name, with their factors to SI.
pub const UNITS: [(&str, f64); 16] = [
    ("", 1.0),
    ("1", 1.0),
    ("m", 1.0),
    ("m/s", 1.0),
    ("m/s2", 1.0),
    ("g", 9.806_65),
    ("rad", 1.0),
    ("rad/s", 1.0),
    ("N", 1.0),
    ("N m", 1.0),
    ("V", 1.0),
    ("mm", 1e-3),
    ("mm/s", 1e-3),
    ("deg", std::f64::consts::PI / 180.0),
    ("deg/s", std::f64::consts::PI / 180.0),
    ("mV", 1e-3),
];

/// Why a map cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum MapError {
    /// The text is not TOML, or not of the form of a map.
    #[error("{place}: {why}")]
    Form {
        /// Source of the map.
        place: String,
        /// Message of the parser, with line and key.
        why: String,
    },
    /// A value is not allowed.
    #[error("{place}: topic rule {rule} ({topic}): {why}")]
    Value {
        /// Source of the map.
        place: String,
        /// Number of the rule, from 1.
        rule: usize,
        /// Topic or schema of the rule.
        topic: String,
        /// The value that was found, and the allowed values.
        why: String,
    },
}

impl Map {
    /// Parses the map in `text`; `place` names its source in errors.
    ///
    /// # Errors
    /// [`MapError`], which names line and key, or rule and value.
    pub fn parse(text: &str, place: &str) -> Result<Self, MapError> {
        let map: Self = toml::from_str(text)
            .map_err(|error| MapError::Form { place: place.to_owned(), why: error.to_string() })?;
        for (number, rule) in map.topic.iter().enumerate() {
            rule.check().map_err(|why| MapError::Value {
                place: place.to_owned(),
                rule: number + 1,
                topic: format!("{} {}", rule.topic, rule.schema),
                why,
            })?;
        }
        let facts = &map.vehicle;
        let positive = facts.mass_kg.iter().chain(facts.inertia_kg_m2.iter().flatten());
        if let Some(bad) = positive.copied().find(|v| !(v.is_finite() && *v > 0.0)) {
            let why = format!("vehicle: mass and inertia must be positive, found {bad}");
            return Err(MapError::Form { place: place.to_owned(), why });
        }
        Ok(map)
    }

    /// A map with the rules of `own` first, then the generic rules.
    ///
    /// # Errors
    /// [`MapError`] if the generic rules are broken.
    pub fn over_generic(own: Self) -> Result<Self, MapError> {
        let mut map = own;
        match &*GENERIC_MAP {
            Ok(generic) => map.topic.extend(generic.topic.iter().cloned()),
            Err(_) => return Self::parse(GENERIC, "generic map"),
        }
        Ok(map)
    }

    /// Name of the shipped map for a recording with these topics; `None` if no family is recognised.
    pub fn detect(topics: &[&str]) -> Option<&'static str> {
        let fits = |map: &Self| {
            topics.iter().any(|topic| map.detect.iter().any(|pattern| glob(pattern, topic)))
        };
        SHIPPED_MAPS.iter().find(|(_, map)| fits(map)).map(|(name, _)| *name)
    }

    /// The name of two that comes first among the shipped maps.
    pub(super) fn first_of<'a>(one: Option<&'a str>, other: Option<&'a str>) -> Option<&'a str> {
        let place = |name: &&str| SHIPPED.iter().position(|(known, _)| known == name);
        one.into_iter().chain(other).min_by_key(place)
    }

    /// The shipped map called `name`.
    pub fn shipped(name: &str) -> Option<Self> {
        SHIPPED_MAPS.iter().find(|(known, _)| *known == name).map(|(_, map)| map.clone())
    }

    /// The first rule that matches a channel, with its index.
    pub fn rule(&self, topic: &str, schema: &str) -> Option<(usize, &Rule)> {
        self.topic.iter().enumerate().find(|(_, rule)| rule.fits(topic, schema))
    }

    /// The first rule that matches a channel whose messages have this `definition`, with its index.
    pub fn rule_for(&self, topic: &str, schema: &str, definition: &[u8]) -> Option<(usize, &Rule)> {
        let named = |rule: &Rule| rule.has.is_empty() || names(definition, &rule.has);
        self.topic.iter().enumerate().find(|(_, rule)| rule.fits(topic, schema) && named(rule))
    }
}

impl Rule {
    fn fits(&self, topic: &str, schema: &str) -> bool {
        glob(&self.topic, topic) && glob(&short(&self.schema), &short(schema))
    }

    fn check(&self) -> Result<(), String> {
        match &self.time {
            TimeSource::Log => {}
            TimeSource::Stamp { path } | TimeSource::Microseconds { path } => {
                Path::parse(path)?;
            }
        }
        for (quantity, fields) in &self.gives {
            fields.check(*quantity).map_err(|why| format!("gives.{quantity:?}: {why}"))?;
        }
        Ok(())
    }
}

impl Fields {
    /// Factor from the unit to SI.
    pub fn factor(&self) -> f64 {
        UNITS.iter().find(|(name, _)| *name == self.unit).map_or(1.0, |(_, factor)| *factor)
    }

    fn check(&self, quantity: Quantity) -> Result<(), String> {
        for path in &self.paths {
            Path::parse(path)?;
        }
        let wanted = match quantity {
            Quantity::Joints => Some(2),
            Quantity::Motors => None,
            other => other.width(),
        };
        if let Some(wanted) = wanted.filter(|wanted| *wanted != self.paths.len()) {
            return Err(format!("{} paths given, {wanted} expected", self.paths.len()));
        }
        if !UNITS.iter().any(|(name, _)| *name == self.unit) {
            let known = UNITS.map(|(name, _)| format!("{name:?}")).join(", ");
            return Err(format!("unit {:?} is unknown, known are {known}", self.unit));
        }
        if !self.scale.is_empty() && self.scale.len() != self.paths.len() {
            let (found, wanted) = (self.scale.len(), self.paths.len());
            return Err(format!("{found} scales given for {wanted} paths"));
        }
        let numbers = self.scale.iter().chain([&self.offset]).chain(self.clip.iter().flatten());
        if !numbers.copied().all(f64::is_finite) {
            return Err("a scale, offset or limit is not finite".to_owned());
        }
        match self.clip {
            Some([low, high]) if low > high => Err(format!("clip [{low}, {high}] is empty")),
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
#[path = "topics_tests.rs"]
mod tests;
