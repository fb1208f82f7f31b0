//! Chooses the best source of every quantity, and puts it on one clock, in ENU and FLU.
//!
//! In: tracks. Out: [`Signals`]: one series per quantity, and the sources in use.

use nalgebra::{SVector, UnitQuaternion};
use serde::Serialize;

use super::attitude::{attitude_of, first, tilt_at_rest, unwrapped, vector};
use super::clock::{Clock, Timebase, common_ns, timebases};
use super::flags::Flags;
use super::frames;
use super::gather::{Gathered, Track};
use super::jumps;
use super::series::{Attitudes, Series, Timing};
use super::topics::Quantity;

/// Lowest rate at which a source is good enough to be differentiated; if no source reaches it, the fastest is taken.
const GOOD_RATE_HZ: f64 = 40.0;

/// Fewest samples of a usable channel.
const FEWEST_SAMPLES: usize = 10;

/// The source of one quantity.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Used {
    /// The quantity.
    pub quantity: Quantity,
    /// Number of its channel.
    #[serde(skip)]
    pub channel: u16,
    /// Its topic.
    pub topic: String,
    /// Its schema.
    pub schema: String,
    /// Its clock.
    pub time: Timebase,
    /// Its rate, gaps and skipped samples.
    pub timing: Timing,
}

/// All quantities that were found, in SI units, ENU and FLU; times in s from the start.
#[derive(Clone, Debug, Default)]
pub struct Signals {
    /// Position of the base, m.
    pub position: Option<Series<3>>,
    /// Attitude `world_from_body`.
    pub attitude: Option<Attitudes>,
    /// Velocity in the world, m/s.
    pub velocity: Option<Series<3>>,
    /// Velocity in the body, m/s.
    pub body_velocity: Option<Series<3>>,
    /// Angular velocity in the body, rad/s.
    pub body_rate: Option<Series<3>>,
    /// Specific force (acceleration minus gravity) in the body frame, m/s².
    pub specific_force: Option<Series<3>>,
    /// Joint angles, rad.
    pub joints: Option<(Vec<String>, Series<2>)>,
    /// Force of the actuators in the body, N.
    pub force: Option<Series<3>>,
    /// Torque of the actuators in the body, N m.
    pub torque: Option<Series<3>>,
    /// Thrust along the body's z axis in an unknown unit, and the quantity that gives it.
    pub thrust: Option<(Quantity, Series<1>)>,
    /// Normalised torque in the body frame.
    pub torque_setpoint: Option<Series<3>>,
    /// Commanded roll, pitch and unwrapped yaw, rad.
    pub attitude_setpoint: Option<Series<3>>,
    /// Battery voltage, V.
    pub battery: Option<Series<1>>,
    /// Whether the autopilot detects that it stands on the ground.
    pub landed: Option<Flags>,
    /// Whether the motors are armed.
    pub armed: Option<Flags>,
    /// The sources in use.
    pub used: Vec<Used>,
    /// Sources that were found and not used, and the reason.
    pub notes: Vec<String>,
    /// Time zero on the common clock, ns.
    pub start_ns: i64,
    /// Rotation from the measured (marker) frame to the body.
    pub body_from_marker: UnitQuaternion<f64>,
}

struct Chooser<'a> {
    tracks: &'a [Track],
    bases: Vec<Timebase>,
    /// The sources chosen for the whole flight, if this is a part of it.
    chosen: Option<&'a Signals>,
    /// Intervals that were not read, s; they are no gaps of the recording.
    unread_s: &'a [(f64, f64)],
    signals: Signals,
}

/// Chooses a source for every quantity and converts its samples.
pub fn signals(gathered: &Gathered) -> Signals {
    signals_of(gathered, &[])
}

/// Signals of stretches of a flight. The intervals `unread_ns` between them, ns of log time, were not read.
pub(super) fn signals_of(gathered: &Gathered, unread_ns: &[(u64, u64)]) -> Signals {
    let bases = timebases(&gathered.tracks);
    let start_ns = gathered
        .tracks
        .iter()
        .zip(&bases)
        .flat_map(|(track, base)| track.samples.iter().map(|sample| common_ns(sample, base)))
        .min()
        .unwrap_or(0);
    let since_start = |ns: u64| i64::try_from(ns).unwrap_or(i64::MAX).saturating_sub(start_ns);
    let unread_s: Vec<(f64, f64)> = unread_ns
        .iter()
        .map(|(from, to)| (since_start(*from) as f64 * 1e-9, since_start(*to) as f64 * 1e-9))
        .collect();
    let signals = Signals { notes: gathered.notes.clone(), start_ns, ..Signals::default() };
    let tracks = &gathered.tracks;
    Chooser { tracks, bases, chosen: None, unread_s: &unread_s, signals }.all()
}

/// Signals of a part of a flight, from the sources `chosen` for the whole flight.
pub(super) fn signals_as(tracks: &[Track], chosen: &Signals) -> Signals {
    let signals = Signals { start_ns: chosen.start_ns, ..Signals::default() };
    let bases = bases_as(tracks, chosen);
    Chooser { tracks, bases, chosen: Some(chosen), unread_s: &[], signals }.all()
}

/// Time base of each track, as it was `chosen` for the whole flight.
pub(super) fn bases_as<'a>(
    tracks: impl IntoIterator<Item = &'a Track>,
    chosen: &Signals,
) -> Vec<Timebase> {
    let base = |track: &Track| {
        let of_channel = || chosen.used.iter().filter(|used| used.channel == track.channel);
        let used = of_channel().find(|u| u.quantity == track.quantity).or(of_channel().next());
        used.map_or(Timebase { clock: Clock::Log, offset_ns: 0, latency_ms: 0.0 }, |used| used.time)
    };
    tracks.into_iter().map(base).collect()
}

impl Chooser<'_> {
    fn all(mut self) -> Signals {
        self.pose();
        self.rates();
        self.joints();
        self.effort();
        self.breaks();
        self.signals.landed = self.flags(Quantity::Landed);
        self.signals.armed = self.flags(Quantity::Armed);
        self.signals
    }

    fn times(&self, number: usize) -> impl Iterator<Item = (f64, &[f64])> + '_ {
        let base = &self.bases[number];
        self.tracks[number].samples.iter().map(move |sample| {
            let ns = common_ns(sample, base).saturating_sub(self.signals.start_ns);
            (ns as f64 * 1e-9, sample.values.as_slice())
        })
    }

    /// Index of the best track of a quantity.
    fn best(&self, wanted: Quantity) -> Option<usize> {
        if let Some(chosen) = self.chosen {
            let used = chosen.used.iter().find(|used| used.quantity == wanted)?;
            let is_it = |t: &Track| t.quantity == wanted && t.channel == used.channel;
            return self.tracks.iter().position(is_it);
        }
        let rate = |number: usize| {
            let times: Vec<f64> = self.times(number).map(|(t_s, _)| t_s).collect();
            let (first_s, last_s) =
                (*times.first()?, times.iter().copied().fold(f64::MIN, f64::max));
            let unread = self.unread_s.iter();
            let unread_s: f64 =
                unread.map(|(from, to)| (to.min(last_s) - from.max(first_s)).max(0.0)).sum();
            let span_s = last_s - first_s - unread_s;
            (span_s > 0.0).then(|| times.len() as f64 / span_s)
        };
        let mut of_quantity = self.tracks.iter().filter(|track| track.quantity == wanted);
        let is_any_alive = of_quantity.any(Track::is_alive);
        let mut fits: Vec<(usize, f64)> = (0..self.tracks.len())
            .filter(|n| self.tracks[*n].quantity == wanted)
            .filter(|n| self.tracks[*n].samples.len() >= FEWEST_SAMPLES)
            // An allocator that idles, or a sensor that is absent, sends zeros; another instance may be alive.
            .filter(|n| !is_any_alive || self.tracks[*n].is_alive())
            .filter_map(|n| Some((n, rate(n)?)))
            .collect();
        fits.sort_by_key(|(n, _)| self.tracks[*n].rank);
        let good = fits.iter().find(|(_, rate)| *rate >= GOOD_RATE_HZ);
        good.or_else(|| fits.iter().max_by(|a, b| a.1.total_cmp(&b.1))).map(|(n, _)| *n)
    }

    fn note_use(&mut self, number: usize, timing: Timing) {
        let track = &self.tracks[number];
        self.signals.used.push(Used {
            quantity: track.quantity,
            channel: track.channel,
            topic: track.topic.clone(),
            schema: track.schema.clone(),
            time: self.bases[number],
            timing,
        });
    }

    fn series<const D: usize>(
        &self,
        number: usize,
        convert: impl Fn(&Track, &[f64]) -> SVector<f64, D>,
    ) -> Series<D> {
        let track = &self.tracks[number];
        let samples = self.times(number).map(|(t_s, values)| (t_s, convert(track, values)));
        // A set-point may stay constant; a measurement does not.
        let commanded = matches!(
            track.quantity,
            Quantity::Force
                | Quantity::Torque
                | Quantity::Thrust
                | Quantity::TorqueSetpoint
                | Quantity::Motors
                | Quantity::Collective
                | Quantity::Joints
                | Quantity::Battery
                | Quantity::Landed
                | Quantity::Armed
                | Quantity::Resets
        );
        if commanded { Series::new(samples) } else { Series::measured(samples) }
    }

    /// A vector quantity. A series of zeros is skipped, because nothing measured it.
    fn vector(&mut self, wanted: Quantity, in_world: bool) -> Option<Series<3>> {
        let number = self.best(wanted)?;
        let series = self.series(number, |track, values| {
            let v = vector(values);
            if in_world {
                frames::world_vector(&v, track.rule.world)
            } else {
                frames::body_vector(&v, track.rule.body)
            }
        });
        let unusable = series.timing().samples < FEWEST_SAMPLES || series.all_zero();
        if unusable && self.chosen.is_none() {
            let topic = &self.tracks[number].topic;
            self.signals.notes.push(format!(
                "{topic}: {wanted:?} is zero or not finite throughout and is not used"
            ));
            return None;
        }
        self.note_use(number, series.timing_read(self.unread_s));
        Some(series)
    }

    fn pose(&mut self) {
        self.signals.position = self.vector(Quantity::Position, true);
        let Some(number) = self.best(Quantity::Quaternion).or_else(|| self.best(Quantity::Euler))
        else {
            return;
        };
        let track = &self.tracks[number];
        let [roll, pitch, yaw] = track.rule.mount_rpy_deg.map(f64::to_radians);
        let marker = UnitQuaternion::from_euler_angles(roll, pitch, yaw);
        self.signals.body_from_marker =
            self.chosen.map_or(marker.inverse(), |chosen| chosen.body_from_marker);
        let mut attitudes = self.attitudes(number);
        if track.rule.level_at_rest && self.chosen.is_none() {
            let note = match tilt_at_rest(&attitudes) {
                Some(tilt) => {
                    self.signals.body_from_marker = (marker * tilt).inverse();
                    attitudes = self.attitudes(number);
                    let (roll, pitch, _) = tilt.euler_angles();
                    format!(
                        "{}: tilted by roll {:.1}, pitch {:.1} degrees at rest, taken as the tilt of the measured frame",
                        track.topic,
                        roll.to_degrees(),
                        pitch.to_degrees()
                    )
                }
                None => format!(
                    "{}: not at rest during its first second, so the tilt of the measured frame is unknown",
                    track.topic
                ),
            };
            self.signals.notes.push(note);
        }
        let track = &self.tracks[number];
        self.note_use(number, attitudes.timing_read(self.unread_s));
        if attitudes.sign_flips > 0 {
            let note =
                format!("{}: quaternion changed sign {} times", track.topic, attitudes.sign_flips);
            self.signals.notes.push(note);
        }
        self.signals.attitude = Some(attitudes);
    }

    /// Attitudes of the body from a track.
    fn attitudes(&self, number: usize) -> Attitudes {
        let track = &self.tracks[number];
        let body_from_marker = &self.signals.body_from_marker;
        let times = self.times(number);
        Attitudes::new(times.map(|(t_s, v)| (t_s, attitude_of(track, v) * body_from_marker)))
    }

    fn rates(&mut self) {
        self.signals.velocity = self.fast(Quantity::Velocity, true);
        if self.signals.velocity.is_none() {
            self.signals.body_velocity = self.fast(Quantity::BodyVelocity, false);
        }
        self.signals.body_rate = self.fast(Quantity::BodyRate, false);
        self.signals.specific_force = self.fast(Quantity::SpecificForce, false);
    }

    /// A rate, if its source is fast enough to be differentiated.
    fn fast(&mut self, wanted: Quantity, in_world: bool) -> Option<Series<3>> {
        let series = self.vector(wanted, in_world)?;
        let rate_hz = series.timing().rate_hz;
        if rate_hz >= GOOD_RATE_HZ || self.chosen.is_some() {
            return Some(series);
        }
        self.signals.used.retain(|used| used.quantity != wanted);
        self.signals.notes.push(format!(
            "{wanted:?} comes at {rate_hz:.1} Hz, too seldom to be used as a rate: it is derived from the pose instead"
        ));
        None
    }

    fn joints(&mut self) {
        let Some(number) = self.best(Quantity::Joints) else { return };
        let series = self.series(number, |_, values| {
            SVector::from_fn(|row: usize, _| values.get(row).copied().unwrap_or(0.0))
        });
        self.note_use(number, series.timing_read(self.unread_s));
        self.signals.joints = Some((self.tracks[number].names.clone(), series));
    }

    /// Breaks pose and rates where the pose jumps, and says so.
    fn breaks(&mut self) {
        let signals = &mut self.signals;
        let found = jumps::of_pose(signals.position.as_ref(), signals.attitude.as_ref());
        if found.is_empty() {
            return;
        }
        let rates = [&mut signals.position, &mut signals.velocity, &mut signals.body_velocity];
        rates.into_iter().flatten().for_each(|series| series.break_at(&found));
        signals.attitude.iter_mut().for_each(|attitudes| attitudes.break_at(&found));
        if self.chosen.is_none() {
            let note = jumps::note(&found, self.resets());
            self.signals.notes.push(note);
        }
    }

    /// Number of times that the estimator set its state anew, if it says so.
    fn resets(&self) -> Option<usize> {
        let number = self.best(Quantity::Resets)?;
        let counts: Vec<f64> = self.times(number).map(|(_, values)| first(values)).collect();
        Some(counts.windows(2).filter(|pair| pair[0].to_bits() != pair[1].to_bits()).count())
    }

    fn flags(&mut self, wanted: Quantity) -> Option<Flags> {
        let number = self.best(wanted)?;
        let flags = Flags::new(self.times(number).map(|(t_s, values)| (t_s, first(values))));
        let series: Series<1> = self.series(number, |_, v| SVector::from([first(v)]));
        self.note_use(number, series.timing());
        Some(flags)
    }

    fn effort(&mut self) {
        self.signals.force = self.vector(Quantity::Force, false);
        self.signals.torque = self.vector(Quantity::Torque, false);
        if self.signals.force.is_none() {
            self.signals.torque_setpoint = self.vector(Quantity::TorqueSetpoint, false);
        }
        if self.signals.torque_setpoint.is_some()
            && let Some(number) = self.best(Quantity::AttitudeSetpoint)
        {
            let track = &self.tracks[number];
            let turned = self.times(number).map(|(t_s, v)| (t_s, attitude_of(track, v)));
            let series = Series::new(unwrapped(turned));
            self.note_use(number, series.timing_read(self.unread_s));
            self.signals.attitude_setpoint = Some(series);
        }
        if let Some(number) = self.best(Quantity::Battery) {
            let series = self.series(number, |_, v| SVector::from([first(v)]));
            self.note_use(number, series.timing_read(self.unread_s));
            self.signals.battery = Some(series);
        }
        for wanted in [Quantity::Thrust, Quantity::Motors, Quantity::Collective] {
            let Some(number) = self.best(wanted).filter(|_| self.signals.thrust.is_none()) else {
                continue;
            };
            let series = self.series(number, |track, values| {
                let along_z = match wanted {
                    Quantity::Thrust => frames::body_vector(&vector(values), track.rule.body).z,
                    // Thrust grows with the square of a normalised motor output.
                    Quantity::Motors => values.iter().map(|u| u * u).sum(),
                    _ => first(values),
                };
                SVector::from([along_z])
            });
            self.note_use(number, series.timing_read(self.unread_s));
            self.signals.thrust = Some((wanted, series));
        }
    }
}
