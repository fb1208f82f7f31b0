//! Decides when a flight ends, with its verdict and a sentence for the reason.

use super::course::Course;
pub use super::ending::{Verdict, VerdictSettings};
use super::settings::{Settings, TaskKind};
use twin_core::elementary::{acos, cos};
use twin_core::tick::Tick;

/// Watches a flight tick by tick.
#[derive(Clone, Debug)]
pub struct Judge {
    limits: VerdictSettings,
    time_limit_s: f64,
    task: TaskKind,
    place: nalgebra::Vector3<f64>,
    course: Course,
    payload_in_palm: Option<nalgebra::Vector3<f64>>,
}

impl Judge {
    /// A judge for a flight with `settings`.
    pub fn new(settings: &Settings) -> Self {
        Self {
            limits: settings.verdict,
            time_limit_s: settings.time_limit_s,
            task: settings.task.kind,
            place: settings.task.place_position_m.into(),
            course: Course::default(),
            payload_in_palm: None,
        }
    }

    /// The verdict and its reason once the flight is over. The reason also says for how long the rotors were saturated, if that was long.
    pub fn watch(&mut self, tick: &Tick) -> Option<(Verdict, String)> {
        let (verdict, reason) = self.ended(tick)?;
        Some((verdict, reason + &self.course.saturation()))
    }

    fn ended(&mut self, tick: &Tick) -> Option<(Verdict, String)> {
        let t_s = tick.measurement.t_s;
        let Some(truth) = &tick.truth else {
            return tick.finished.then(|| (Verdict::Completed, "the recording ended".to_owned()));
        };
        let finite = truth.chi.iter().chain(&truth.chi_dot).all(|x| x.is_finite());
        if !finite {
            return Some((
                Verdict::NonFinite,
                format!("the state became non-finite at {t_s:.2} s"),
            ));
        }
        self.course.add(tick, truth);
        if let Some(end) =
            lost_vehicle(&self.limits, tick, truth).or_else(|| self.lost_payload(tick, truth))
        {
            return Some(end);
        }
        if let Some(why) = &tick.gave_up {
            return Some((Verdict::GaveUp, why.clone()));
        }
        if tick.finished {
            return Some(self.finished(truth, t_s));
        }
        (t_s >= self.time_limit_s).then(|| {
            (
                Verdict::TimedOut,
                format!("{:.0} s ran out in phase {:?}", self.time_limit_s, tick.phase),
            )
        })
    }

    fn lost_payload(
        &mut self,
        tick: &Tick,
        truth: &twin_core::tick::Truth,
    ) -> Option<(Verdict, String)> {
        let carried = tick.reference.transporting && tick.phase != "lift";
        if !carried || !matches!(self.task, TaskKind::PickPlace | TaskKind::Excitation) {
            self.payload_in_palm = None;
            return None;
        }
        let held = *self.payload_in_palm.get_or_insert(truth.payload_in_palm);
        let moved = (truth.payload_in_palm - held).norm();
        (moved > self.limits.lost_m).then(|| {
            let t_s = tick.measurement.t_s;
            (
                Verdict::Dropped,
                format!("the payload left the hand in phase {:?} at {t_s:.2} s", tick.phase),
            )
        })
    }

    fn finished(&self, truth: &twin_core::tick::Truth, t_s: f64) -> (Verdict, String) {
        let flown = match self.task {
            TaskKind::Hover => "hovered for",
            TaskKind::Path => "followed the path in",
            TaskKind::Excitation => "flew way-points for",
            TaskKind::PickPlace => return self.placed(truth),
        };
        let (error_m, bound_m) = (self.course.error_m(), self.limits.error_m);
        let found = format!("position RMSE {error_m:.3} m, allowed {bound_m} m");
        if self.course.rests() {
            let reason = format!("the vehicle rests on a surface after {t_s:.1} s; {found}");
            (Verdict::Grounded, reason)
        } else if error_m <= bound_m {
            (Verdict::Completed, format!("{flown} {t_s:.1} s; {found}"))
        } else {
            (
                Verdict::OffCourse,
                format!("the vehicle strayed from its reference in {t_s:.1} s; {found}"),
            )
        }
    }

    fn placed(&self, truth: &twin_core::tick::Truth) -> (Verdict, String) {
        let error_m = (truth.payload_position - self.place).xy().norm();
        let height_m = (truth.payload_position.z - self.place.z).abs();
        let found = format!(
            "{:.0} mm from its place, {:.1}° tilted, at {:.3} m/s",
            error_m * 1e3,
            truth.payload_tilt_rad.to_degrees(),
            truth.payload_speed_m_s
        );
        let limits = &self.limits;
        let good = error_m <= limits.placed_m
            && height_m <= limits.placed_height_m
            && truth.payload_tilt_rad <= limits.placed_tilt_rad
            && truth.payload_speed_m_s <= limits.placed_speed_m_s;
        if good {
            (Verdict::Completed, format!("payload placed {found}"))
        } else {
            (
                Verdict::Misplaced,
                format!("payload ended {found}, {:.0} mm off in height", height_m * 1e3),
            )
        }
    }
}

/// The verdict if the vehicle tipped over, hit something or left the arena.
fn lost_vehicle(
    limits: &VerdictSettings,
    tick: &Tick,
    truth: &twin_core::tick::Truth,
) -> Option<(Verdict, String)> {
    let t_s = tick.measurement.t_s;
    let tilt = acos((cos(truth.chi[3]) * cos(truth.chi[4])).clamp(-1.0, 1.0));
    if tilt > limits.tipped_rad {
        return Some((
            Verdict::Crashed,
            format!("the vehicle tipped over ({:.0}°) at {t_s:.2} s", tilt.to_degrees()),
        ));
    }
    if truth.collision_force_n > limits.crash_n {
        let force = truth.collision_force_n;
        return Some((
            Verdict::Crashed,
            format!("the vehicle hit something with {force:.0} N at {t_s:.2} s"),
        ));
    }
    let distance = truth.chi.fixed_rows::<3>(0).norm();
    (distance > limits.arena_radius_m).then(|| {
        (
            Verdict::FlewAway,
            format!("the vehicle was {distance:.1} m from the origin at {t_s:.2} s"),
        )
    })
}
